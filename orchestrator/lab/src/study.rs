//! Common parts of all studies.

pub use cofferdam_analysis::study::{CREST, Outcome, SLIDING, StudyError, moments, quoted, relative, unfit};

use crate::context::context;
use cofferdam_analysis::study::{self, StudyFolder};
use cofferdam_analysis::table::Table;
use cofferdam_assembly::read_scene;
use cofferdam_coupling::scheme::Graph;
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{LoadedScene, Scene};
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Arguments of all studies.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    pub scene: PathBuf,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for tables and figures; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Reduce the number or the length of the runs
    #[arg(long)]
    pub coarse: bool,
}

impl Arguments {
    /// Reads the scene and takes the output folder.
    pub fn load(&self) -> Result<LoadedScene, StudyError> {
        let loaded = read_scene(&self.scene, &self.set)?;
        self.folder().claim()?;
        Ok(loaded)
    }

    fn folder(&self) -> StudyFolder<'_> {
        StudyFolder { path: &self.output }
    }

    /// Writes a file into the output folder and prints its name.
    pub fn write(&self, name: &str, content: &str) -> Result<(), StudyError> {
        self.folder().write(name, content, &context())
    }

    /// Writes a table as comma-separated values.
    pub fn write_table(&self, name: &str, table: &Table) -> Result<(), StudyError> {
        self.folder().write_table(name, table, &context())
    }
}

/// [`study::run_scene`] of this process.
pub fn run_scene(scene: &Scene, motion: &GroundMotion, threads: NonZeroUsize) -> Result<Outcome, StudyError> {
    study::run_scene(scene, motion, threads, &context())
}

/// [`study::run_all`] of this process.
pub fn run_all(scenes: &[LoadedScene]) -> Result<Vec<Outcome>, StudyError> {
    study::run_all(scenes, &context())
}

/// [`study::run_each`] of this process.
pub fn run_each<T: Send>(
    scenes: &[&LoadedScene],
    keep: impl Fn(usize, Outcome) -> Result<T, StudyError> + Sync,
) -> Result<Vec<T>, StudyError> {
    study::run_each(scenes, keep, &context())
}

/// [`study::run_units`].
pub fn run_units(scene: &Scene, motion: &GroundMotion, graph: Graph) -> Result<Outcome, StudyError> {
    study::run_units(scene, motion, graph)
}

/// A length of time, s.
pub fn seconds(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if (0.1..=1e6).contains(&value) { Ok(value) } else { Err("must be between 0.1 and 1e6 s".to_owned()) }
}
