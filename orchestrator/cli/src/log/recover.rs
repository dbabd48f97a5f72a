//! `cofferdam log recover`.

use super::Failure;
use crate::terminal::print;
use cofferdam_log::{Recovery, recover};
use std::path::{Path, PathBuf};

/// Arguments of `cofferdam log recover`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    log: PathBuf,
    /// The new log; by default log-recovered.mcap beside the old one
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub const HELP: &str = "\
Writes a new, finished log with every whole message of the old one, which is left as it is. Messages are
stored in chunks with a checksum: a chunk is saved whole or not at all. Where something is missing, the
new log says so (topic /damage); log info lists it, replay and log diff go as far as the first such place.

Example:
  cofferdam log recover runs/koyna-northridge-1994-20260101T120000Z --output saved.mcap

Exit status: 0, 1 if nothing can be saved, or the new log is there already or cannot be written.";

/// Saves what is whole in a log.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.log;
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
    let output = arguments.output.clone().unwrap_or_else(|| folder.join("log-recovered.mcap"));
    let Recovery { messages, damage, mended, undeclared } = recover(path, &output)?;
    print(format!("wrote {}: {messages} messages", output.display()));
    for damage in damage {
        print(format!("{:<12} {damage}", "missing"));
    }
    for (place, cause) in mended {
        print(format!("{:<12} byte {place}: {cause}; no message was lost by it", "mended"));
    }
    if undeclared > 0 {
        print(format!("{:<12} {undeclared} messages of channels that are declared nowhere", "left out"));
    }
    Ok(())
}
