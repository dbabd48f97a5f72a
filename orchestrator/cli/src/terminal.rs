//! Output of the command: text for people, or one JSON result for a program.

use cofferdam_analysis::context::Reporter;
use cofferdam_scene::SceneWarning;
use serde::Serialize;
use std::io::{Error, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether standard output could not be written to though somebody reads it, such as a file on a full disk.
static OUTPUT_LOST: AtomicBool = AtomicBool::new(false);
/// Whether standard output is reserved for a result in JSON.
static FOR_PROGRAMS: AtomicBool = AtomicBool::new(false);
/// Whether that result was printed.
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// From here on [`print()`] prints on standard error, and standard output is kept for [`answer`].
pub fn answer_programs() {
    FOR_PROGRAMS.store(true, Ordering::Relaxed);
}

/// Prints a line; a closed output does not end the program.
pub fn print(line: impl std::fmt::Display) {
    if FOR_PROGRAMS.load(Ordering::Relaxed) {
        warn(line);
    } else {
        written(writeln!(std::io::stdout(), "{line}"));
    }
}

/// Prints the result of the command as a line of JSON, if requested and not yet printed.
pub fn answer(value: &impl Serialize) {
    if FOR_PROGRAMS.load(Ordering::Relaxed) && !ANSWERED.swap(true, Ordering::Relaxed) {
        let text = serde_json::to_string(value).map_err(Error::from);
        written(text.and_then(|text| writeln!(std::io::stdout(), "{text}")));
    }
}

fn written(done: Result<(), Error>) {
    // If the output is closed, no reader is left.
    if let Err(cause) = done
        && cause.kind() != ErrorKind::BrokenPipe
        && !OUTPUT_LOST.swap(true, Ordering::Relaxed)
    {
        warn(format!("standard output: {cause}; further output is lost"));
    }
}

/// The exit status of a command that ended with `status`: 1 in place of 0 if a part of what it printed is lost.
pub fn exit_status(status: ExitCode) -> ExitCode {
    let lost = OUTPUT_LOST.load(Ordering::Relaxed) && status == ExitCode::SUCCESS;
    if lost { ExitCode::FAILURE } else { status }
}

/// Prints a line on standard error; a closed output does not end the program.
pub fn warn(line: impl std::fmt::Display) {
    // If the output is closed, no reader is left.
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Shows what is doubtful about a scene.
pub fn show_warnings(warnings: &[SceneWarning]) {
    for warning in warnings {
        warn(format!("{:?}", miette::Report::new(warning.clone())));
    }
}

/// Exit status if responses or logs that should be identical differ.
pub const DIFFERENT: u8 = 5;

/// Where the library reports to.
pub struct Terminal;

impl Reporter for Terminal {
    fn line(&self, text: &str) {
        print(text);
    }

    fn warning(&self, text: &str) {
        warn(text);
    }

    fn scene_warnings(&self, warnings: &[SceneWarning]) {
        show_warnings(warnings);
    }
}
