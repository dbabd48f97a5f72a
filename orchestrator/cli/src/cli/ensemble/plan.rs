//! The file of an ensemble: what is varied, and the samples that follow.

use super::EnsembleError;
use cofferdam_analysis::statistics::latin_hypercube;
use cofferdam_motion::{GroundMotion, STANDARD_GRAVITY, Units};
use cofferdam_report::SPECTRAL_DAMPING;
use serde::Deserialize;
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Value;

/// Largest level of shaking, g: no record was stronger.
const HIGHEST_LEVEL: f64 = 10.0;
/// Most samples of an ensemble.
const MOST: usize = 1_000_000;

/// What the file says.
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
    /// How strong they are made.
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
    /// Keys of the scene that are not known exactly.
    #[serde(default)]
    pub parameters: BTreeMap<String, Variation>,
    /// Keys of the scene that belong to the method: mesh, time step, tolerance.
    #[serde(default)]
    pub numerics: BTreeMap<String, Variation>,
    /// What must not be exceeded.
    #[serde(default)]
    pub limits: Vec<Limit>,
    /// Dear runs of some motions beside the cheap ones of all.
    #[serde(default)]
    pub dear: Option<Dear>,
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

/// A record, and what it belongs to.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordEntry {
    /// File, from the file's folder.
    pub file: PathBuf,
    /// Its name in tables; by default that of the file.
    #[serde(default)]
    pub name: String,
    /// Records with the same word are drawn together: the two components of a station. By default each is alone.
    #[serde(default)]
    pub pair: String,
    /// Factor on it beside those of `scales`, such as a normalisation by peak velocity; without effect on levels.
    #[serde(default = "unchanged")]
    pub factor: f64,
    /// Unit of its accelerations, as in a scene.
    pub units: Option<Units>,
    /// Where it begins and ends, s, as in a scene.
    pub start: Option<f64>,
    pub end: Option<f64>,
}

/// Motions that differ a little.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perturbation {
    /// How many of each record.
    pub count: usize,
    /// Root mean square of what is added, as a share of the record's.
    #[serde(default = "one_percent")]
    pub noise: f64,
}

fn one_percent() -> f64 {
    0.01
}

/// Runs of some motions by a dearer model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dear {
    /// Values of the scene that make a run dear, `key=value`, beside those of all.
    #[serde(default)]
    pub set: Vec<String>,
    /// How many of the motions of each level run dear, too, as a share of them.
    pub share: Option<f64>,
    /// The same as a number.
    pub count: Option<usize>,
    /// Cost of a dear run over that of a cheap one.
    pub cost: Option<f64>,
}

impl Dear {
    /// How many of this many motions run dear.
    pub fn number(&self, motions: usize) -> usize {
        let of_share = |share: f64| (share * motions as f64).round() as usize;
        self.count.unwrap_or_else(|| of_share(self.share.unwrap_or_default())).clamp(1, motions.max(1))
    }

    /// Cost of a dear run over that of a cheap one.
    pub fn cost(&self) -> f64 {
        self.cost.unwrap_or(f64::NAN)
    }

    /// The keys that it changes.
    fn keys(&self) -> impl Iterator<Item = &str> {
        self.set.iter().map(|set| set.split('=').next().unwrap_or_default().trim())
    }
}

/// How strong records are made.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Intensity {
    /// The measure.
    pub measure: Measure,
    /// Period of the oscillator, s; by default that of the dam's first mode with the water.
    pub period: Option<f64>,
    /// Values of the measure to which every record is scaled, g.
    pub levels: Vec<f64>,
    /// Factors on the records, in place of levels.
    pub scales: Vec<f64>,
    /// A spectrum to which the records are scaled before.
    pub target: Option<Target>,
}

/// A spectrum to which records are scaled.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Its file, from the plan's folder.
    pub spectrum: PathBuf,
    /// The periods that are compared, as multiples of the intensity's.
    #[serde(default = "around_the_first_period")]
    pub range: [f64; 2],
}

fn around_the_first_period() -> [f64; 2] {
    [0.2, 2.0]
}

/// Intensity measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Peak ground acceleration.
    #[default]
    Pga,
    /// Spectral acceleration with 5 % damping.
    Sa,
}

/// The values that a key takes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Variation {
    /// Each of them with all else.
    Values(Vec<Value>),
    /// Any between both, equally likely.
    Uniform { from: f64, to: f64 },
    /// Normally distributed.
    Normal { mean: f64, deviation: f64 },
    /// Its logarithm is normally distributed.
    Lognormal { median: f64, dispersion: f64 },
}

impl std::fmt::Display for Variation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Values(values) => {
                f.write_str(&values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
            }
            Self::Uniform { from, to } => write!(f, "uniform from {from} to {to}"),
            Self::Normal { mean, deviation } => {
                write!(f, "normal, mean {mean}, standard deviation {deviation}")
            }
            Self::Lognormal { median, dispersion } => {
                write!(f, "lognormal, median {median}, dispersion {dispersion}")
            }
        }
    }
}

impl Variation {
    /// The value below which a random one lies with this probability; none for a list.
    fn at(&self, probability: f64) -> Option<f64> {
        let z = || Normal::standard().inverse_cdf(probability);
        match self {
            Self::Values(_) => None,
            Self::Uniform { from, to } => Some(from + probability * (to - from)),
            Self::Normal { mean, deviation } => Some(mean + deviation * z()),
            Self::Lognormal { median, dispersion } => Some(median * (dispersion * z()).exp()),
        }
    }

    /// Whether there is no value, or a spread that is none.
    fn problem(&self) -> Option<&'static str> {
        match self {
            Self::Values(values) => values.is_empty().then_some("give at least one value"),
            Self::Uniform { from, to } => {
                (!(from < to && (to - from).is_finite())).then_some("`from` must be below `to`")
            }
            Self::Normal { mean, deviation } => {
                (!(mean.is_finite() && *deviation > 0.0 && deviation.is_finite()))
                    .then_some("`deviation` must be greater than 0")
            }
            Self::Lognormal { median, dispersion } => {
                let positive = |x: f64| x > 0.0 && x.is_finite();
                (!(positive(*median) && positive(*dispersion)))
                    .then_some("`median` and `dispersion` must be greater than 0")
            }
        }
    }
}

/// What must not be exceeded.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Name of a quantity in the table of a run.
    pub quantity: String,
    /// Its magnitude, in the unit of that table.
    pub above: f64,
}

/// By which model a sample is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model {
    /// That of the scene.
    Cheap,
    /// That of `[dear]`.
    Dear,
}

/// One sample: a run of the scene.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Number of its record in the plan.
    pub record: usize,
    pub polarity: i64,
    /// Factor on the record.
    pub scale: f64,
    /// Intensity measure, g.
    pub intensity: f64,
    /// Number of its level or scale.
    pub level: usize,
    /// Number of the noise that is added to it, counted from 0.
    pub perturbation: Option<usize>,
    /// Number of its draw: equal for samples that differ in level or in listed values only.
    pub draw: usize,
    /// The keys that vary, in the order of [`Plan::variations`], with their values.
    pub values: Vec<String>,
}

impl Plan {
    /// Reads the file.
    ///
    /// **Errors**: [`EnsembleError::Plan`], [`EnsembleError::Value`].
    pub fn read(path: &Path) -> Result<(Self, String), EnsembleError> {
        let failed = |cause: String| EnsembleError::Plan { path: path.to_owned(), cause };
        if path.is_dir() {
            return Err(failed("this is a folder; give the plan, a TOML file (docs/ensembles.md)".into()));
        }
        let text = std::fs::read_to_string(path).map_err(|cause| failed(cause.to_string()))?;
        let mut plan: Self = toml::from_str(&text).map_err(|cause| failed(cause.to_string()))?;
        for record in &mut plan.records {
            if record.name.is_empty() {
                record.name = record.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            }
        }
        plan.check(path)?;
        Ok((plan, text))
    }

    fn check(&self, path: &Path) -> Result<(), EnsembleError> {
        let wrong = |key: &str, value: String, remedy: &str| {
            let (path, key, remedy) = (path.to_owned(), key.to_owned(), remedy.to_owned());
            Err(EnsembleError::Value { path, key, value, remedy })
        };
        if self.records.is_empty() {
            return wrong("records", "an empty list".into(), "give at least one record");
        }
        let names: Vec<&str> = self.records.iter().map(|record| &*record.name).collect();
        if let Some(twice) = (1..names.len()).find(|i| names[..*i].contains(&names[*i])) {
            return wrong("records", format!("{:?} twice", names[twice]), "give them different names");
        }
        if let Some(record) =
            self.records.iter().find(|record| !(record.factor > 0.0 && record.factor.is_finite()))
        {
            return wrong("records.factor", record.factor.to_string(), "it must be greater than 0");
        }
        let Intensity { measure, period, levels, scales, target } = &self.intensity;
        if let Some(Target { range: range @ [from, to], .. }) = target {
            if !(*from > 0.0 && from < to && to.is_finite()) {
                let remedy = "two positive multiples of the period, the first the smaller one";
                return wrong("intensity.target.range", format!("{range:?}"), remedy);
            }
            if !levels.is_empty() {
                let remedy = "a target scales the records; `scales` are multiples of it";
                return wrong("intensity.levels", format!("{levels:?}"), remedy);
            }
            if let Some(record) = self.records.iter().find(|record| record.factor != 1.0) {
                let remedy = "a target has factors of its own; leave one of them out";
                return wrong("records.factor", record.factor.to_string(), remedy);
            }
        }
        if !levels.is_empty() && !scales.is_empty() {
            return wrong("intensity.scales", format!("{scales:?}"), "give either `levels` or `scales`");
        }
        for (key, values) in [("intensity.levels", levels), ("intensity.scales", scales)] {
            let ascend = values.windows(2).all(|pair| pair[0] < pair[1]);
            if !ascend || values.iter().any(|x| !(*x > 0.0 && x.is_finite())) {
                return wrong(key, format!("{values:?}"), "they must be positive and ascend");
            }
        }
        if levels.iter().any(|level| *level > HIGHEST_LEVEL) {
            let remedy = "they are in g, not in % or m/s²; 20 % of g is 0.2";
            return wrong("intensity.levels", format!("{levels:?}"), remedy);
        }
        if let Some(period) = period
            && !(*period > 0.0 && period.is_finite() && (*measure == Measure::Sa || target.is_some()))
        {
            let remedy = "a positive period belongs to `measure = \"sa\"` or to a target";
            return wrong("intensity.period", period.to_string(), remedy);
        }
        if let Some(key) = self.set.iter().find(|set| set.trim_start().starts_with("ground_motion")) {
            let remedy = "give the motion's keys with each of `records`, as `intensity` and `polarities`";
            return wrong("set", format!("{key:?}"), remedy);
        }
        let polarities = &self.polarities;
        if !matches!(polarities[..], [1 | -1] | [1, -1] | [-1, 1]) {
            return wrong("polarities", format!("{polarities:?}"), "give [1], [-1] or [1, -1]");
        }
        for (table, variations) in [("parameters", &self.parameters), ("numerics", &self.numerics)] {
            for (key, variation) in variations {
                if let Some(remedy) = variation.problem() {
                    return wrong(&format!("{table}.\"{key}\""), format!("{variation:?}"), remedy);
                }
                if key.starts_with("ground_motion") {
                    let remedy = "`records`, `intensity` and `polarities` vary the ground motion";
                    return wrong(&format!("{table}.\"{key}\""), "a key of it".into(), remedy);
                }
            }
        }
        if let Some(key) = self.parameters.keys().find(|key| self.numerics.contains_key(*key)) {
            return wrong(
                &format!("numerics.\"{key}\""),
                "also in [parameters]".into(),
                "leave one of them out",
            );
        }
        if let Some(Perturbation { count, noise }) = self.perturbation
            && !(count > 0 && noise > 0.0 && noise <= 1.0)
        {
            let remedy = "`count` must be at least 1, `noise` between 0 and 1";
            return wrong("perturbation", format!("{{ count = {count}, noise = {noise} }}"), remedy);
        }
        if self.samples == 0 || (self.samples > 1 && self.distributed().next().is_none()) {
            let remedy =
                "1, or more where a key of [parameters] has a distribution: without, they would all be equal";
            return wrong("samples", self.samples.to_string(), remedy);
        }
        for limit in &self.limits {
            if !(limit.above > 0.0 && limit.above.is_finite()) {
                return wrong("limits.above", limit.above.to_string(), "it must be greater than 0");
            }
        }
        match self.count() {
            Some(count) if count <= MOST => {}
            _ => return wrong("samples", format!("more than {MOST} in all"), "vary less"),
        }
        match self.dear.as_ref().and_then(|dear| self.problem_of(dear)) {
            Some((key, value, remedy)) => wrong(key, value, remedy),
            None => Ok(()),
        }
    }

    /// What is wrong with `[dear]`: key, value, remedy.
    fn problem_of(&self, dear: &Dear) -> Option<(&'static str, String, &'static str)> {
        let motions = self.motions();
        if !self.numerics.is_empty() {
            let remedy = "leave one of them out: the cheap runs would be of several methods";
            return Some(("dear", "beside [numerics]".into(), remedy));
        }
        if dear.set.is_empty() {
            let remedy = "give what makes a run dear, such as [\"dam.element_size=2.5\"]";
            return Some(("dear.set", "an empty list".into(), remedy));
        }
        if let Some(key) = dear.keys().find(|key| key.starts_with("ground_motion")) {
            let remedy = "dear runs have the motions of the cheap ones; leave it out";
            return Some(("dear.set", format!("{key:?}"), remedy));
        }
        if let Some(key) = dear.keys().find(|key| self.parameters.contains_key(*key)) {
            let remedy = "dear runs have the dams of the cheap ones, and the key is in [parameters]; leave one of them out";
            return Some(("dear.set", format!("{key:?}"), remedy));
        }
        match (dear.share, dear.count) {
            (None, None) => {
                let remedy =
                    "give the share of the motions that run dear, such as 0.2, or `dear.count`, their number";
                return Some(("dear.share", "not given".into(), remedy));
            }
            (Some(share), Some(_)) => {
                return Some(("dear.share", share.to_string(), "give either `dear.share` or `dear.count`"));
            }
            (Some(share), None) if !(share > 0.0 && share <= 1.0) => {
                let remedy = "it must be greater than 0 and at most 1; 20 % is 0.2";
                return Some(("dear.share", share.to_string(), remedy));
            }
            (None, Some(count)) if count == 0 || count > motions => {
                let remedy = "it must be at least 1 and at most the number of motions at a level: records times polarities times samples, \
                              perturbations and listed values";
                return Some(("dear.count", count.to_string(), remedy));
            }
            _ => {}
        }
        let remedy = "give how many cheap runs take as long as a dear one, more than 1; the command says at its end how many they were";
        match dear.cost {
            Some(cost) if cost > 1.0 && cost.is_finite() => None,
            Some(cost) => Some(("dear.cost", cost.to_string(), remedy)),
            None => Some(("dear.cost", "not given".into(), remedy)),
        }
    }

    /// Number of samples at each level.
    fn motions(&self) -> usize {
        self.count().unwrap_or(0) / self.intensity.level_names().len()
    }

    /// Numbers of the samples that run dear, too, ascending: the same motions at every level. Records stand in a random order, those of a
    /// pair and the motions of a record beside each other, and every so many-th motion is taken, from a random one on: each
    /// is as likely as any other, and they are spread over the records.
    pub fn dear_samples(&self, samples: &[Sample]) -> Vec<usize> {
        let Some(dear) = &self.dear else { return Vec::new() };
        let levels = self.intensity.level_names().len();
        let motions = samples.len() / levels;
        let clusters = self.clusters();
        let mut random = fastrand::Rng::with_seed(self.seed);
        let mut keys = |count: usize| (0..count).map(|_| random.u64(..)).collect::<Vec<_>>();
        let (of_cluster, of_record, of_motion) = (keys(clusters.len()), keys(clusters.len()), keys(motions));
        let start = random.usize(0..motions.max(1));
        let mut order: Vec<usize> = (0..motions).collect();
        order.sort_by_key(|motion| {
            let record = samples[motion * levels].record;
            (of_cluster[clusters[record]], of_record[record], of_motion[*motion])
        });
        let wanted = dear.number(motions);
        let mut taken: Vec<usize> = (0..wanted).map(|i| order[(i * motions + start) / wanted]).collect();
        taken.sort_unstable();
        taken.into_iter().flat_map(|motion| motion * levels..(motion + 1) * levels).collect()
    }

    /// Number of samples, unless it is beyond all bounds.
    fn count(&self) -> Option<usize> {
        let Intensity { levels, scales, .. } = &self.intensity;
        let levels = levels.len().max(scales.len()).max(1);
        let factors = [self.records.len(), self.polarities.len(), levels, self.samples, self.perturbations()];
        let lists = self.lists().map(|(_, values)| values.len());
        factors.into_iter().chain(lists).try_fold(1usize, usize::checked_mul)
    }

    /// Motions of a record.
    fn perturbations(&self) -> usize {
        self.perturbation.map_or(1, |perturbation| perturbation.count)
    }

    /// The keys that vary, those of the method last, with their variations.
    pub fn variations(&self) -> impl Iterator<Item = (&String, &Variation)> {
        self.parameters.iter().chain(&self.numerics)
    }

    fn lists(&self) -> impl Iterator<Item = (usize, &Vec<Value>)> {
        self.variations().enumerate().filter_map(|(index, (_, variation))| match variation {
            Variation::Values(values) => Some((index, values)),
            _ => None,
        })
    }

    fn distributed(&self) -> impl Iterator<Item = (usize, &Variation)> {
        let all = self.variations().enumerate().map(|(index, (_, variation))| (index, variation));
        all.filter(|(_, variation)| !matches!(variation, Variation::Values(_)))
    }

    /// Cluster of each record: those of one pair have the same number.
    pub fn clusters(&self) -> Vec<usize> {
        let of_pair = |index: usize| {
            let pair = &self.records[index].pair;
            self.records.iter().position(|other| !pair.is_empty() && other.pair == *pair).unwrap_or(index)
        };
        (0..self.records.len()).map(of_pair).collect()
    }

    /// All samples: for each record, polarity, point of the hypercube and combination of listed values every level.
    /// `measures` holds the intensity measure of each record as it is, g.
    pub fn samples(&self, measures: &[f64]) -> Vec<Sample> {
        let of_record = self.polarities.len() * self.samples * self.perturbations();
        let distributed: Vec<(usize, &Variation)> = self.distributed().collect();
        let points = latin_hypercube(self.records.len() * of_record, distributed.len(), self.seed);
        let lists: Vec<(usize, &Vec<Value>)> = self.lists().collect();
        let combinations: usize = lists.iter().map(|(_, values)| values.len()).product();
        let Intensity { levels, scales, .. } = &self.intensity;
        let mut samples = Vec::new();
        for (draw, point) in points.iter().enumerate() {
            let record = draw / of_record;
            let polarity = self.polarities[draw % of_record / (self.samples * self.perturbations())];
            let perturbation = self.perturbation.map(|perturbation| draw % perturbation.count);
            let measure = measures[record];
            let factor = self.records[record].factor;
            let scaled: Vec<f64> = match (&levels[..], &scales[..]) {
                ([], []) => vec![factor],
                ([], scales) => scales.iter().map(|scale| factor * scale).collect(),
                (levels, _) => levels.iter().map(|level| level / measure).collect(),
            };
            for mut combination in 0..combinations {
                let mut values = vec![String::new(); self.parameters.len() + self.numerics.len()];
                for ((index, variation), share) in distributed.iter().zip(point) {
                    values[*index] = variation.at(*share).map_or_else(String::new, |value| value.to_string());
                }
                for (index, list) in lists.iter().rev() {
                    values[*index] = list[combination % list.len()].to_string();
                    combination /= list.len();
                }
                samples.extend(scaled.iter().enumerate().map(|(level, &scale)| Sample {
                    record,
                    polarity,
                    scale,
                    intensity: levels.get(level).copied().unwrap_or(scale * measure),
                    level,
                    perturbation,
                    draw,
                    values: values.clone(),
                }));
            }
        }
        samples
    }

    /// The motion of a sample, of the `record` of its scene.
    pub fn motion(&self, sample: &Sample, record: GroundMotion) -> GroundMotion {
        match self.perturbation.zip(sample.perturbation) {
            None => record,
            Some((Perturbation { noise, .. }, number)) => {
                record.with_noise(noise, self.noise_seed(sample, number))
            }
        }
    }

    /// The noise of a record and direction is the same at every level and for every dam and method.
    fn noise_seed(&self, sample: &Sample, number: usize) -> u64 {
        let motion = 2 * sample.record + usize::from(sample.polarity < 0);
        (self.seed << 40) ^ ((motion as u64) << 20) ^ number as u64
    }

    /// What `sample` changes in the scene, as a dear run or as a cheap one. `folder` is the file's.
    pub fn sets(&self, sample: &Sample, model: Model, folder: &Path) -> Vec<String> {
        let record = &self.records[sample.record];
        let file = folder.join(&record.file);
        let file = file.canonicalize().unwrap_or(file);
        let text = Value::from(&*file.to_string_lossy());
        let mut keys = vec![
            format!("file={text}"),
            format!("scale={}", sample.scale),
            format!("polarity={}", sample.polarity),
        ];
        if let Some(Ok(units)) = record.units.map(Value::try_from) {
            keys.push(format!("units={units}"));
        }
        for (key, value) in [("start", record.start), ("end", record.end)] {
            keys.extend(value.map(|value| format!("{key}={value}")));
        }
        let mut sets = self.set.clone();
        // The whole table: what the scene says of its own record holds for no other.
        sets.push(format!("ground_motion.record={{{}}}", keys.join(", ")));
        sets.extend(self.variations().zip(&sample.values).map(|((key, _), value)| format!("{key}={value}")));
        sets.extend(
            self.dear.iter().filter(|_| model == Model::Dear).flat_map(|dear| dear.set.iter().cloned()),
        );
        sets
    }
}

impl Intensity {
    /// The levels as tables call them.
    pub fn level_names(&self) -> Vec<String> {
        match (&self.levels[..], &self.scales[..]) {
            ([], []) if self.target.is_some() => vec!["target".to_owned()],
            ([], []) => vec!["as recorded".to_owned()],
            ([], scales) => {
                let of = if self.target.is_some() { "target × " } else { "× " };
                scales.iter().map(|scale| format!("{of}{scale}")).collect()
            }
            (levels, _) => levels.iter().map(|level| format!("{level} g")).collect(),
        }
    }

    /// The name of the measure; `period` in s.
    pub fn name(&self, period: f64) -> String {
        match self.measure {
            Measure::Pga => "PGA".to_owned(),
            Measure::Sa => format!("Sa({period:.3} s)"),
        }
    }

    /// The measure of a motion, g; `period` in s.
    pub fn of(&self, motion: &GroundMotion, period: f64) -> f64 {
        let acceleration = match self.measure {
            Measure::Pga => motion.peak().0.abs(),
            Measure::Sa => motion.response_spectrum(&[period], SPECTRAL_DAMPING)[0],
        };
        acceleration / STANDARD_GRAVITY
    }
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
        let sets = plan.sets(&samples[3], Model::Cheap, Path::new("/study"));
        assert!(sets.contains(&"dam.c=\"y\"".to_owned()) && sets.contains(&"dam.b=1".to_owned()), "{sets:?}");
        // All of the record is the plan's.
        let record = "ground_motion.record={file=\"/study/a.csv\", scale=2, polarity=1}".to_owned();
        assert!(sets.contains(&record), "{sets:?}");
    }

    #[test]
    fn a_plan_that_cannot_be_carried_out_says_where() {
        let dear = |keys: &str| format!("{START}[dear]\n{keys}\n");
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
                "`set` is \"ground_motion.record.start=3\"; give the motion's keys with each of `records`",
            ),
            (format!("{START}[[limits]]\nquantity = \"x\"\nabove = -1.0\n"), "`limits.above` is -1"),
            (dear("share = 0.5\ncost = 5"), "`dear.set` is an empty list"),
            (
                dear("set = [\"ground_motion.record.scale=2\"]\nshare = 0.5\ncost = 5"),
                "have the motions of the cheap",
            ),
            (
                dear(
                    "set = [\"dam.a=2\"]\nshare = 0.5\ncost = 5\n[parameters]\n\"dam.a\" = { values = [1] }",
                ),
                "`dear.set` is \"dam.a\"",
            ),
            (
                dear("set = [\"dam.a=2\"]\nshare = 0.5\ncost = 5\n[numerics]\n\"dam.b\" = { values = [1] }"),
                "`dear` is beside [numerics]",
            ),
            (dear("set = [\"dam.a=2\"]\ncost = 5"), "`dear.share` is not given"),
            (dear("set = [\"dam.a=2\"]\nshare = 20\ncost = 5"), "20 % is 0.2"),
            (
                dear("set = [\"dam.a=2\"]\nshare = 0.2\ncount = 2\ncost = 5"),
                "either `dear.share` or `dear.count`",
            ),
            (dear("set = [\"dam.a=2\"]\ncount = 4\ncost = 5"), "`dear.count` is 4; it must be at least 1"),
            (dear("set = [\"dam.a=2\"]\ncount = 3"), "`dear.cost` is not given"),
            (dear("set = [\"dam.a=2\"]\ncount = 3\ncost = 1"), "`dear.cost` is 1; give how many cheap runs"),
            (dear("set = [\"dam.a=2\"]\ncount = 3\ncosts = 2"), "unknown field `costs`"),
        ] {
            let error = plan(&text).expect_err(wanted);
            assert!(error.contains(wanted), "{error}\nwanted: {wanted}");
        }
    }

    #[test]
    fn dear_runs_are_spread_over_records_and_each_motion_is_as_likely() {
        let of_seed = |seed: u64| {
            let text = format!(
                "{START}seed = {seed}\npolarities = [1, -1]\nsamples = 2\n[intensity]\nlevels = [0.1, 0.4]\n[parameters]\n\
                 \"dam.a\" = {{ uniform = {{ from = 1.0, to = 2.0 }} }}\n\
                 [dear]\nset = [\"dam.b=1\"]\nshare = 0.5\ncost = 10\n"
            );
            let plan = plan(&text).expect("a plan");
            let samples = plan.samples(&[0.2, 0.1, 0.4]);
            (plan.dear_samples(&samples), samples)
        };
        let mut times = [0; 12];
        for seed in 0..600 {
            let (dear, samples) = of_seed(seed);
            assert_eq!(dear.len(), 12);
            // Two of four motions of each record, at both levels.
            for record in 0..3 {
                assert_eq!(dear.iter().filter(|index| samples[**index].record == record).count(), 4);
            }
            assert!(
                dear.chunks(2).all(|levels| levels[0] % 2 == 0 && levels[1] == levels[0] + 1),
                "{dear:?}"
            );
            dear.iter().step_by(2).for_each(|index| times[index / 2] += 1);
        }
        // 300 each; four standard deviations are 49.
        assert!(times.iter().all(|times| (251..=349).contains(times)), "{times:?}");
        assert_eq!(of_seed(3).0, of_seed(3).0);
        assert_ne!(of_seed(3).0, of_seed(4).0);
    }

    #[test]
    fn spectral_acceleration_of_a_resonant_sine() {
        // 40 periods of a sine of 1 m/s² at 2 Hz: 1/(2ξ) = 10 times, up to what is still missing of the steady state.
        let samples =
            (0..=4000).map(|i| (std::f64::consts::TAU * 2.0 * f64::from(i) * 0.005).sin()).collect();
        let motion = GroundMotion::of_samples("sine", 0.005, samples);
        let sa = Intensity { measure: Measure::Sa, ..Intensity::default() };
        let found = sa.of(&motion, 0.5) * STANDARD_GRAVITY;
        assert!((found / 10.0 - 1.0).abs() < 0.01, "{found}");
        assert!((Intensity::default().of(&motion, 0.5) * STANDARD_GRAVITY - 1.0).abs() < 1e-4);
    }
}
