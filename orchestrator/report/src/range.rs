//! The range of the results of a scene: what `cofferdam range` found, for other programs and for the report of a run.

use cofferdam_motion::text_file;
use cofferdam_scene::Scene;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the spread due to a factor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FactorKind {
    /// An error of the computation: mesh, steps, reduction.
    Numerics,
    /// The sensitivity to perturbations of the ground motion.
    Motion,
    /// A choice of the model, or a property that is not known better.
    Model,
    /// Other records with the same peak acceleration.
    Records,
}

impl FactorKind {
    /// All, in the order of the tables.
    pub const ALL: [Self; 4] = [Self::Numerics, Self::Motion, Self::Model, Self::Records];

    /// What a number of this kind is called.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Numerics => "numerical error",
            Self::Motion => "perturbed motion",
            Self::Model => "range of models",
            Self::Records => "range of records",
        }
    }
}

/// A factor: what was varied, how far and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangeFactor {
    /// Its name.
    pub name: String,
    /// What its spread is.
    pub kind: FactorKind,
    /// Its range, in words.
    pub range: String,
    /// The reason for the range.
    pub reason: String,
    /// Whether it varies in the joint sample.
    pub joint: bool,
}

/// A factor, or a setting of one, that the scene does not have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The factor or setting.
    pub what: String,
    /// The reason.
    pub reason: String,
}

/// A run without results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailedRun {
    /// Its settings.
    pub run: String,
    /// The cause.
    pub cause: String,
}

/// A quantity at a setting of a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The setting.
    pub setting: String,
    /// The value.
    pub value: f64,
}

/// The lowest and highest value of a quantity among the settings of one factor, all else being as in the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// The factor.
    pub factor: String,
    /// What its spread is.
    pub kind: FactorKind,
    /// The setting with the lowest value.
    pub low: Setting,
    /// The setting with the highest value.
    pub high: Setting,
}

impl Swing {
    /// From the lowest value to the highest, that of the scene included.
    pub fn interval(&self, as_it_is: f64) -> [f64; 2] {
        [self.low.value.min(as_it_is), self.high.value.max(as_it_is)]
    }

    /// The length of this interval.
    pub fn size(&self, as_it_is: f64) -> f64 {
        let [low, high] = self.interval(as_it_is);
        high - low
    }
}

/// Part of the variance of the joint sample's ranks that follows a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VarianceShare {
    /// The factor.
    pub factor: String,
    /// Its share, from 0 to 1, less that of chance.
    pub share: f64,
    /// Whether chance alone would give as much in less than 5 % of samples.
    pub significant: bool,
}

/// The quantity over all runs of the joint sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Combined {
    /// Number of runs that have it.
    pub runs: usize,
    /// Its 5 and 95 % quantiles.
    pub interval: [f64; 2],
    /// Its smallest and largest value.
    pub extremes: [f64; 2],
    /// Shares of the factors, the largest first; empty if there are too few runs, or if the quantity does not vary.
    pub shares: Vec<VarianceShare>,
}

/// A quantity and its range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangeQuantity {
    /// Its name.
    pub name: String,
    /// Unit of all its values.
    pub unit: String,
    /// Value of the scene as it is.
    pub as_it_is: f64,
    /// Unit of the last digit that is shown: a tenth of the spread, rounded down to a power of ten.
    pub last_digit: f64,
    /// One factor at a time, the largest swing first.
    pub swings: Vec<Swing>,
    /// The joint sample; none without one, or if fewer than two of its runs have the quantity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub combined: Option<Combined>,
}

impl RangeQuantity {
    /// A value with the digits that are known.
    pub fn shown(&self, value: f64) -> String {
        if value.is_infinite() {
            return "∞ (slides away)".to_owned();
        }
        let digits = (-self.last_digit.log10().round()).clamp(0.0, 12.0) as usize;
        let rounded = (value / self.last_digit).round() * self.last_digit;
        // No negative zero.
        format!("{:.digits$}", rounded + 0.0)
    }

    /// An interval with the digits that are known, such as `26 to 73`.
    pub fn shown_interval(&self, [low, high]: [f64; 2]) -> String {
        format!("{} to {}", self.shown(low), self.shown(high))
    }

    /// Whether any run differs from the scene as it is in the digits that are shown.
    pub fn varies(&self) -> bool {
        let extremes = self.combined.iter().map(|all| all.extremes);
        let of_all = self.swings.iter().map(|swing| swing.interval(self.as_it_is)).chain(extremes);
        of_all.flatten().any(|value| self.shown(value) != self.shown(self.as_it_is))
    }

    /// From the lowest value to the highest with one factor of this kind at a time; none without such a factor.
    pub fn interval_of(&self, kind: FactorKind) -> Option<[f64; 2]> {
        let of_kind = self.swings.iter().filter(|swing| swing.kind == kind);
        let intervals = of_kind.map(|swing| swing.interval(self.as_it_is));
        intervals.reduce(|[a, b], [low, high]| [a.min(low), b.max(high)])
    }

    /// What dominates: the factors that stand out from chance in the joint sample with their shares, or without shares the largest
    /// swings; three at most. Nothing dominates a quantity that does not vary.
    pub fn dominant(&self) -> Vec<String> {
        if !self.varies() {
            return Vec::new();
        }
        match self.combined.as_ref().filter(|combined| !combined.shares.is_empty()) {
            Some(combined) => {
                let standing_out = combined.shares.iter().filter(|share| share.significant).take(3);
                standing_out.map(|share| format!("{} ({:.0} %)", share.factor, 100.0 * share.share)).collect()
            }
            None => {
                let moving = self.swings.iter().filter(|swing| swing.size(self.as_it_is) > 0.0);
                moving.take(3).map(|swing| swing.factor.clone()).collect()
            }
        }
    }
}

/// Contents of `range.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangeRecord {
    /// Name of the case.
    pub name: String,
    /// Version of the program.
    pub version: String,
    /// The model of the dam in the runs.
    pub model: String,
    /// Runs of the joint sample; 0 for none.
    pub samples: usize,
    /// Seed of the joint sample and of the noise.
    pub seed: u64,
    /// All runs.
    pub runs: usize,
    /// Runs without results.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<FailedRun>,
    /// What is doubtful about the runs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// What was varied.
    pub factors: Vec<RangeFactor>,
    /// What does not apply to the scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// The quantities.
    pub quantities: Vec<RangeQuantity>,
    /// The scene with all defaults.
    pub scene: Scene,
}

/// A range that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RangeError {
    /// The file cannot be read.
    #[error("{}: {cause}; give the folder that `cofferdam range` wrote", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
    /// The content is no range, or one of another version.
    #[error("{}: {cause}; run `cofferdam range` again", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
    /// The range of another scene.
    #[error(
        "{} is the range of another scene: it differs from that of the run in {}; run `cofferdam range` with the scene of the run",
        path.display(), keys.join(", ")
    )]
    OtherScene {
        /// The file.
        path: PathBuf,
        /// Keys that differ.
        keys: Vec<String>,
    },
}

/// Tables and keys that change nothing of the results, or follow from others.
const WITHOUT_INFLUENCE: [&str; 9] = [
    "title",
    "scene_version",
    "log",
    "snapshots",
    "stop",
    "accuracy",
    "stability",
    "dam.envelopes",
    // its hash is compared
    "ground_motion.record.file",
];

impl RangeRecord {
    /// Name of the file in the folder of a range.
    pub const FILE: &str = "range.toml";

    /// Reads the range in `folder`.
    ///
    /// **Errors**: [`RangeError::Read`], [`RangeError::Decode`].
    pub fn read(folder: &Path) -> Result<Self, RangeError> {
        let path = folder.join(Self::FILE);
        let text = match text_file::read(&path) {
            Ok(text) => text,
            Err(cause) => return Err(RangeError::Read { path, cause }),
        };
        toml::from_str(&text).map_err(|error| RangeError::Decode { path, cause: error.message().to_owned() })
    }

    /// Reads the range in `folder`, which must be one of `scene`; what changes no result may differ.
    ///
    /// **Errors**: [`RangeError`].
    pub fn of_scene(folder: &Path, scene: &Scene) -> Result<Self, RangeError> {
        let range = Self::read(folder)?;
        match differing(&range.scene, scene) {
            keys if keys.is_empty() => Ok(range),
            keys => Err(RangeError::OtherScene { path: folder.join(Self::FILE), keys }),
        }
    }

    /// The range of the quantity of a run's summary; that of the crest has no direction.
    pub fn of_quantity(&self, name: &str) -> Option<&RangeQuantity> {
        self.quantities.iter().find(|quantity| {
            let rest = name.strip_prefix(&quantity.name);
            rest.is_some_and(|rest| ["", " downstream", " upstream"].contains(&rest))
        })
    }
}

/// Keys with an influence on the results in which two scenes differ, in the order of the alphabet.
fn differing(a: &Scene, b: &Scene) -> Vec<String> {
    let [a, b] = [a, b].map(|scene| {
        let mut keys = BTreeMap::new();
        if let Ok(value) = toml::Value::try_from(scene) {
            flatten(&value, "", &mut keys);
        }
        keys
    });
    let all: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    all.into_iter().filter(|key| a.get(*key) != b.get(*key)).cloned().collect()
}

/// Adds the values in `value` with their keys below `key`.
fn flatten(value: &toml::Value, key: &str, keys: &mut BTreeMap<String, toml::Value>) {
    if WITHOUT_INFLUENCE.contains(&key) || key == "ground_motion.vertical.file" {
        return;
    }
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(name, value)| flatten(value, &below(name), keys));
        }
        toml::Value::Array(array) if array.iter().any(toml::Value::is_table) => {
            let numbered = array.iter().enumerate();
            numbered.for_each(|(index, value)| flatten(value, &below(&index.to_string()), keys));
        }
        value => {
            keys.insert(key.to_owned(), value.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(as_it_is: f64, last_digit: f64) -> RangeQuantity {
        let swing = |factor: &str, kind, low, high| Swing {
            factor: factor.to_owned(),
            kind,
            low: Setting { setting: "a".to_owned(), value: low },
            high: Setting { setting: "b".to_owned(), value: high },
        };
        RangeQuantity {
            name: "residual sliding".to_owned(),
            unit: "mm".to_owned(),
            as_it_is,
            last_digit,
            swings: vec![
                swing("damping ratio", FactorKind::Model, 26.0, 73.0),
                swing("plane", FactorKind::Model, 40.0, 44.0),
                swing("element size", FactorKind::Numerics, 44.0, 44.0),
            ],
            combined: None,
        }
    }

    #[test]
    fn numbers_have_the_digits_that_are_known() {
        assert_eq!(quantity(42.0, 1.0).shown_interval([26.26, 73.5]), "26 to 74");
        assert_eq!(quantity(42.0, 0.01).shown(1.0049), "1.00");
        assert_eq!(quantity(420.0, 10.0).shown(426.0), "430");
        assert_eq!(quantity(42.0, 1.0).shown(-0.2), "0");
    }

    #[test]
    fn intervals_of_a_kind_hold_the_scene_as_it_is_and_swings_dominate_without_a_sample() {
        let sliding = quantity(42.0, 1.0);
        assert_eq!(sliding.interval_of(FactorKind::Model), Some([26.0, 73.0]));
        assert_eq!(sliding.interval_of(FactorKind::Numerics), Some([42.0, 44.0]));
        assert_eq!(sliding.interval_of(FactorKind::Records), None);
        assert_eq!(sliding.dominant(), ["damping ratio", "plane", "element size"]);
        let coarse = quantity(42.0, 1000.0);
        assert!(sliding.varies() && !coarse.varies());
        assert_eq!(coarse.dominant(), [""; 0]);
    }

    #[test]
    fn scenes_are_equal_but_for_what_changes_no_result() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/koyna-coarse/scene.toml");
        let text = std::fs::read_to_string(&file).expect("a shipped scene");
        let scene = |overrides: &[&str]| {
            let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
            Scene::resolved(&text, &overrides, &file).expect("a scene")
        };
        let same = scene(&["title=\"another\"", "dam.envelopes=false", "log.exchanges=\"none\""]);
        assert_eq!(differing(&scene(&[]), &same), [""; 0]);
        let other = scene(&["dam.damping.ratio=0.03", "dam.cracks.0.friction_coefficient=0.9"]);
        assert_eq!(
            differing(&scene(&[]), &other),
            ["dam.cracks.0.friction_coefficient", "dam.damping.ratio"]
        );
    }
}
