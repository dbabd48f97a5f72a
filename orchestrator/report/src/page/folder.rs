//! The files of a run.

use super::super::{Envelopes, Manifest, ManifestError, Summary};
use cofferdam_assembly::log::ground_motion_of;
use cofferdam_assembly::observer::{Histories, HistoriesError};
use cofferdam_assembly::vtk::Grid;
use cofferdam_coupling::observer::{Ending, Statistics, Status, WallTime};
use cofferdam_log::{Log, LogReadError};
use cofferdam_scene::{LoadedScene, SceneError};
use std::path::{Path, PathBuf};

/// Files of a run's folder.
#[derive(Clone, Debug)]
pub struct RunFolder {
    /// The folder.
    pub path: PathBuf,
    /// `manifest.toml`.
    pub manifest: Manifest,
    /// `histories.csv`.
    pub histories: Histories,
    /// `log.mcap`.
    pub log: Log,
    /// The scene and the ground motion of the log.
    pub loaded: LoadedScene,
    /// The result in the manifest, or that of the histories for a run without an end.
    pub summary: Summary,
    /// The dam's part of `envelopes.vtm`, if there is one.
    pub envelope: Option<Grid>,
}

/// Reason why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// There is no such folder.
    #[error("{}: there is no such folder; give the folder of a run, such as runs/koyna", path.display())]
    NoFolder {
        /// The folder.
        path: PathBuf,
    },
    /// A file is missing.
    #[error("{} is missing: {remedy}", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The remedy.
        remedy: &'static str,
    },
    /// The run has not taken a step.
    #[error("{} contains no step: the run ended before its first step; see manifest.toml and the log for the reason", path.display())]
    NoStep {
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be read, or is no table.
    #[error("{}: {cause}; write it again with the command that created it", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
    /// The manifest cannot be read.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// The histories cannot be read.
    #[error(transparent)]
    Histories(#[from] HistoriesError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// The scene of the log is not one of this version.
    #[error("{}: {cause}; use the build that made the run, or run its scene again", path.display())]
    Scene {
        /// The log.
        path: PathBuf,
        /// What is wrong with it.
        cause: SceneError,
    },
}

/// The files, and the remedy if one is missing.
const FILES: [(&str, &str); 3] = [
    ("manifest.toml", "give the folder of a run; without it, run the scene again"),
    (
        "histories.csv",
        "`cofferdam log export RUN --output FOLDER` writes it from the log; copy it back, or run the scene again",
    ),
    ("log.mcap", "put it back, or run the scene again"),
];

impl RunFolder {
    /// Reads the folder of a run that has ended, was killed, or continues.
    ///
    /// **Errors**: [`ReportError`]; a file that is missing is named with the remedy.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        if !folder.is_dir() {
            return Err(ReportError::NoFolder { path: folder.to_owned() });
        }
        let [manifest, histories, log] = FILES.map(|(name, remedy)| (folder.join(name), remedy));
        for (path, remedy) in [&manifest, &histories, &log] {
            if !path.exists() {
                return Err(ReportError::Missing { path: path.clone(), remedy });
            }
        }
        Self::of(Manifest::read(&manifest.0)?, Histories::read(&histories.0)?, &log.0)
    }

    /// The same of a run whose `manifest` and `histories` are known; its log is the file `log`.
    ///
    /// **Errors**: those of the log; there is no step.
    pub fn of(manifest: Manifest, histories: Histories, log: &Path) -> Result<Self, ReportError> {
        if histories.rows() == 0 {
            return Err(ReportError::NoStep { path: log.with_file_name("histories.csv") });
        }
        let folder = log.parent().unwrap_or(Path::new("")).to_owned();
        let envelope = Envelopes::of_folder(&folder);
        let log = Log::open(log)?;
        let head = log.head();
        let path = log.path().to_owned();
        let (name, text, motion) = (manifest.name.clone(), &head.scene_text, ground_motion_of(&log));
        let loaded = LoadedScene::of_log(name, text, &[], &path, motion)
            .map_err(|cause| ReportError::Scene { path, cause })?;
        let summary = match &manifest.result {
            Some(result) => result.clone(),
            None => unended(&loaded, &histories),
        };
        Ok(Self { path: folder, manifest, histories, log, loaded, summary, envelope })
    }
}

/// Summary of a run without an end, from its histories.
fn unended(loaded: &LoadedScene, histories: &Histories) -> Summary {
    // of the communication steps, not of the row of initialisation
    let converged = histories.column("converged").unwrap_or(&[]).iter().skip(1);
    let unconverged = converged.filter(|converged| **converged == 0.0).count() as u64;
    let ending = Ending {
        status: Status::Interrupted,
        time: histories.column("time").and_then(|time| time.last()).copied().unwrap_or(0.0),
        wall: WallTime::default(),
        statistics: Statistics { unconverged, ..Statistics::default() },
    };
    let summary = Summary::of(loaded, histories, &ending, None, &[], [&[], &[]], &[]);
    Summary { status: "without an end: the run was killed or is still running".to_owned(), ..summary }
}
