use super::{Accuracy, PlanRow, Summary};
use cofferdam_assembly::build_info::Build;
use cofferdam_log::results_file::remedy;
use cofferdam_motion::text_file;
use cofferdam_scene::Scene;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What a run was made from and what came of it: `manifest.toml` in the run's folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the case.
    pub name: String,
    /// When the run began, in UTC.
    pub started: String,
    /// How far it has come: `preparing`, `running`, or how it ended.
    pub status: String,
    /// Program, machine.
    pub build: Build,
    /// Points of the wet face from the heel up (x, y), m: the columns of the files about it.
    pub wet_face: Vec<[f64; 2]>,
    /// Points of the reservoir's wet face, where they are others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reservoir_wet_face: Option<Vec<[f64; 2]>>,
    /// The other wet faces of the dam.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_wet_faces: Vec<WaterFace>,
    /// Points around the dam's blocks and galleries in the unloaded position (x, y), m, polygon after polygon: the columns of `outline.csv`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outline: Vec<Vec<[f64; 2]>>,
    /// The participants: name and solver.
    #[serde(default)]
    pub units: Vec<Unit>,
    /// The result; absent while the run continues.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Summary>,
    /// The requested accuracy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// What is modelled and what is not, with criteria; with a requested accuracy.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plan: Vec<PlanRow>,
    /// The scene with all defaults: a manifest can be run again as a scene.
    pub scene: Scene,
}

/// A wet face of the dam in addition to that of the reservoir.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WaterFace {
    /// Name of its water.
    pub water: String,
    /// Points of the dam from the base up (x, y), m.
    pub points: Vec<[f64; 2]>,
    /// Points of the water, where they are others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_points: Option<Vec<[f64; 2]>>,
}

/// A participant and numbers of its own.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Unit {
    /// Name.
    pub name: String,
    /// Solver and version.
    pub solver: String,
    /// Hash of everything it was made from.
    pub fingerprint: String,
}

/// A manifest that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// The file cannot be written.
    #[error("{}: {cause}; {}", path.display(), remedy(cause))]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
    /// The content is no TOML.
    #[error("the manifest cannot be written as TOML: {0}")]
    Encode(#[from] toml::ser::Error),
    /// The file cannot be read.
    #[error("{}: {cause}; give the folder of a run", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
    /// The content is no manifest, or one of another version.
    #[error("{}: {cause}; take the build that made the run, or run its scene again", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
}

impl Manifest {
    /// Reads the manifest `path`.
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

    /// Writes the manifest to `path`, in place of one written before, which stays whole if that fails.
    pub fn write(&self, path: &Path) -> Result<(), ManifestError> {
        let text = toml::to_string(self)?;
        let beside = path.with_extension("toml.new");
        std::fs::write(&beside, text)
            .and_then(|()| std::fs::rename(&beside, path))
            .map_err(|cause| ManifestError::Write { path: path.to_owned(), cause })
    }
}
