//! The file of an ensemble: what is varied.

mod check;
mod intensity;
mod samples;
mod variation;

pub use intensity::{Intensity, Measure, Target};
pub use samples::Sample;
pub use variation::Variation;

use super::EnsembleError;
use cofferdam_motion::Units;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest level of shaking, g: no record was stronger.
pub const HIGHEST_LEVEL: f64 = 10.0;

/// Contents of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// One line for tables and pictures.
    #[serde(default)]
    pub title: String,
    /// The scene that is varied, from the file's folder.
    pub scene: PathBuf,
    /// Values of the scene that are changed in all samples, `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
    /// The records.
    pub records: Vec<RecordEntry>,
    /// Scaling of the records.
    #[serde(default)]
    pub intensity: Intensity,
    /// Directions of the records.
    #[serde(default = "downstream")]
    pub polarities: Vec<i64>,
    /// Points of the Latin hypercube a record and polarity.
    #[serde(default = "one")]
    pub samples: usize,
    /// Motions that differ a little from each record, in its place.
    #[serde(default)]
    pub perturbation: Option<Perturbation>,
    /// Of the Latin hypercube and of the bootstrap.
    #[serde(default)]
    pub seed: u64,
    /// Uncertain parameters: keys of the scene.
    #[serde(default)]
    pub parameters: BTreeMap<String, Variation>,
    /// Keys of the scene that belong to the method: mesh, time step, tolerance.
    #[serde(default)]
    pub numerics: BTreeMap<String, Variation>,
    /// Limits.
    #[serde(default)]
    pub limits: Vec<Limit>,
}

fn downstream() -> Vec<i64> {
    vec![1]
}

fn one() -> usize {
    1
}

fn unchanged() -> f64 {
    1.0
}

/// A record and its cluster.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordEntry {
    /// File, from the file's folder.
    pub file: PathBuf,
    /// Its name in tables; by default that of the file.
    #[serde(default)]
    pub name: String,
    /// Records with the same word form a cluster: the two components of a station. By default each is its own cluster.
    #[serde(default)]
    pub pair: String,
    /// Additional factor to those of `scales`, such as a normalisation by peak velocity; without effect on levels.
    #[serde(default = "unchanged")]
    pub factor: f64,
    /// Unit of its accelerations, as in a scene.
    pub units: Option<Units>,
    /// Column of the horizontal accelerations, as in a scene.
    pub column: Option<usize>,
    /// Vertical component. A plan whose scene has one gives it for every record.
    pub vertical: Option<VerticalEntry>,
    /// Where it begins, s, as in a scene.
    pub start: Option<f64>,
    /// Where it ends, s, as in a scene.
    pub end: Option<f64>,
}

/// The vertical component of a record, as in a scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VerticalEntry {
    /// File, from the plan's folder; by default that of the record.
    pub file: Option<PathBuf>,
    /// Column of its accelerations.
    pub column: Option<usize>,
    /// Unit of its accelerations.
    pub units: Option<Units>,
    /// Factor on it in addition to that of the record.
    #[serde(default = "unchanged")]
    pub scale: f64,
    /// Direction of its positive accelerations: 1 is up, -1 is down.
    #[serde(default = "upwards")]
    pub polarity: i64,
}

fn upwards() -> i64 {
    1
}

impl RecordEntry {
    /// The column of the horizontal accelerations in a file with several.
    pub fn column(&self) -> Option<usize> {
        let shared = self.vertical.as_ref().is_some_and(|vertical| vertical.file.is_none());
        self.column.or(shared.then_some(1))
    }
}

/// Motions that differ a little.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perturbation {
    /// Number per record.
    pub count: usize,
    /// Root mean square of what is added, as a share of the record's.
    #[serde(default = "one_percent")]
    pub noise: f64,
}

fn one_percent() -> f64 {
    0.01
}

/// Limits.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Name of a quantity in the table of a run.
    pub quantity: String,
    /// Its magnitude, in the unit of that table.
    pub above: f64,
}

impl Plan {
    /// Reads the file.
    ///
    /// **Errors**: [`EnsembleError::Plan`], [`EnsembleError::Value`].
    pub fn read(path: &Path) -> Result<(Self, String), EnsembleError> {
        let failed = |cause: String| EnsembleError::Plan { path: path.to_owned(), cause };
        if path.is_dir() {
            return Err(failed(
                "this is a folder; give the plan, a TOML file (docs/guide/ensembles.md)".into(),
            ));
        }
        let text = std::fs::read_to_string(path).map_err(|cause| failed(cause.to_string()))?;
        if let Some(line) = line_of_dear(&text) {
            return Err(failed(format!(
                "line {line}: `[dear]` is no longer supported; remove the table, and put its `set` into that of a plan of its own, with \
                 fewer records or samples, if high-fidelity runs are wanted, too"
            )));
        }
        let mut plan: Self = toml::from_str(&text).map_err(|cause| failed(cause.to_string()))?;
        for record in &mut plan.records {
            if record.name.is_empty() {
                record.name = record.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            }
        }
        plan.check(path)?;
        Ok((plan, text))
    }
}

/// The line of a plan with the former table `[dear]` or a key of it.
fn line_of_dear(text: &str) -> Option<usize> {
    let table: toml::Table = text.parse().ok()?;
    table.get("dear")?;
    let begins = |line: &str| {
        let line = line.trim_start().trim_start_matches('[').trim_start().trim_start_matches('"');
        let rest = line.strip_prefix("dear").map(|rest| rest.trim_start_matches('"').trim_start());
        rest.is_some_and(|rest| rest.starts_with([']', '.', '=']))
    };
    text.lines().position(begins).map(|index| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(text: &str) -> Result<Plan, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plan.toml");
        std::fs::write(&path, text).expect("a file");
        Plan::read(&path).map(|(plan, _)| plan).map_err(|error| error.to_string())
    }

    const START: &str = "scene = \"s\"\nrecords = [{ file = \"a.csv\", pair = \"p\" }, { file = \"b.csv\" }, { file = \"c.csv\", pair = \"p\" }]\n";

    #[test]
    fn every_combination_has_every_level_and_a_motion_keeps_its_dam() {
        let text = format!(
            "{START}polarities = [1, -1]\nsamples = 2\n[intensity]\nlevels = [0.1, 0.4]\n[parameters]\n\
             \"dam.a\" = {{ lognormal = {{ median = 2.0, dispersion = 0.5 }} }}\n\"dam.b\" = {{ values = [1, 2, 3] }}\n\
             [numerics]\n\"dam.c\" = {{ values = [\"x\", \"y\"] }}\n"
        );
        let plan = plan(&text).expect("a plan");
        let samples = plan.samples(&[0.2, 0.1, 0.4]);
        assert_eq!(samples.len(), 3 * 2 * 2 * (3 * 2) * 2);
        assert_eq!(plan.count(), Some(samples.len()));
        assert_eq!(plan.clusters(), [0, 1, 0]);
        // Both levels of one motion are of the same dam.
        for pair in samples.chunks(2) {
            assert_eq!(pair[0].values, pair[1].values);
            assert_eq!([pair[0].intensity, pair[1].intensity], [0.1, 0.4]);
        }
        assert_eq!((samples[0].scale, samples[1].scale), (0.5, 2.0));
        let combinations: std::collections::BTreeSet<_> =
            samples.iter().map(|s| (s.record, s.polarity, s.values.clone(), s.level)).collect();
        assert_eq!(combinations.len(), samples.len());
        // Half of the drawn values lie below the median: the hypercube has a point in each twelfth.
        let mut drawn: Vec<f64> = samples.iter().map(|s| s.values[0].parse().expect("a number")).collect();
        drawn.sort_by(f64::total_cmp);
        drawn.dedup();
        assert_eq!((drawn.len(), drawn.iter().filter(|x| **x < 2.0).count()), (12, 6));
        let sets = plan.sets(&samples[3], Path::new("/study"));
        assert!(sets.contains(&"dam.c=\"y\"".to_owned()) && sets.contains(&"dam.b=1".to_owned()), "{sets:?}");
        // All of the record is the plan's.
        let record = "ground_motion.record={file=\"/study/a.csv\", scale=2, polarity=1}".to_owned();
        assert!(sets.contains(&record), "{sets:?}");
        assert!(!sets.iter().any(|set| set.contains("vertical")), "{sets:?}");
    }

    #[test]
    fn a_vertical_component_comes_with_its_record() {
        let text = "scene = \"s\"\nrecords = [{ file = \"a.csv\", vertical = { column = 2, scale = 0.5, polarity = -1 } }, \
                    { file = \"b.csv\", vertical = { file = \"up.csv\", units = \"m/s2\" } }]\n";
        let plan = plan(text).expect("a plan");
        let samples = plan.samples(&[0.2, 0.1]);
        let sets = |sample: usize| plan.sets(&samples[sample], Path::new("/study"));
        assert_eq!(sets(0)[0], "ground_motion.record={file=\"/study/a.csv\", scale=1, polarity=1, column=1}");
        assert_eq!(sets(0)[1], "ground_motion.vertical={scale=0.5, polarity=-1, column=2}");
        assert_eq!(sets(1)[0], "ground_motion.record={file=\"/study/b.csv\", scale=1, polarity=1}");
        let other = "ground_motion.vertical={scale=1, polarity=1, file=\"/study/up.csv\", units=\"m/s2\"}";
        assert_eq!(sets(1)[1], other);
    }

    #[test]
    fn a_plan_that_cannot_be_carried_out_says_where() {
        for (text, wanted) in [
            ("scene = \"s\"\nrecords = []\n".to_owned(), "`records` is an empty list"),
            (format!("{START}polarity = [1]\n"), "unknown field `polarity`"),
            (format!("{START}polarities = [2]\n"), "`polarities` is [2]"),
            (format!("{START}samples = 4\n"), "`samples` is 4"),
            (format!("{START}[intensity]\nlevels = [0.4, 0.1]\n"), "`intensity.levels` is [0.4, 0.1]"),
            (format!("{START}[intensity]\nlevels = [0.1]\nscales = [1.0]\n"), "either `levels` or `scales`"),
            (format!("{START}[intensity]\nperiod = 0.3\n"), "`intensity.period` is 0.3"),
            (
                format!("{START}[intensity]\ntarget = {{ spectrum = \"t.csv\", range = [2.0, 0.2] }}\n"),
                "`intensity.target.range` is [2.0, 0.2]",
            ),
            (
                format!("{START}[intensity]\nlevels = [0.1]\ntarget = {{ spectrum = \"t.csv\" }}\n"),
                "`scales` are multiples of it",
            ),
            (format!("{START}[parameters]\n\"a\" = {{ values = [] }}\n"), "at least one value"),
            (
                format!("{START}[parameters]\n\"a\" = {{ uniform = {{ from = 2.0, to = 1.0 }} }}\n"),
                "below `to`",
            ),
            (
                format!("{START}[parameters]\n\"ground_motion.record.scale\" = {{ values = [1] }}\n"),
                "vary the ground motion",
            ),
            (
                format!("set = [\"ground_motion.record.start=3\"]\n{START}"),
                "`set` is \"ground_motion.record.start=3\"; give the keys of the motion in each of `records`",
            ),
            (format!("{START}[[limits]]\nquantity = \"x\"\nabove = -1.0\n"), "`limits.above` is -1"),
            (
                format!("{START}\n[dear]\nset = [\"dam.a=2\"]\nshare = 0.5\ncost = 5\n"),
                "line 4: `[dear]` is no longer supported",
            ),
            (format!("{START}dear.share = 0.5\n"), "line 3: `[dear]` is no longer supported"),
        ] {
            let error = plan(&text).expect_err(wanted);
            assert!(error.contains(wanted), "{error}\nwanted: {wanted}");
        }
    }
}
