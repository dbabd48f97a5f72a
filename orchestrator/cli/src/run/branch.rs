//! `cofferdam branch`.

use super::{Failure, carry_out, told};
use crate::context::context;
use crate::options::Options;
use cofferdam_analysis::run::branch;
use cofferdam_coupling::observer::Status;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam branch`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    pub run: PathBuf,

    /// First step to compute with the changed settings; earlier steps are taken from the run
    ///
    /// In a window of several steps, the first step of the window.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub step: u64,

    /// Change a setting from this step onwards (repeatable)
    ///
    /// For example coupling.acceleration=iqn-ils or dam.cracks.0.friction_coefficient=0.8.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for the results (default: runs/RUN-branch-N)
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
The branch takes the windows before step N from the log of the run and
continues from the state at that step with the changed settings. It is a run of
its own, with a log, histories and a report that name the parent run. At the
end, the branch is compared with the parent run.

A unit whose parameters are unchanged continues from its state. So does a dam
with changes only to friction, cohesion or tensile strength of its cracks. Any
other unit is replaced by a new one, which first repeats all requests logged so
far; it must have the same variables and interface points. The acceleration
keeps its history unless it is changed.

Examples:
  cofferdam branch runs/koyna --step 2846 --set coupling.acceleration=iqn-ils
      Does this step converge with another acceleration?
  cofferdam branch runs/koyna --step 1200 \\
    --set dam.cracks.0.friction_coefficient=0.8
      What if the crack were weaker from this step onwards?
  cofferdam branch runs/koyna --step 1200
      Nothing changed: repeats the run, bit for bit.

Exit status: as for `run`; 2 if no branch is possible at this step.";

/// Leaves a run; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    arguments.options.begin();
    told(execute(arguments))
}

fn execute(arguments: &Arguments) -> Result<Status, Failure> {
    let Arguments { run, step, set, output, options } = arguments;
    let request = branch::Request {
        run: run.clone(),
        step: *step,
        settings: set.clone(),
        output: output.clone(),
        options: options.of_run(),
    };
    carry_out(branch::prepare(&request, &context())?, options)
}
