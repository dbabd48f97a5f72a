//! Lines for people.

use cofferdam_analysis::context::Reporter;
use std::io::Write;

/// Prints a line; a closed output does not end the program.
pub fn print(line: impl std::fmt::Display) {
    // If the output is closed, no reader is left.
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Prints a line on standard error; a closed output does not end the program.
pub fn warn(line: impl std::fmt::Display) {
    // If the output is closed, no reader is left.
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Where the library reports to.
pub struct Terminal;

impl Reporter for Terminal {
    fn line(&self, text: &str) {
        print(text);
    }

    fn warning(&self, text: &str) {
        warn(text);
    }
}
