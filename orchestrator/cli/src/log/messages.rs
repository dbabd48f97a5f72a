//! `cofferdam log messages`.

use super::{Failure, unit_named};
use crate::terminal::print;
use clap::ValueEnum;
use cofferdam_coupling::participant::{Level, Message};
use cofferdam_log::{Entry, Log};
use std::path::PathBuf;

/// Arguments of `cofferdam log messages`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Show the messages of this unit only
    #[arg(short, long, value_name = "NAME")]
    unit: Option<String>,
    /// Lowest level to show
    #[arg(short, long, value_enum, default_value_t = Least::Debug)]
    level: Least,
}

/// The lowest level that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Least {
    /// For developers of the unit
    Debug,
    /// Normal progress
    Information,
    /// Results may be doubtful
    Warning,
    /// The unit cannot continue
    Error,
}

impl From<Least> for Level {
    fn from(least: Least) -> Self {
        match least {
            Least::Debug => Self::Debug,
            Least::Information => Self::Information,
            Least::Warning => Self::Warning,
            Least::Error => Self::Error,
        }
    }
}

pub const HELP: &str = "\
Prints one line per message: step and iteration, the simulated time at the
start of the step, level, unit, module and text. Further lines of a text, such
as a traceback, are indented. Step 0 is initialisation.

Examples:
  cofferdam log messages runs/koyna-northridge-1994-20260101T120000Z -l warning
  cofferdam log messages runs/own-water --unit reservoir

Exit status: 0, also for a log that is cut short or has no such message; 1 if
it cannot be read or is damaged; 2 if it has no such unit.";

/// Prints the messages of the units.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::open(&arguments.log)?;
    if let Some(name) = &arguments.unit {
        unit_named(&log, name)?;
    }
    let wanted = |message: &Message| {
        message.level >= arguments.level.into()
            && arguments.unit.as_ref().is_none_or(|unit| *unit == message.unit)
    };
    let mut shown = 0_u64;
    for entry in log.entries()? {
        match entry? {
            Entry::Message(message) if wanted(&message) => {
                shown += 1;
                print(lines(&message));
            }
            Entry::Damage(damage) => print(format!("missing: {damage}")),
            _ => {}
        }
    }
    if shown == 0 {
        print("no such message");
    }
    Ok(())
}

/// A message as text.
pub fn lines(message: &Message) -> String {
    let Message { unit, level, step, iteration, time, source, text } = message;
    let mut lines = text.trim_end().lines();
    let first = lines.next().unwrap_or_default();
    let from = if source.is_empty() { unit.clone() } else { format!("{unit} ({source})") };
    let head = format!("step {step}, iteration {iteration}, t = {time:.6} s: {level}: {from}: {first}");
    std::iter::once(head)
        .chain(lines.map(|line| format!("    {line}").trim_end().to_owned()))
        .collect::<Vec<_>>()
        .join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_traceback_is_shown_whole() {
        let message = Message {
            unit: "reservoir".to_owned(),
            level: Level::Error,
            step: 7,
            iteration: 2,
            time: 0.015,
            source: String::new(),
            text: "Traceback:\n  line 3\n\nValueError: x\n".to_owned(),
        };
        let head = "step 7, iteration 2, t = 0.015000 s: error: reservoir: Traceback:";
        assert_eq!(lines(&message), format!("{head}\n      line 3\n\n    ValueError: x"));
    }
}
