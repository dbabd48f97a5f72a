//! `cofferdam log bisect`.

use super::Failure;
use crate::context::context;
use crate::terminal::print;
use cofferdam_analysis::bisect::{BisectError, Condition, Request, Tried, bisect};
use cofferdam_analysis::context::threads;
use cofferdam_log::Log;
use std::path::PathBuf;

/// Arguments of `cofferdam log bisect`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,

    /// Outcome at the end of the run: the largest magnitude of a quantity is above or below a value
    ///
    /// The quantity is sliding (m), opening (m), crest-displacement (m) or rotation (rad), followed by > or
    /// < and the value.
    #[arg(long, value_name = "CONDITION")]
    when: Condition,

    /// Number of checkpoints, spread over the run
    #[arg(long, value_name = "M", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=1000))]
    checkpoints: u16,

    /// Number of branches from each checkpoint
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    branches: u16,

    /// Amplitude of the perturbation of the ground acceleration, as a fraction of its peak
    ///
    /// From the checkpoint onwards, a random number between minus and plus this amplitude is added to each
    /// sample.
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3)]
    amount: f64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Number of threads (default: one per core)
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
}

pub const HELP: &str = "\
Runs N branches from each of M checkpoints to the end time of the run, each
with perturbed ground motion. The table shows how many branches have the same
outcome as the run, and the 95 % Wilson interval of this share. Early on, the
outcome may be open; from some checkpoint onwards, all branches have the same
outcome. All checkpoints are tried, because the share does not necessarily
increase from one to the next.

The units run in this process. Runs with units that are started by a command
are therefore not supported.

Example:
  cofferdam log bisect runs/koyna --when 'sliding > 0.05' --branches 20
      When did it become certain that the block would slide by more than 5 cm?

Exit status: 0; 1 if the log cannot be read; 2 if it has no checkpoint, or the
dam does not have the quantity; 4 if a unit cannot be created or fails.";

impl From<BisectError> for Failure {
    fn from(error: BisectError) -> Self {
        match error {
            BisectError::Log(cause) => Self::Log(cause),
            BisectError::Asked { path, cause } => Self::Asked { path, cause },
            BisectError::Again { path, cause } => Self::Again { path, cause },
        }
    }
}

/// Prints the share of branches that end like the run.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    let request = Request {
        when: arguments.when,
        checkpoints: arguments.checkpoints,
        branches: arguments.branches,
        amount: arguments.amount,
        seed: arguments.seed,
        threads: threads(arguments.threads),
    };
    let tried = bisect(&log, &request, &context())?;
    print(format!(
        "{:>8} {:>10} {:>12} {:>8}   {}",
        "step", "t, s", "same outcome", "share", "95 % interval"
    ));
    let all = usize::from(arguments.branches);
    for of_step @ Tried { step, time, alike, failed } in &tried {
        let [low, high] = of_step.interval(all);
        let share = *alike as f64 / all as f64;
        let failed = if *failed > 0 { format!("   {failed} failed") } else { String::new() };
        print(format!(
            "{step:>8} {time:>10.4} {:>12} {share:>8.2}   {low:.2} to {high:.2}{failed}",
            format!("{alike} of {all}")
        ));
    }
    let open = tried.iter().rposition(|tried| tried.alike < all);
    match tried.get(open.map_or(0, |open| open + 1)) {
        Some(first) => print(format!(
            "from t = {:.4} s onwards, all branches have the same outcome as the run",
            first.time
        )),
        None => print("not all branches have the same outcome as the run, even from the last checkpoint"),
    }
    Ok(())
}
