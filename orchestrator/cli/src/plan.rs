//! `cofferdam plan`.

use crate::context::context;
use crate::terminal::{print, show_warnings, warn};
use cofferdam_analysis::plan::{self, PlanError};
use cofferdam_assembly::read_scene;
use std::path::PathBuf;
use std::process::ExitCode;

pub const HELP: &str = "\
Reads a scene and says, without running it, what will be modelled and what is left out, each by a criterion with its number: the
frequencies of the record against the cut-off of the reservoir and against gravity waves, absorption at the bed, each crack's
strength against the demand, elements and steps against the record, modes, damping; then the error that is expected of each
quantity from the table of measured errors (docs/measurements/accuracy.md), time and disk. `cofferdam run --accuracy` writes the same rows
into its manifest as [[plan]].

Example:
  cofferdam plan scenes/koyna-northridge-1994

Exit status: 0, 2 the scene is wrong, 4 a unit cannot be made.";

/// Arguments of `cofferdam plan`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder that holds scene.toml, or a .toml file
    scene: PathBuf,

    /// Change a value of the scene; may be given several times
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
