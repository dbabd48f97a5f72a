//! `cofferdam log bisect`.

use super::Failure;
use crate::cli::{making, other_build, parallel, say, threads};
use cofferdam_assembly::Assembly;
use cofferdam_assembly::log::{ground_motion_of, scene_of};
use cofferdam_assembly::simulation::ground_signal;
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::units::DAM;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start, Status, Until};
use cofferdam_coupling::run_state::RunState;
use cofferdam_coupling::scheme::{UnitId, WindowReport};
use cofferdam_log::replay::bring;
use cofferdam_log::{Entry, LastCheckpoint, Log};
use cofferdam_scene::StopQuantity;
use std::error::Error;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::atomic::AtomicBool;

/// Arguments of `cofferdam log bisect`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    log: PathBuf,

    /// The outcome: at the end of the run, the largest magnitude of a quantity is above or below a value
    ///
    /// sliding, opening, crest-displacement (m) or rotation (rad), then > or <, then the value.
    #[arg(long, value_name = "CONDITION")]
    when: Condition,

    /// Checkpoints, spread over the run
    #[arg(long, value_name = "M", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=1000))]
    checkpoints: u16,

    /// Branches from each
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    branches: u16,

    /// Largest change of a sample of the ground's acceleration, as a share of the record's peak
    ///
    /// From the checkpoint on, each sample is moved by a random number between minus and plus this.
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3)]
    amount: f64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Threads; by default one per core
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
}

pub const HELP: &str = "\
From each of M checkpoints N branches go on to the time at which the run ended, each with the ground moved a little
otherwise. The table shows how many end like the run itself, with the 95 % interval of Wilson for the
share: early on the outcome may be open, from some checkpoint on all branches end alike. The share need
not grow from checkpoint to checkpoint, so that all are tried.

The units run in this process, so that those of commands cannot be asked.

Example:
  cofferdam log bisect runs/koyna --when 'sliding > 0.05' --branches 20
      When was it certain that the block would slide by more than 5 cm?

Exit status: 0, 1 if the log cannot be read, 2 if it has no checkpoint or the dam no such quantity,
4 if a unit cannot be made or fails.";

/// Whether a quantity of the dam is above or below a value at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Condition {
    quantity: StopQuantity,
    above: bool,
    value: f64,
}

impl Condition {
    fn holds(&self, magnitude: f64) -> bool {
        if self.above { magnitude > self.value } else { magnitude < self.value }
    }
}

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || format!("`{text}` is no condition; write such as 'sliding > 0.05'");
        let (name, above, value) = match (text.split_once('>'), text.split_once('<')) {
            (Some((name, value)), None) => (name, true, value),
            (None, Some((name, value))) => (name, false, value),
            _ => return Err(wanted()),
        };
        let quantity = match name.trim() {
            "sliding" => StopQuantity::Sliding,
            "opening" => StopQuantity::Opening,
            "rotation" => StopQuantity::Rotation,
            "crest-displacement" => StopQuantity::CrestDisplacement,
            other => {
                let known = "sliding, opening, rotation and crest-displacement";
                return Err(format!("`{other}` is not known; there are {known}"));
            }
        };
        let value: f64 = value.trim().parse().map_err(|_| wanted())?;
        if value.is_finite() { Ok(Self { quantity, above, value }) } else { Err(wanted()) }
    }
}

/// Keeps the magnitude of a quantity of the dam at the end of the last accepted step.
#[derive(Default)]
struct Last {
    range: Range<usize>,
    magnitude: f64,
}

impl Observer for Last {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        let dam = report.steps.last().and_then(|step| report.accepted(DAM, step.step));
        if let Some(values) = dam.and_then(|dam| dam.outputs.get(self.range.clone())) {
            self.magnitude = magnitude(values);
        }
        Ok(())
    }

    fn end(&mut self, _: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

fn magnitude(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// A checkpoint, and how many branches from it end like the run.
struct Tried {
    step: u64,
    time: f64,
    alike: usize,
    failed: usize,
}

/// Prints the share of branches that end like the run.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    let again = |cause: Box<dyn Error + Send + Sync>| Failure::Again { path: log.path().to_owned(), cause };
    if !(0.0..=1.0).contains(&arguments.amount) {
        let cause = format!("--amount {} is no share; give one from 0 to 1", arguments.amount);
        return Err(Failure::Asked { path: log.path().to_owned(), cause });
    }
    let condition = arguments.when;
    let variable = condition.quantity.variable().unwrap_or_default();
    let Some(range) = log.head().units[DAM.0].outputs.range(variable) else {
        let cause = format!("the dam has no `{variable}`; choose another quantity in --when");
        return Err(Failure::Asked { path: log.path().to_owned(), cause });
    };
    let mut end = None;
    let last = log.last_before("/step", u64::MAX)?.and_then(|entry| entry.step()).unwrap_or(0);
    for entry in log.entries_from(last)? {
        if let Entry::Exchange(exchange) = entry?
            && exchange.accepted
            && exchange.unit == DAM
        {
            end = exchange.outputs.map(|values| (exchange.occasion, magnitude(&values[range.clone()])));
        }
    }
    let checkpoints = spread(&log, last, arguments.checkpoints.into())?;
    let (Some((at, reached)), false) = (end, checkpoints.is_empty()) else {
        let cause = "the log has no checkpoint; run with log.checkpoint_share above 0".to_owned();
        return Err(Failure::Asked { path: log.path().to_owned(), cause });
    };
    if let Some(why) = other_build(log.head()) {
        say(format!("note: {why}"));
    }
    let outcome = condition.holds(reached);
    let word = condition.quantity.word();
    say(format!(
        "the run ends at t = {:.4} s with {word} {reached:.5}: the condition {}",
        at.end(),
        if outcome { "holds" } else { "does not hold" }
    ));
    let workers =
        threads(arguments.threads).min(NonZeroUsize::new(checkpoints.len()).unwrap_or(NonZeroUsize::MIN));
    // Each worker makes its units once.
    let shares: Vec<Vec<&LastCheckpoint>> = (0..workers.get())
        .map(|worker| checkpoints.iter().skip(worker).step_by(workers.get()).collect())
        .collect();
    let work = |share: &Vec<&LastCheckpoint>| try_share(&log, share, arguments, &range, (at.end(), outcome));
    let tried = parallel::try_map(&shares, workers, work).map_err(again)?;
    let mut tried: Vec<Tried> = tried.into_iter().flatten().collect();
    tried.sort_by_key(|tried| tried.step);

    say(format!("{:>8} {:>10} {:>12} {:>8}   {}", "step", "t, s", "end like it", "share", "95 % interval"));
    let all = usize::from(arguments.branches);
    for Tried { step, time, alike, failed } in &tried {
        let [low, high] = wilson(*alike, all);
        let share = *alike as f64 / all as f64;
        let failed = if *failed > 0 { format!("   {failed} failed") } else { String::new() };
        say(format!(
            "{step:>8} {time:>10.4} {:>12} {share:>8.2}   {low:.2} to {high:.2}{failed}",
            format!("{alike} of {all}")
        ));
    }
    let open = tried.iter().rposition(|tried| tried.alike < all);
    match tried.get(open.map_or(0, |open| open + 1)) {
        Some(first) => say(format!("from t = {:.4} s on, all branches end like the run", first.time)),
        None => say("even from the last checkpoint, not all branches end like the run"),
    }
    Ok(())
}

/// Up to `count` checkpoints, spread evenly over the steps of a log up to `last`.
fn spread(log: &Log, last: u64, count: u64) -> Result<Vec<LastCheckpoint>, Failure> {
    let mut found: Vec<LastCheckpoint> = Vec::new();
    for number in 1..=count {
        if let Some(checkpoint) = log.checkpoint(last * number / (count + 1))?
            && found.last().is_none_or(|before| before.step < checkpoint.step)
        {
            found.push(checkpoint);
        }
    }
    Ok(found)
}

/// Goes on from each of some checkpoints to the time at which the run ended, with units that are made once. `end` has that time (s)
/// and the outcome.
fn try_share(
    log: &Log,
    share: &[&LastCheckpoint],
    arguments: &Arguments,
    range: &Range<usize>,
    (end, outcome): (f64, bool),
) -> Result<Vec<Tried>, Box<dyn Error + Send + Sync>> {
    let scene = &scene_of(log)?;
    let motion = ground_motion_of(log);
    let peak = motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    let graph = Assembly::with(scene, making(NonZeroUsize::MIN)).graph()?;
    let mut simulation = simulation_of(scene, &motion, graph)?;
    let fingerprint = simulation.fingerprint()?;
    let mut tried = Vec::new();
    for checkpoint in share {
        let state = RunState::from_bytes(fingerprint, &checkpoint.run)?;
        let ids: Vec<UnitId> = simulation.graph.ids().collect();
        for id in ids {
            let unit = &mut simulation.graph[id];
            let given = checkpoint.units.get(id.0).and_then(Option::as_ref);
            if let Some((_, state)) = given {
                unit.deserialise(state)?;
            }
            let stands = given.map(|(step, _)| *step);
            if stands != Some(checkpoint.step) {
                bring(log, id, unit, stands, checkpoint.step, |_| ())?;
            }
        }
        let units = simulation.graph.serialise()?;
        let (mut alike, mut failed) = (0, 0);
        for branch in 0..u64::from(arguments.branches) {
            let mut random = fastrand::Rng::with_seed(seed_of(arguments.seed, checkpoint.step, branch));
            let change = || arguments.amount * peak * (2.0 * random.f64() - 1.0);
            simulation.scheme.replace_signal(ground_signal(&motion.moved_after(checkpoint.time, change)));
            simulation.graph.deserialise(&units)?;
            let mut course = simulation.course();
            simulation.branch(&mut course, &state)?;
            let mut last = Last { range: range.clone(), ..Last::default() };
            let mut until = Until::new(Some(end));
            let observers: &mut [&mut dyn Observer] = &mut [&mut last, &mut until];
            let (ending, _) = simulation.conclude(&mut course, Ok(()), observers, &AtomicBool::new(false));
            match ending.status {
                Status::Failed(_) => failed += 1,
                _ => alike += usize::from(arguments.when.holds(last.magnitude) == outcome),
            }
        }
        let LastCheckpoint { step, time, .. } = checkpoint;
        tried.push(Tried { step: *step, time: *time, alike, failed });
    }
    Ok(tried)
}

/// The seed of a branch: other streams for every seed, step and number.
fn seed_of(seed: u64, step: u64, branch: u64) -> u64 {
    fastrand::Rng::with_seed(seed).u64(..) ^ (step << 16) ^ branch
}

/// The interval of a share of which `hits` of `all` are known, 95 %.
///
/// ```text
/// (p + z²/2n ± z √(p(1 − p)/n + z²/4n²)) / (1 + z²/n),  z = 1.96
/// ```
///
/// **Source**: Wilson (1927).
fn wilson(hits: usize, all: usize) -> [f64; 2] {
    let (n, z2) = (all as f64, 1.96f64.powi(2));
    let p = hits as f64 / n;
    let half = (z2 * (p * (1.0 - p) / n + z2 / (4.0 * n * n))).sqrt();
    [-half, half].map(|half| ((p + z2 / (2.0 * n) + half) / (1.0 + z2 / n)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_share_is_that_of_wilson() {
        // Newcombe (1998), table I: 81 of 263, 15 of 148, 0 of 20, 29 of 29.
        for (hits, all, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (29, 29, 0.8830, 1.0),
        ] {
            let [a, b] = wilson(hits, all);
            assert!((a - low).abs() < 1e-4 && (b - high).abs() < 1e-4, "{hits} of {all}: {a} to {b}");
        }
    }

    #[test]
    fn no_two_branches_have_the_same_stream() {
        let mut seeds = std::collections::BTreeSet::new();
        for seed in 0..20 {
            for step in [1, 2, 16, 9_999] {
                assert!((0..20).all(|branch| seeds.insert(seed_of(seed, step, branch))));
            }
        }
    }

    #[test]
    fn conditions_are_read_and_others_named() {
        let read = |text: &str| text.parse::<Condition>();
        let sliding = Condition { quantity: StopQuantity::Sliding, above: true, value: 0.05 };
        assert_eq!(read("sliding > 0.05"), Ok(sliding));
        assert!(sliding.holds(0.06) && !sliding.holds(0.05));
        let below = read("rotation<1e-3").map(|condition| condition.holds(0.0));
        assert_eq!(below, Ok(true));
        for wrong in ["sliding", "sliding > x", "slip > 1", "sliding > inf", "a > 1 < 2"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
