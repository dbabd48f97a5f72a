//! `cofferdam log worst`.

use super::Failure;
use crate::terminal::print;
use cofferdam_coupling::participant::Occasion;
use cofferdam_log::{Log, LoggedStep, worst};
use std::path::PathBuf;

/// Arguments of `cofferdam log worst`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Number of steps to list
    #[arg(short, long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..))]
    count: u16,
}

pub const HELP: &str = "\
A step that was repeated with another length is listed once for each attempt.
Iterations that measure and check the units (Jacobian, rounding floor, restored
states) count too, so the first steps of a run are often at the top. Steps with
the same number of iterations, as in an explicit scheme, are sorted by
decreasing residual.

Example:
  cofferdam log worst runs/koyna-northridge-1994-20260101T120000Z --count 20

Exit status: 0, also for a log that is cut short; 1 if it cannot be read or is
damaged.";

/// Prints the steps with the most iterations.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    print(format!(
        "{:>8} {:>12} {:>10} {:>7} {:>10} {:>12}  ",
        "step", "t, s", "H, s", "attempt", "iterations", "residual, Pa"
    ));
    let worst = worst(&log, usize::from(arguments.count))?;
    for LoggedStep { occasion, accepted, converged, residual, .. } in &worst {
        let Occasion { step, attempt, time, communication_step, iteration } = *occasion;
        let how = match (accepted, converged) {
            (true, true) => "",
            (true, false) => "NOT CONVERGED, accepted",
            (false, true) => "repeated: its error was too large",
            (false, false) => "did not converge",
        };
        let line = format!(
            "{step:>8} {time:>12.6} {communication_step:>10.3e} {attempt:>7} {iteration:>10} {residual:>12.3e}  {how}"
        );
        print(line.trim_end());
    }
    if let Some(first) = worst.first() {
        let (path, step) = (arguments.log.display(), first.occasion.step);
        print(format!("what happened in the first: cofferdam log show {path} --step {step}"));
    }
    Ok(())
}
