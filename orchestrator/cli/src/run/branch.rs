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
    /// The log.mcap of a run, or the run's folder
    pub run: PathBuf,

    /// First step that is computed otherwise; all before is that of the run
    ///
    /// Inside a window of several steps, the window's first.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub step: u64,

    /// Set a value otherwise from there on; may be given several times
    ///
    /// Such as coupling.acceleration=iqn-ils or dam.cracks.0.friction_coefficient=0.8.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for the results; by default runs/RUN-branch-N
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
The branch begins with the windows of the run before step N, taken from its log, and goes on from the
state there with what is set otherwise. It is a run of its own, with a log, histories and a report, which
name the run that it left; at the end both are compared.

A unit that is made from the same as before goes on from its state, also a dam of which only friction,
cohesion or tensile strength of cracks are another. Any other unit takes the place of the run's after it
was asked what that one was asked until then; it must exchange the same variables at the same points.
The acceleration keeps what it learnt unless it is set otherwise.

Examples:
  cofferdam branch runs/koyna --step 2846 --set coupling.acceleration=iqn-ils
      Does that step converge with another acceleration?
  cofferdam branch runs/koyna --step 1200 --set dam.cracks.0.friction_coefficient=0.8
      What if the crack were weaker from there on?
  cofferdam branch runs/koyna --step 1200
      Nothing changed: the same run again, bit for bit.

Exit status: as of `run`; 2 there is no way to branch there.";

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
