use super::Record;
use crate::{Fingerprint, Packable, StateError};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of the file in an FMU's resources that holds its [`Contents`].
pub const FILE: &str = "unit.toml";

/// Name of the file in an FMU's resources that holds what [`Packable::prepare`] gave, if it gave anything.
pub const PREPARED: &str = "prepared.bin";

/// The parameters of an FMU's unit, and the start values of its inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contents<P> {
    /// Start values of the inputs by name; other inputs start at zero.
    pub start: BTreeMap<String, Vec<f64>>,
    /// Parameters of the unit.
    pub parameters: P,
    /// What drives inputs in place of the importer; usually nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub records: Vec<Record>,
}

impl<P> Contents<P> {
    /// Whether the FMU drives the input `name` by itself, so that it is no variable of the FMU.
    pub fn drives(&self, name: &str) -> bool {
        self.records.iter().any(|record| record.input == name)
    }
}

/// Contents that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ContentsError {
    /// The file cannot be read.
    #[error("{path} cannot be read: {cause}; pass the path of the FMU's unpacked `resources` folder", path = .path.display())]
    Unreadable {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The file does not hold contents of this unit.
    #[error("{path} does not describe this unit: {cause}; pack the FMU again with this build", path = .path.display())]
    Unintelligible {
        /// File.
        path: PathBuf,
        /// What is wrong.
        cause: Box<toml::de::Error>,
    },
    /// What was prepared cannot be used.
    #[error("{path} cannot be used: {cause}; unpack the FMU again", path = .path.display())]
    Prepared {
        /// File.
        path: PathBuf,
        /// What is wrong.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The contents cannot be written as TOML.
    #[error("the unit's parameters cannot be written as TOML: {0}")]
    Unwritable(#[from] toml::ser::Error),
    /// The contents cannot be hashed.
    #[error(transparent)]
    Unhashable(#[from] StateError),
}

impl<P: Clone + Serialize + DeserializeOwned> Contents<P> {
    /// Reads the [`FILE`] in the folder `resources`.
    pub fn read(resources: &Path) -> Result<Self, ContentsError> {
        let path = resources.join(FILE);
        let text = std::fs::read_to_string(&path)
            .map_err(|cause| ContentsError::Unreadable { path: path.clone(), cause })?;
        toml::from_str(&text).map_err(|cause| ContentsError::Unintelligible { path, cause: Box::new(cause) })
    }

    /// The contents as TOML; reading it gives the same numbers bit for bit.
    pub fn to_toml(&self) -> Result<String, ContentsError> {
        Ok(toml::to_string(self)?)
    }

    /// The FMU's instantiation token; it differs for different contents.
    pub fn token<U: Packable<Parameters = P>>(&self) -> Result<String, ContentsError> {
        Ok(format!("cofferdam-{}-{}", U::NAME, Fingerprint::of(U::NAME, self)?))
    }
}
