//! `cofferdam log recover`.

use super::Failure;
use crate::terminal::print;
use cofferdam_log::{Recovery, recover};
use std::path::{Path, PathBuf};

/// Arguments of `cofferdam log recover`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Log to write (default: log-recovered.mcap in the folder of the old log)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub const HELP: &str = "\
Writes a new, complete log with all intact messages of the old one, which is
not modified. Messages are stored in chunks with checksums; a chunk is
recovered as a whole or not at all. The new log marks each gap (topic /damage).
`log info` lists the gaps; `replay` and `log diff` stop at the first one.

Example:
  cofferdam log recover runs/koyna-northridge-1994-20260101T120000Z \\
    --output saved.mcap

Exit status: 0; 1 if nothing can be recovered, or the new log exists or cannot
be written.";

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
        print(format!("{:<12} byte {place}: {cause}; no message was lost", "mended"));
    }
    if undeclared > 0 {
        print(format!("{:<12} {undeclared} messages of undeclared channels", "left out"));
    }
    Ok(())
}
