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
    /// Folder of the run
    pub run: PathBuf,

    /// Resume even if the program or the processor differs from that of the run
    ///
    /// The results are then not bit-identical to those of an uninterrupted run.
    #[arg(long)]
    pub other_build: bool,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
The run continues in its own folder from the last checkpoint in its log. The
log, histories and summary are bit-identical to those of an uninterrupted run,
except for wall times. The cause of the interruption does not matter: Ctrl-C,
--until, a killed process, a full disk or a crash. Steps after the checkpoint
are computed again. The old log is replaced only when the new one contains
everything up to the checkpoint.

Units that cannot save their state are advanced to the checkpoint by repeating
the logged requests.

Examples:
  cofferdam run scenes/koyna-northridge-1994 --until 5 --output runs/koyna
      The first five seconds.
  cofferdam resume runs/koyna
      The remainder.

Exit status: as for `run`; 2 if the run cannot be resumed.";

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
