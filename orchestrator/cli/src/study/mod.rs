//! `cofferdam study`: series of runs, their tables and pictures.

use cofferdam_assembly::read_scene;
mod sensitivity;

use crate::context::context;
use crate::terminal::warn;
use cofferdam_analysis::accuracy::AccuracyError;
use cofferdam_analysis::study::{StudyError, StudyFolder};
use cofferdam_analysis::table::Table;
use cofferdam_scene::LoadedScene;
use std::path::PathBuf;
use std::process::ExitCode;

/// The studies.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Compute how much the results depend on mesh, time steps and modelling choices
    #[command(after_long_help = sensitivity::HELP)]
    Sensitivity(Arguments),
}

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

/// Runs a study and reports the result.
pub fn run(command: &Command) -> ExitCode {
    let Command::Sensitivity(arguments) = command;
    match sensitivity::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match &error {
                StudyError::Scene(_) | StudyError::Unfit { .. } | StudyError::Record { .. } => 2,
                StudyError::Run { .. } => 3,
                StudyError::Accuracy(AccuracyError::Scene(_) | AccuracyError::Unfit { .. }) => 2,
                StudyError::Accuracy(AccuracyError::Run { .. }) => 3,
                StudyError::Accuracy(AccuracyError::Unit(_)) => 4,
                StudyError::Unit(_) => 4,
                StudyError::File { .. } | StudyError::OutputTaken { .. } => 1,
            };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
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
