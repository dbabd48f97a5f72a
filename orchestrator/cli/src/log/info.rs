//! `cofferdam log info`.

use super::Failure;
use crate::terminal::print;
use cofferdam_log::LoggedExchanges;
use cofferdam_log::{Log, Overview, Parent};
use std::path::PathBuf;

/// Arguments of `cofferdam log info`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
}

pub const HELP: &str = "\
A log that is cut short, for example because its run was killed, is read up to
the cut; a damaged one up to the damage. The index and the checksums of a
finished log are verified. The log of a run in progress is identified as such.

Example:
  cofferdam log info runs/koyna-northridge-1994-20260101T120000Z

Exit status: 0, also for a log that is cut short; 1 if it cannot be read or is
damaged.";

/// Prints the contents of a log.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::open(&arguments.log)?;
    let head = log.head();
    print(format!("{:<12} {}", "scene", head.title().unwrap_or_default()));
    print(format!("{:<12} cofferdam {}, commit {}", "recorded by", head.version, head.commit));
    if !head.started.is_empty() {
        print(format!("{:<12} {}", "started", head.started));
        print(format!("{:<12} {}, {} ({})", "machine", head.system, head.processor, head.features));
    }
    if let Some(Parent { log, step, settings }) = &head.parent {
        let settings = if settings.is_empty() { "nothing" } else { settings };
        print(format!(
            "{:<12} {log} after step {step}, with {} changed",
            "branch of",
            settings.replace('\n', ", ")
        ));
    }
    for unit in &head.units {
        print(format!("{:<12} {}", unit.name, unit.solver));
        print(format!("{:<12} fingerprint {}", "", unit.fingerprint));
    }
    for signal in &head.signals {
        let name = match &*signal.name {
            "ground_motion" => "ground",
            "ground_motion_vertical" => "vertical",
            name => name,
        };
        let (source, samples, interval) = (&signal.source, signal.samples.len(), signal.interval);
        print(format!("{name:<12} {source}: {samples} samples, {interval} s apart"));
    }
    match head.exchanges {
        LoggedExchanges::Every => {}
        LoggedExchanges::Accepted => {
            print(format!("{:<12} unaccepted exchanges of accepted steps", "left out"))
        }
        LoggedExchanges::None => print(format!("{:<12} all exchanges, steps and iterations", "left out")),
    }
    let overview = Overview::of(&log)?;
    print(overview.to_string().trim_end());
    overview.error.map_or(Ok(()), |error| Err(error.into()))
}
