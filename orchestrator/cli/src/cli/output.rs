//! What the command prints: words for people, or one answer for a program.

use serde::Serialize;
use std::io::{Error, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether standard output could not be written to though somebody reads it, such as a file on a full disk.
static OUTPUT_LOST: AtomicBool = AtomicBool::new(false);
/// Whether standard output is kept for an answer in JSON.
static FOR_PROGRAMS: AtomicBool = AtomicBool::new(false);
/// Whether that answer was given.
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// From here on [`say`] prints on standard error, and standard output is kept for [`answer`].
pub fn speak_to_programs() {
    FOR_PROGRAMS.store(true, Ordering::Relaxed);
}

/// Prints a line; a closed output does not end the program.
pub fn say(line: impl std::fmt::Display) {
    if FOR_PROGRAMS.load(Ordering::Relaxed) {
        complain(line);
    } else {
        written(writeln!(std::io::stdout(), "{line}"));
    }
}

/// Prints the answer of the command as a line of JSON, if it was asked for and not given yet.
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
        complain(format!("standard output: {cause}; what is printed from here on is lost"));
    }
}

/// The exit status of a command that ended with `status`: 1 in place of 0 if a part of what it printed is lost.
pub fn exit_status(status: ExitCode) -> ExitCode {
    let lost = OUTPUT_LOST.load(Ordering::Relaxed) && status == ExitCode::SUCCESS;
    if lost { ExitCode::FAILURE } else { status }
}

/// Prints a line on standard error; a closed output does not end the program.
pub fn complain(line: impl std::fmt::Display) {
    // If the output is closed, no reader is left.
    let _ = writeln!(std::io::stderr(), "{line}");
}
