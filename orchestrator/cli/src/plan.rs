//! `cofferdam plan`.

use crate::context::context;
use crate::terminal::{print, show_warnings, warn};
use cofferdam_analysis::plan::{self, PlanError};
use cofferdam_assembly::read_scene;
use std::path::PathBuf;
use std::process::ExitCode;

pub const HELP: &str = "\
Reads a scene and lists, without running it, what a run will model and what it
will neglect. Every row gives a criterion and its value: the frequencies of the
record relative to the cut-off frequency of the reservoir and to gravity waves,
absorption at the bed, the strength of each crack relative to the demand,
elements and steps relative to the record, modes, and damping. Then come the
numerical error of each quantity, from the table of measured errors
(docs/measurements/accuracy.md), the time and the disk space.
`cofferdam run --accuracy` writes the same rows to its manifest as [[plan]].

Example:
  cofferdam plan scenes/koyna-northridge-1994

Exit status: 0 printed, 2 the scene is invalid, 4 a unit cannot be created.";

/// Arguments of `cofferdam plan`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    scene: PathBuf,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Prints the plan of a scene.
pub fn run(arguments: &Arguments) -> ExitCode {
    let execute = || -> Result<(), PlanError> {
        let loaded = read_scene(&arguments.scene, &arguments.set)?;
        show_warnings(&loaded.warnings);
        print(&loaded.scene.title);
        for row in plan::rows(&loaded, &context())? {
            print(plan::text(&row));
        }
        Ok(())
    };
    match execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if matches!(error, PlanError::Scene(_)) { 2 } else { 4 };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}
