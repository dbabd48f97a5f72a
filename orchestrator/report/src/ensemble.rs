use super::{Build, ManifestError};
use cofferdam_motion::text_file;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What an ensemble was made from: `ensemble.toml` in its folder. It has no times, so that the same ensemble has the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnsembleManifest {
    /// Title of the plan.
    pub title: String,
    /// Title of its scene.
    pub scene: String,
    /// Name of the intensity measure, in g.
    pub measure: String,
    /// The levels of shaking, as tables call them.
    pub levels: Vec<String>,
    /// Those of them that `--add-levels` added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub added: Vec<String>,
    /// Number of independent records, pairs, or motions of a single record.
    #[serde(default)]
    pub independent: usize,
    /// Directions of the records.
    pub polarities: Vec<i64>,
    /// Draws of the distributed parameters for each record and direction.
    pub samples: usize,
    /// Of the draws and of the bootstrap.
    pub seed: u64,
    /// Motions in place of each record: how many, and their noise as a share of its root mean square.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub perturbation: Option<(usize, f64)>,
    /// Values of the scene that were changed in all runs.
    pub set: Vec<String>,
    /// Quantities of the short tables.
    pub shown: Vec<String>,
    /// What is not modelled, each in a sentence.
    pub not_modelled: Vec<String>,
    /// Doubts about the scene.
    pub warnings: Vec<String>,
    /// SHA-256 of the plan.
    pub plan_sha256: String,
    /// SHA-256 of the first sample's scene with all defaults, without its record.
    pub scene_sha256: String,
    /// Hash of the program's sources.
    pub sources: String,
    /// Program, machine.
    pub build: Build,
    /// The records.
    pub records: Vec<EnsembleRecord>,
    /// The keys that are not known exactly.
    pub parameters: Vec<VariedKey>,
    /// The keys of the method.
    pub numerics: Vec<VariedKey>,
}

/// A record of an ensemble.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnsembleRecord {
    /// Its name in tables.
    pub name: String,
    /// Its file.
    pub file: String,
    /// Records of one pair are drawn together.
    pub pair: String,
    /// Factor on it.
    pub factor: f64,
    /// Intensity measure of the record as it is, g.
    pub measure: f64,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Its vertical component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical: Option<EnsembleVertical>,
}

/// The vertical component of a record of an ensemble.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnsembleVertical {
    /// Its file.
    pub file: String,
    /// Its column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// Factor in addition to that of the record.
    pub scale: f64,
    /// Direction of positive accelerations: 1 is up, -1 is down.
    pub polarity: i64,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// A key of the scene, and what it is varied by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariedKey {
    /// The key.
    pub key: String,
    /// Values or distribution, in words.
    pub by: String,
}

impl EnsembleManifest {
    /// Reads `path`.
    ///
    /// **Errors**: [`ManifestError::Read`], [`ManifestError::Decode`].
    pub fn read(path: &Path) -> Result<Self, ManifestError> {
        let text =
            text_file::read(path).map_err(|cause| ManifestError::Read { path: path.to_owned(), cause })?;
        toml::from_str(&text).map_err(|error| ManifestError::Decode {
            path: path.to_owned(),
            cause: error.message().to_owned(),
        })
    }
}
