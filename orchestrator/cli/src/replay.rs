//! `cofferdam replay`.

use crate::context::context;
use crate::options::{BuiltIn, Transport};
use crate::terminal::{DIFFERENT, print, warn};
use cofferdam_analysis::context::threads;
use cofferdam_analysis::parallel;
use cofferdam_analysis::provenance::other_build;
use cofferdam_analysis::start::{Start, StartError, deadlines};
use cofferdam_assembly::log::scene_of;
use cofferdam_assembly::{Assembly, AssemblyError, units::unit_name};
use cofferdam_coupling::participant::{Occasion, Participant};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_log::replay::{Part, Replay, ReplayError, ReplayedPart, Unanswered, replay_part};
use cofferdam_log::{Head, Log, LogReadError};
use cofferdam_scene::{Scene, SceneError};
use indicatif::{ProgressBar, ProgressStyle};
use miette::Diagnostic;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Arguments of `cofferdam replay`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    pub log: PathBuf,

    /// Replay this unit only (default: all units, in parallel)
    #[arg(short, long)]
    pub unit: Option<BuiltIn>,

    /// First step to replay (default: 0, initialisation; in a branch, its first own step)
    ///
    /// The unit is restored to the end of the previous step. Windows of several steps (coupling.window) are
    /// replayed as a whole.
    #[arg(long, value_name = "STEP", value_parser = step_number)]
    pub from: Option<u64>,

    /// Last step to replay (default: the last step of the log)
    #[arg(long, value_name = "STEP", value_parser = step_number)]
    pub until: Option<u64>,

    /// Replay this step only; short for --from STEP --until STEP
    #[arg(long, value_name = "STEP", conflicts_with_all = ["from", "until"])]
    pub step: Option<u64>,

    /// Change a value of the scene from which the units are created (repeatable)
    ///
    /// For example dam.cracks.0.friction_coefficient=0.8, to find where the responses begin to differ. A
    /// key that affects none of the replayed units is refused.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Threads for preparing the water operator (default: one per core)
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// Where the built-in units run; units started by a command always run in their own process
    #[arg(long, value_enum, default_value_t = Transport::InProcess)]
    pub transport: Transport,

    /// Maximum wall time per step of a unit in its own process, s
    ///
    /// The limit for preparation and initialisation is 60 times as long.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = crate::options::seconds)]
    pub deadline: f64,

    /// Do not show the progress line
    #[arg(short, long)]
    pub quiet: bool,
}

/// The number of a step.
fn step_number(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| {
        "expected a step number, not a time; `cofferdam log info` shows the number of steps".into()
    })
}

pub const HELP: &str = "\
Creates the units again from the scene in the log, repeats every logged
request, with states saved and restored as in the run, and compares every
response bit for bit. The ground motion file is not needed. A truncated log is
replayed up to where it is cut short, a damaged one up to the damage.

Examples:
  cofferdam replay runs/koyna-northridge-1994-20260101T120000Z
      Does this build give the same responses on this machine?
  cofferdam replay run/log.mcap --unit dam \\
    --set dam.cracks.0.friction_coefficient=0.8
      Where does the response of a dam with different friction first differ?
  cofferdam replay run --unit dam --step 2040
      All iterations of one step, such as one listed by `cofferdam log worst`.

Exit status: 0 all responses are identical, 1 the log cannot be read to its end
or contains nothing to compare, 2 a --set or a step is invalid, 4 a unit failed
where the logged one did not, 5 a response differs.";

/// Reason why a replay has no result.
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
    #[error("--set {set}: no replayed unit ({units}) depends on `{key}`, so it has no effect; {remedy}")]
    Unread { set: String, key: String, units: String, remedy: String },
    #[error("--from {from} is after --until {until}; exchange them")]
    Backwards { from: u64, until: u64 },
    #[error("the log has no unit called {name}; choose one of {found}")]
    NoUnit { name: &'static str, found: String },
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    #[error(transparent)]
    Start(#[from] StartError),
    #[error("the scene cannot be written for the processes of units: {0}")]
    Scene(#[from] toml::ser::Error),
    #[error(transparent)]
    Replay(Box<ReplayError>),
}

impl Failure {
    fn exit_status(&self) -> u8 {
        match self {
            Self::Log(_) | Self::Logged(_) | Self::Scene(_) | Self::Start(StartError::Program(_)) => 1,
            Self::Replay(cause)
                if matches!(**cause, ReplayError::Log { .. } | ReplayError::Thread { .. }) =>
            {
                1
            }
            Self::Replay(cause) if matches!(**cause, ReplayError::Beyond { .. }) => 2,
            Self::Set(_) | Self::Unread { .. } | Self::Backwards { .. } | Self::NoUnit { .. } => 2,
            Self::Unit(_) | Self::Start(_) | Self::Replay(_) => 4,
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
    warn(format!("{:?}", miette::Report::new(failure)));
    status
}

/// Replays and prints the result of every unit; returns the exit status.
fn execute(arguments: &Arguments) -> Result<u8, Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    let head = log.head();
    let part = part(arguments, head)?;
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
    if let Some(missing) = units.iter().find(|id| id.0 >= head.units.len()) {
        let found = head.units.iter().map(|unit| unit.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(Failure::NoUnit { name: unit_name(*missing), found });
    }
    every_set_is_read(&log, overrides, &scene, &units)?;
    let of_log = scene_of(&log)?;
    print(format!("{} (recorded by cofferdam {}, commit {})", of_log.title, head.version, head.commit));
    if let Some(why) = other_build(head) {
        warn(format_args!("warning: {why}; results may not be bit-identical"));
    }
    if let Some(parent) = &head.parent {
        print(format!(
            "a branch of {} after step {}: earlier steps belong to that run",
            parent.log, parent.step
        ));
    }
    let steps = part.until.min(of_log.steps()).saturating_mul(units.len() as u64);
    let bar = progress(arguments.quiet, steps);
    let replaying = Replaying { arguments, log: &log, scene: &scene, part, bar: &bar };
    let all = NonZeroUsize::new(units.len()).unwrap_or(NonZeroUsize::MIN);
    let results = parallel::map(&units, all, |&id| replaying.unit(id));
    bar.finish_and_clear();
    let (mut failure, mut different, mut nothing) = (None, false, false);
    for (id, result) in units.into_iter().zip(results) {
        let unit = &head.units[id.0].name;
        match result {
            Ok((replay, times)) => {
                different |= replay.divergence.is_some();
                nothing |= replay.divergence.is_none() && replay.identical == 0;
                print(report(unit, &replay, times, arguments.until));
            }
            Err(error) => {
                if let Failure::Replay(cause) = &error
                    && let ReplayError::Log { identical, .. } = **cause
                {
                    print(format!("{unit}: {identical} identical exchanges before the damage"));
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

/// The requested part of the run.
fn part(arguments: &Arguments, head: &Head) -> Result<Part, Failure> {
    let until = arguments.step.or(arguments.until).unwrap_or(u64::MAX);
    let own = head.parent.as_ref().map(|parent| parent.step + 1).filter(|own| *own <= until);
    let from = arguments.step.or(arguments.from).or(own).unwrap_or(0);
    if from > until {
        return Err(Failure::Backwards { from, until });
    }
    Ok(Part { from, until, stands: None })
}

/// Refuses a `--set` that changes the scene, but none of the units that are replayed.
fn every_set_is_read(log: &Log, sets: &[String], scene: &Scene, units: &[UnitId]) -> Result<(), Failure> {
    let resolved = |sets: &[String]| Scene::resolved(&log.head().scene_text, sets, log.path()).ok();
    for (index, set) in sets.iter().enumerate() {
        let others: Vec<String> = sets
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index)
            .map(|(_, set)| set.clone())
            .collect();
        // A setting is judged together with the others if that is valid, otherwise alone.
        let with_others = resolved(&others).map(|without| (without, scene.clone()));
        let alone = || Some((resolved(&[])?, resolved(std::slice::from_ref(set))?));
        let Some((without, with)) = with_others.or_else(alone) else { continue };
        let reads = |id: UnitId| -> Result<bool, AssemblyError> {
            let gone =
                !Assembly::of(&without).units().contains(&id) || !Assembly::of(&with).units().contains(&id);
            Ok(gone || Assembly::of(&without).fingerprint(id)? != Assembly::of(&with).fingerprint(id)?)
        };
        if without == with
            || units.iter().map(|&id| reads(id)).collect::<Result<Vec<_>, _>>()?.contains(&true)
        {
            continue;
        }
        let mut readers = Vec::new();
        for id in Assembly::of(&with).units() {
            if !units.contains(&id) && reads(id)? {
                readers.push(unit_name(id));
            }
        }
        let remedy = match &readers[..] {
            [] => "the requests are those of the log: to continue from a step of the run with it, use `cofferdam branch`; for all of \
                   it, `cofferdam run`"
                .to_owned(),
            readers => format!("it is for {}: replay that with --unit", readers.join(" and ")),
        };
        let named = |ids: &[UnitId]| ids.iter().map(|&id| unit_name(id)).collect::<Vec<_>>().join(", ");
        let key = set.split('=').next().unwrap_or(set).trim().to_owned();
        return Err(Failure::Unread { set: set.clone(), key, units: named(units), remedy });
    }
    Ok(())
}

/// Common data of all units.
struct Replaying<'a> {
    arguments: &'a Arguments,
    log: &'a Log,
    scene: &'a Scene,
    part: Part,
    bar: &'a ProgressBar,
}

impl Replaying<'_> {
    /// Makes and replays a unit; with the times of both.
    fn unit(&self, id: UnitId) -> Result<(Replay, [Duration; 2]), Failure> {
        let Self { arguments, log, scene, part, bar } = *self;
        let began = Instant::now();
        let resolved = toml::to_string(scene)?;
        let start = Start {
            scene,
            resolved: &resolved,
            transport: arguments.transport.into(),
            threads: threads(arguments.threads),
            deadlines: deadlines(arguments.deadline),
            interrupted: &AtomicBool::new(false),
            announce: false,
            context: context(),
        };
        if !Assembly::of(scene).units().contains(&id) {
            return Err(AssemblyError::NoUnit { number: id.0 }.into());
        }
        let mut unit = start.units(&[id])?.remove(0);
        let made = began.elapsed();
        let fingerprint = unit.description().fingerprint.to_string();
        let recorded = &log.head().units[id.0];
        if fingerprint != recorded.fingerprint {
            bar.suspend(|| {
                warn(format_args!(
                    "warning: {}: made from other parameters, or by a version that hashes them differently \
                     (fingerprint {:.12} now, {:.12} in the log)",
                    recorded.name, fingerprint, recorded.fingerprint
                ));
            });
        }
        let seen = |at: &Occasion| bar.inc(u64::from(at.iteration == 1));
        let part = if fingerprint == recorded.fingerprint { self.near(id, &mut *unit)? } else { part };
        let replayed = replay_part(log, id, &mut *unit, &part, seen);
        let replay = replayed.map_err(|cause| Failure::Replay(Box::new(cause)))?;
        Ok((replay, [made, began.elapsed().saturating_sub(made)]))
    }
}

impl Replaying<'_> {
    /// Puts a unit to the last checkpoint before the part, if there is one.
    fn near(&self, id: UnitId, unit: &mut dyn Participant) -> Result<Part, Failure> {
        let Some(before) = self.log.first_of_window(self.part.from).checked_sub(1) else {
            return Ok(self.part);
        };
        let found = self.log.checkpoint(before)?;
        let state = found.and_then(|mut found| found.units.get_mut(id.0).and_then(Option::take));
        let Some((step, state)) = state else { return Ok(self.part) };
        // A state of another build is not read; the unit then goes all the way.
        if unit.deserialise(&state).is_err() {
            return Ok(self.part);
        }
        Ok(Part { stands: Some(step), ..self.part })
    }
}

fn progress(quiet: bool, steps: u64) -> ProgressBar {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(steps) };
    if let Ok(style) = ProgressStyle::with_template("{bar:10} {percent:>3} %  replay  {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn report(unit: &str, replay: &Replay, times: [Duration; 2], asked: Option<u64>) -> String {
    let [made, replayed] = times.map(|time| time.as_secs_f64());
    let mut lines = vec![match (&replay.divergence, &replay.part) {
        (Some(divergence), _) => divergence.report(["recorded", "replayed"]).to_string(),
        (None, _) if replay.identical == 0 => format!("{unit}: nothing to compare"),
        (None, part) => {
            let steps = |part: &ReplayedPart| match (part.from, part.until) {
                (step, last) if step == last => format!(" of step {step}"),
                (from, until) => format!(" of steps {from} to {until}"),
            };
            let steps = part.as_ref().map_or_else(String::new, steps);
            format!(
                "{unit}: identical: {} exchanges{steps} (made in {made:.2} s, replayed in {replayed:.2} s)",
                replay.identical
            )
        }
    }];
    if let Some(ReplayedPart { from, brought, .. }) = replay.part
        && from > 0
    {
        lines.push(match &replay.divergence {
            Some(divergence) if divergence.occasion.step < from => {
                format!("  on the way to step {from}, where the replay was to begin")
            }
            _ => format!("  put at the end of step {} by {brought} accepted exchanges", from - 1),
        });
    }
    if let Some(Unanswered { occasion, failure }) = &replay.unanswered {
        lines.push(match failure {
            Some(cause) => format!("  a request, {occasion}, failed in the run and fails again: {cause}"),
            None => format!(
                "  a request, {occasion}, failed in the run, but not in the replay: look for the cause \
                 outside the computation of the unit"
            ),
        });
    }
    let named =
        |names: &[String]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    for (names, lacks) in replay.uncompared.iter().zip(["the unit does", "the log does"]) {
        if !names.is_empty() {
            lines.push(format!("  not compared: {}, which {lacks} not have", named(names)));
        }
    }
    match &replay.ending {
        Some(Err(position)) => lines.push(format!("  up to byte {position}, where the log is cut short")),
        Some(Ok(status)) if status != "completed" => lines.push(format!("  the run ended early: {status}")),
        Some(Ok(_)) if asked.is_some() => lines.push("  up to the end of the run".to_owned()),
        _ => {}
    }
    lines.join("\n")
}
