//! `cofferdam replay`.

use super::{BuiltIn, DIFFERENT, complain, parallel, say};
use crate::registry::{self, RegistryError};
use indicatif::{ProgressBar, ProgressStyle};
use miette::Diagnostic;
use orchestrator::log::{Log, LogReadError};
use orchestrator::participant::Occasion;
use orchestrator::replay::{Replay, ReplayError, Unanswered, replay};
use orchestrator::scene::{Scene, SceneError};
use orchestrator::scheme::UnitId;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam replay`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    pub log: PathBuf,

    /// Replay this unit only; by default all, side by side
    #[arg(short, long)]
    pub unit: Option<BuiltIn>,

    /// Change a value of the scene that the units are made from; may be given several times
    ///
    /// Such as dam.cracks.0.friction_coefficient=0.8, to find where answers begin to differ
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Threads for preparing the reservoir's operator; by default one per core
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// No progress line
    #[arg(short, long)]
    pub quiet: bool,
}

pub const HELP: &str = "\
The units are made again from the scene in the log. Every recorded request is repeated, with states
saved and restored as in the run, and every answer is compared bit for bit. The record of the ground
motion is not needed. A log that is cut short is replayed up to the cut, a damaged one up to the damage.

Examples:
  cofferdam replay runs/koyna-northridge-1994-20260101T120000Z
      Does this build on this machine give the same answers?
  cofferdam replay run/log.mcap --unit dam --set dam.cracks.0.friction_coefficient=0.8
      Where does the answer of a dam with other friction first differ?

Exit status: 0 every answer is identical, 1 the log cannot be read to its end or holds nothing to
compare, 2 a --set is wrong, 4 a unit failed where the recorded one did not, 5 an answer is different.";

/// Why a replay has no result.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    Log(#[from] LogReadError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Logged(SceneError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Set(SceneError),
    #[error(transparent)]
    Unit(#[from] RegistryError),
    #[error(transparent)]
    Replay(Box<ReplayError>),
}

impl Failure {
    fn exit_status(&self) -> u8 {
        match self {
            Self::Log(_) | Self::Logged(_) => 1,
            Self::Replay(cause) if matches!(**cause, ReplayError::Log { .. }) => 1,
            Self::Set(_) => 2,
            Self::Unit(_) | Self::Replay(_) => 4,
        }
    }
}

/// Replays a log; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    match execute(arguments) {
        Ok(status) => ExitCode::from(status),
        Err(failure) => ExitCode::from(told(failure)),
    }
}

/// Prints the failure; returns the exit status.
fn told(failure: Failure) -> u8 {
    let status = failure.exit_status();
    complain(format!("{:?}", miette::Report::new(failure)));
    status
}

/// Replays and prints the result of every unit; returns the exit status.
fn execute(arguments: &Arguments) -> Result<u8, Failure> {
    let log = Log::open(&arguments.log)?;
    let head = log.head();
    let (path, overrides) = (log.path().display(), &arguments.set);
    let (shown, wrong): (_, fn(_) -> _) = match &**overrides {
        [] => (format!("{path}, its scene"), Failure::Logged),
        _ => (format!("{path} with {}", overrides.join(", ")), Failure::Set),
    };
    let scene = Scene::resolved(&head.scene_text, overrides, shown.as_ref()).map_err(wrong)?;
    let units: Vec<UnitId> = match arguments.unit {
        None => (0..head.units.len()).map(UnitId).collect(),
        Some(unit) => vec![unit.into()],
    };
    let threads = super::threads(arguments.threads);
    say(format!("{} (recorded by cofferdam {}, commit {})", head.scene.title, head.version, head.commit));
    let bar = progress(arguments.quiet, head.scene.steps().saturating_mul(units.len() as u64));
    let all = NonZeroUsize::new(units.len()).unwrap_or(NonZeroUsize::MIN);
    let results = parallel::map(&units, all, |&id| replay_unit(&log, id, &scene, threads, &bar));
    bar.finish_and_clear();
    let (mut failure, mut different, mut nothing) = (None, false, false);
    for (id, result) in units.into_iter().zip(results) {
        let unit = head.units.get(id.0).map_or_else(String::new, |unit| unit.name.clone());
        match result {
            Ok(replay) => {
                different |= replay.divergence.is_some();
                nothing |= replay.divergence.is_none() && replay.identical == 0;
                say(report(&unit, &replay));
            }
            Err(error) => {
                if let Failure::Replay(cause) = &error
                    && let ReplayError::Log { identical, .. } = **cause
                {
                    say(format!("{unit}: {identical} identical exchanges before the damage"));
                }
                let status = told(error);
                failure = failure.or(Some(status));
            }
        }
    }
    Ok(match failure {
        Some(status) => status,
        None if different => DIFFERENT,
        None => u8::from(nothing),
    })
}

fn replay_unit(
    log: &Log,
    id: UnitId,
    scene: &Scene,
    threads: NonZeroUsize,
    bar: &ProgressBar,
) -> Result<Replay, Failure> {
    let mut unit = registry::unit(id, scene, threads)?;
    let fingerprint = unit.description().fingerprint.to_string();
    if let Some(recorded) = log.head().units.get(id.0)
        && fingerprint != recorded.fingerprint
    {
        bar.suspend(|| {
            complain(format_args!(
                "warning: {}: made from other parameters, or by a version that hashes them differently \
                 (fingerprint {:.12} now, {:.12} in the log)",
                recorded.name, fingerprint, recorded.fingerprint
            ));
        });
    }
    let seen = |at: &Occasion| bar.inc(u64::from(at.iteration == 1));
    replay(log, id, &mut *unit, seen).map_err(|cause| Failure::Replay(Box::new(cause)))
}

fn progress(quiet: bool, steps: u64) -> ProgressBar {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(steps) };
    if let Ok(style) = ProgressStyle::with_template("{bar:10} {percent:>3} %  replay  {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn report(unit: &str, replay: &Replay) -> String {
    let mut lines = vec![match &replay.divergence {
        Some(divergence) => divergence.report(["recorded", "replayed"]).to_string(),
        None if replay.identical == 0 => format!("{unit}: nothing to compare"),
        None => format!("{unit}: identical: {} exchanges", replay.identical),
    }];
    if let Some(Unanswered { occasion, failure }) = &replay.unanswered {
        lines.push(match failure {
            Some(cause) => format!("  the next request, {occasion}, failed in the run and fails again: {cause}"),
            None => format!(
                "  the next request, {occasion}, failed in the run, but not in the replay: look for the cause \
                 outside the computation of the unit"
            ),
        });
    }
    match &replay.ending {
        Some(Err(position)) => lines.push(format!("  up to byte {position}, where the log is cut short")),
        Some(Ok(status)) if status != "completed" => lines.push(format!("  the run ended early: {status}")),
        _ => {}
    }
    lines.join("\n")
}
