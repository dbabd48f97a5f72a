use super::{Accuracy, PlanRow, Summary};
use crate::results_file::remedy;
use crate::scene::Scene;
use crate::text_file;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
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
    /// The result; absent while the run goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Summary>,
    /// What the run was asked to be accurate to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// What is modelled and left out, and why; with an accuracy that was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plan: Vec<PlanRow>,
    /// The scene with all defaults: a manifest can be run again as a scene.
    pub scene: Scene,
}

/// A wet face of the dam beside that of the reservoir.
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

/// The program and the machine it runs on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Build {
    /// Version of the program.
    pub version: Cow<'static, str>,
    /// Git commit of the program.
    pub commit: Cow<'static, str>,
    /// Optimised or not.
    pub profile: Cow<'static, str>,
    /// Processor.
    pub processor: String,
    /// What the processor offers beyond its architecture of what numerical libraries choose their code by.
    pub features: String,
    /// Cores that the program may use.
    pub cores: usize,
    /// Operating system and architecture.
    pub system: String,
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

impl Build {
    /// This program on this machine.
    pub fn here() -> Self {
        let cpu_info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu_info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: env!("COFFERDAM_COMMIT").into(),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.into(),
            processor: model.map_or_else(|| "unknown".to_owned(), |(_, name)| name.to_owned()),
            features: features(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

/// The features of the processor that numerical libraries choose their code by.
pub(crate) fn features() -> String {
    #[cfg(target_arch = "x86_64")]
    {
        let found = [
            ("sse4.1", std::arch::is_x86_feature_detected!("sse4.1")),
            ("avx", std::arch::is_x86_feature_detected!("avx")),
            ("avx2", std::arch::is_x86_feature_detected!("avx2")),
            ("fma", std::arch::is_x86_feature_detected!("fma")),
            ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
        ];
        let names = found.iter().filter(|(_, there)| *there).map(|(name, _)| *name);
        names.collect::<Vec<_>>().join(" ")
    }
    #[cfg(not(target_arch = "x86_64"))]
    String::new()
}

/// A manifest that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// The file cannot be written.
    #[error("{}: {cause}; {}", path.display(), remedy(cause))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
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
        /// What the system said.
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

    /// Writes the manifest to `path`, in the place of one written before, which stays whole if that fails.
    pub fn write(&self, path: &Path) -> Result<(), ManifestError> {
        let text = toml::to_string(self)?;
        let beside = path.with_extension("toml.new");
        std::fs::write(&beside, text)
            .and_then(|()| std::fs::rename(&beside, path))
            .map_err(|cause| ManifestError::Write { path: path.to_owned(), cause })
    }
}
