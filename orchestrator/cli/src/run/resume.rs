//! `cofferdam resume`.

use super::answer::NoAnswer;
use super::{Failure, carry_out, told};
use crate::context::context;
use crate::options::Options;
use crate::terminal::{answer, print};
use cofferdam_analysis::run::resume::{self, Resumption};
use cofferdam_coupling::observer::Status;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam resume`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The run's folder
    pub run: PathBuf,

    /// Go on though the program or the processor is another than that of the run
    ///
    /// The results are then those of two programs, and not bit for bit those of an uninterrupted run.
    #[arg(long)]
    pub other_build: bool,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
The run goes on after the last checkpoint in its log, in its own folder, and ends like one that was not
interrupted: log, histories and summary are the same, bit for bit, but for wall times. It does not matter
how it was interrupted: Ctrl-C, --until, a killed process, a full disk, a crash. What the log holds after
the checkpoint is computed again. The log is replaced once the new one holds all that came before the
checkpoint; until then the old one is left alone.

Units that give no state are asked again what the run asked them, up to the checkpoint.

Examples:
  cofferdam run scenes/koyna-northridge-1994 --until 5 --output runs/koyna
      The first five seconds.
  cofferdam resume runs/koyna
      The rest.

Exit status: as of `run`; 2 the run cannot be continued.";

/// Goes on with a run; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    arguments.options.begin();
    told(execute(arguments))
}

fn execute(arguments: &Arguments) -> Result<Status, Failure> {
    let options = &arguments.options;
    match resume::prepare(&arguments.run, arguments.other_build, &options.of_run(), &context())? {
        Resumption::Nothing(why) => {
            answer(&NoAnswer { status: why.clone(), exit_status: 0 });
            print(why);
            Ok(Status::Completed)
        }
        Resumption::Rest(run) => carry_out(*run, options),
    }
}
