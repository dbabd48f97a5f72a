//! From which checkpoint of a run on its outcome is certain.

use crate::context::Context;
use crate::parallel;
use crate::provenance::other_build;
use cofferdam_assembly::Assembly;
use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::log::{ground_motion_of, scene_of};
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::units::DAM;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start, Status, Until};
use cofferdam_coupling::run_state::RunState;
use cofferdam_coupling::scheme::{UnitId, WindowReport};
use cofferdam_log::replay::bring;
use cofferdam_log::{Entry, LastCheckpoint, Log, LogReadError};
use cofferdam_scene::StopQuantity;
use std::error::Error;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::atomic::AtomicBool;

/// Branches from checkpoints of a run.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// The outcome.
    pub when: Condition,
    /// Checkpoints, spread over the run.
    pub checkpoints: u16,
    /// Branches from each.
    pub branches: u16,
    /// Largest change of a sample of the ground's acceleration, as a share of the peak of its component.
    pub amount: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Branches at the same time.
    pub threads: NonZeroUsize,
}

/// Reason why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum BisectError {
    /// The log cannot be read, or not to its end.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// This log does not contain the requested data.
    #[error("{}: {cause}", path.display())]
    Asked {
        /// The log.
        path: PathBuf,
        /// The cause and the remedy.
        cause: String,
    },
    /// A run cannot be made again from its log.
    #[error("{}: {cause}", path.display())]
    Again {
        /// The log.
        path: PathBuf,
        /// The cause.
        cause: Box<dyn Error + Send + Sync>,
    },
}

/// Whether a quantity of the dam is above or below a value at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// The quantity.
    pub quantity: StopQuantity,
    /// Whether it must be above the value, not below.
    pub above: bool,
    /// The value, in m or rad.
    pub value: f64,
}

impl Condition {
    /// Whether a magnitude fulfils it.
    pub fn holds(&self, magnitude: f64) -> bool {
        if self.above { magnitude > self.value } else { magnitude < self.value }
    }
}

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || format!("`{text}` is not a condition; write for example 'sliding > 0.05'");
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
                return Err(format!("`{other}` is unknown; the quantities are {known}"));
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    /// The checkpoint's step.
    pub step: u64,
    /// Its time, s.
    pub time: f64,
    /// Branches that end like the run.
    pub alike: usize,
    /// Branches that failed.
    pub failed: usize,
}

impl Tried {
    /// The 95 % interval of the share of `all` branches that end like the run.
    pub fn interval(&self, all: usize) -> [f64; 2] {
        wilson(self.alike, all)
    }
}

/// From several checkpoints of the run of `log`, branches continue to the end time of the run, each with a slightly perturbed
/// ground motion. The units run in this process.
///
/// **Errors**: [`BisectError`].
pub fn bisect(log: &Log, request: &Request, context: &Context<'_>) -> Result<Vec<Tried>, BisectError> {
    let again =
        |cause: Box<dyn Error + Send + Sync>| BisectError::Again { path: log.path().to_owned(), cause };
    if !(0.0..=1.0).contains(&request.amount) {
        let cause = format!("--amount {} is not a share; give a number between 0 and 1", request.amount);
        return Err(BisectError::Asked { path: log.path().to_owned(), cause });
    }
    let condition = request.when;
    let variable = condition.quantity.variable().unwrap_or_default();
    let Some(range) = log.head().units[DAM.0].outputs.range(variable) else {
        let cause = format!("the dam has no `{variable}`; choose another quantity in --when");
        return Err(BisectError::Asked { path: log.path().to_owned(), cause });
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
    let checkpoints = spread(log, last, request.checkpoints.into())?;
    let (Some((at, reached)), false) = (end, checkpoints.is_empty()) else {
        let cause = "the log has no checkpoint; run with log.checkpoint_share above 0".to_owned();
        return Err(BisectError::Asked { path: log.path().to_owned(), cause });
    };
    if let Some(why) = other_build(log.head()) {
        context.line(format!("note: {why}"));
    }
    let outcome = condition.holds(reached);
    let word = condition.quantity.word();
    context.line(format!(
        "the run ends at t = {:.4} s with {word} {reached:.5}: the condition {}",
        at.end(),
        if outcome { "holds" } else { "does not hold" }
    ));
    let workers = request.threads.min(NonZeroUsize::new(checkpoints.len()).unwrap_or(NonZeroUsize::MIN));
    // Each worker makes its units once.
    let shares: Vec<Vec<&LastCheckpoint>> = (0..workers.get())
        .map(|worker| checkpoints.iter().skip(worker).step_by(workers.get()).collect())
        .collect();
    let work =
        |share: &Vec<&LastCheckpoint>| try_share(log, share, request, &range, (at.end(), outcome), context);
    let tried = parallel::try_map(&shares, workers, work).map_err(again)?;
    let mut tried: Vec<Tried> = tried.into_iter().flatten().collect();
    tried.sort_by_key(|tried| tried.step);
    Ok(tried)
}

/// Up to `count` checkpoints, spread evenly over the steps of a log up to `last`.
fn spread(log: &Log, last: u64, count: u64) -> Result<Vec<LastCheckpoint>, BisectError> {
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
    request: &Request,
    range: &Range<usize>,
    (end, outcome): (f64, bool),
    context: &Context<'_>,
) -> Result<Vec<Tried>, Box<dyn Error + Send + Sync>> {
    let scene = &scene_of(log)?;
    let motion = ground_motion_of(log);
    let graph = Assembly::with(scene, context.making(NonZeroUsize::MIN)).graph()?;
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
        for branch in 0..u64::from(request.branches) {
            let mut random = fastrand::Rng::with_seed(seed_of(request.seed, checkpoint.step, branch));
            let change = |peak: f64| request.amount * peak * (2.0 * random.f64() - 1.0);
            for signal in ground_signals(&motion.moved_after(checkpoint.time, change)) {
                simulation.scheme.replace_signal(signal);
            }
            simulation.graph.deserialise(&units)?;
            let mut course = simulation.course();
            simulation.branch(&mut course, &state)?;
            let mut last = Last { range: range.clone(), ..Last::default() };
            let mut until = Until::new(Some(end));
            let observers: &mut [&mut dyn Observer] = &mut [&mut last, &mut until];
            let (ending, _) = simulation.conclude(&mut course, Ok(()), observers, &AtomicBool::new(false));
            match ending.status {
                Status::Failed(_) => failed += 1,
                _ => alike += usize::from(request.when.holds(last.magnitude) == outcome),
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

/// The 95 % confidence interval of a share with `hits` of `all`.
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
