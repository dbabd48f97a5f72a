//! `cofferdam log`.

use super::{DIFFERENT, complain, say};
use orchestrator::log::{
    Comparison, Log, LogReadError, LoggedStep, Overview, Recovery, RecoveryError, compare, recover, worst,
};
use orchestrator::participant::Occasion;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The commands for logs.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Show the contents of a log and how its run ended
    #[command(after_long_help = INFO_HELP)]
    Info {
        /// The log.mcap of a run, or the run's folder
        log: PathBuf,
    },
    /// List the communication steps with the most iterations
    #[command(after_long_help = WORST_HELP)]
    Worst {
        /// The log.mcap of a run, or the run's folder
        log: PathBuf,
        /// Number of steps
        #[arg(short, long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..))]
        count: u16,
    },
    /// Save what is whole in a damaged log, or in one that is cut short
    #[command(after_long_help = RECOVER_HELP)]
    Recover {
        /// The log.mcap of a run, or the run's folder
        log: PathBuf,
        /// The new log; by default log-recovered.mcap beside the old one
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Find the first difference between two logs, bit for bit
    #[command(after_long_help = DIFF_HELP)]
    Diff {
        /// The log.mcap of a run, or the run's folder
        a: PathBuf,
        /// The other log
        b: PathBuf,
    },
}

const INFO_HELP: &str = "\
A log that is cut short, for example because its run was killed, is read up to the cut; a damaged one
up to the damage. The index and the checksums of a finished log are compared with what was read. What a running log holds so
far is shown as such.

Example:
  cofferdam log info runs/koyna-northridge-1994-20260101T120000Z

Exit status: 0, also for a log that was cut short; 1 if it cannot be read or is damaged.";

const WORST_HELP: &str = "\
Every attempt of a step that was repeated with another length is listed. Iterations that measure and check the
units (Jacobian, rounding floor, restored states) count too, so that the first steps of a run are often at the top.

Example:
  cofferdam log worst runs/koyna-northridge-1994-20260101T120000Z --count 20

Exit status: 0, also for a log that was cut short; 1 if it cannot be read or is damaged.";

const RECOVER_HELP: &str = "\
Writes a new, finished log with every whole message of the old one, which is left as it is. Messages are stored in chunks
with a checksum: a chunk is saved whole or not at all. Where something is missing, the new log says so (topic /damage);
log info lists it, replay and log diff go as far as the first such place.

Example:
  cofferdam log recover runs/koyna-northridge-1994-20260101T120000Z --output saved.mcap

Exit status: 0, 1 if nothing can be saved, or the new log is there already or cannot be written.";

const DIFF_HELP: &str = "\
Exchanges are compared in their order, requests and answers, every value bit for bit. Different settings
are listed first. Wall times, the version of the program and messages of the units are not compared.

Example:
  cofferdam log diff runs/before runs/after

Exit status: 0 the exchanges are identical, 1 a log cannot be read to the first difference, 5 the exchanges differ.";

/// Runs the command; reports the result on the terminal and by the exit status.
pub fn run(command: &Command) -> ExitCode {
    let done: Result<bool, RecoveryError> = match command {
        Command::Info { log } => info(log).map(|()| true).map_err(Into::into),
        Command::Worst { log, count } => {
            list_worst(log, usize::from(*count)).map(|()| true).map_err(Into::into)
        }
        Command::Recover { log, output } => save(log, output.as_deref()).map(|()| true),
        Command::Diff { a, b } => diff(a, b).map_err(Into::into),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(DIFFERENT),
        Err(error) => {
            complain(format!("{:?}", miette::Report::msg(error)));
            ExitCode::FAILURE
        }
    }
}

fn info(path: &Path) -> Result<(), LogReadError> {
    let log = Log::open(path)?;
    let head = log.head();
    say(format!("{:<12} {}", "scene", head.scene.title));
    say(format!("{:<12} cofferdam {}, commit {}", "recorded by", head.version, head.commit));
    for unit in &head.units {
        say(format!("{:<12} {}", unit.name, unit.solver));
        say(format!("{:<12} fingerprint {}", "", unit.fingerprint));
    }
    let motion = &head.ground_motion;
    let samples = motion.acceleration.len();
    say(format!("{:<12} {}: {samples} samples, {} s apart", "ground", motion.source, motion.interval));
    let overview = Overview::of(&log)?;
    say(overview.to_string().trim_end());
    overview.error.map_or(Ok(()), Err)
}

fn list_worst(path: &Path, count: usize) -> Result<(), LogReadError> {
    let log = Log::open(path)?;
    say(format!(
        "{:>8} {:>12} {:>10} {:>7} {:>10} {:>12}  ",
        "step", "t, s", "H, s", "attempt", "iterations", "residual, Pa"
    ));
    for LoggedStep { occasion, accepted, converged, residual } in worst(&log, count)? {
        let Occasion { step, attempt, time, communication_step, iteration } = occasion;
        let how = match (accepted, converged) {
            (true, true) => "",
            (true, false) => "NOT CONVERGED, accepted",
            (false, true) => "repeated: its error was too large",
            (false, false) => "did not converge",
        };
        let line = format!(
            "{step:>8} {time:>12.6} {communication_step:>10.3e} {attempt:>7} {iteration:>10} {residual:>12.3e}  {how}"
        );
        say(line.trim_end());
    }
    Ok(())
}

fn save(path: &Path, output: Option<&Path>) -> Result<(), RecoveryError> {
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
    let output = output.map_or_else(|| folder.join("log-recovered.mcap"), Path::to_owned);
    let Recovery { messages, damage, mended, undeclared } = recover(path, &output)?;
    say(format!("wrote {}: {messages} messages", output.display()));
    for damage in damage {
        say(format!("{:<12} {damage}", "missing"));
    }
    for (place, cause) in mended {
        say(format!("{:<12} byte {place}: {cause}; no message was lost by it", "mended"));
    }
    if undeclared > 0 {
        say(format!("{:<12} {undeclared} messages of channels that are declared nowhere", "left out"));
    }
    Ok(())
}

/// Compares; true if the exchanges are identical.
fn diff(a: &Path, b: &Path) -> Result<bool, LogReadError> {
    let logs = [Log::open(a)?, Log::open(b)?];
    for (name, log) in ["a", "b"].into_iter().zip(&logs) {
        say(format!("{name}: {}", log.path().display()));
    }
    let comparison = compare(logs.each_ref())?;
    for setting in &comparison.settings {
        say(format!("  {setting}"));
    }
    say(verdict(&comparison));
    let identical = comparison.identical();
    comparison.error.map_or(Ok(identical), Err)
}

fn verdict(comparison: &Comparison) -> String {
    let Comparison { identical, endings, divergence, .. } = comparison;
    match (divergence, endings) {
        (Some(divergence), _) => divergence.report(["a", "b"]).to_string(),
        (None, [Some(a), Some(b)]) if [a, b] == ["completed"; 2] => {
            format!("identical: {identical} exchanges")
        }
        (None, [Some(a), Some(b)]) => format!("identical: {identical} exchanges; a: {a}; b: {b}"),
        (None, [Some(a), None]) => format!("a is shorter ({a}): {identical} identical exchanges, b goes on"),
        (None, [None, Some(b)]) => format!("b is shorter ({b}): {identical} identical exchanges, a goes on"),
        (None, [None, None]) => format!("{identical} identical exchanges before the damage"),
    }
}
