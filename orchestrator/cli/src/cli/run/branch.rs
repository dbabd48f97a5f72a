//! `cofferdam branch`.

use super::job::{Beginning, Job};
use super::place::Fork;
use super::resume::of_log;
use super::{RunError, folder, prepared, told};
use crate::cli::{Options, complain, other_build, say};
use cofferdam_assembly::log::scene_of;
use cofferdam_coupling::observer::Status;
use cofferdam_log::{Head, Log, compare};
use cofferdam_scene::Scene;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `cofferdam branch`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    pub run: PathBuf,

    /// First step that is computed otherwise; all before is that of the run
    ///
    /// Inside a window of several steps, the window's first.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub step: u64,

    /// Set a value otherwise from there on; may be given several times
    ///
    /// Such as coupling.acceleration=iqn-ils or dam.cracks.0.friction_coefficient=0.8.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for the results; by default runs/RUN-branch-N
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
The branch begins with the windows of the run before step N, taken from its log, and goes on from the
state there with what is set otherwise. It is a run of its own, with a log, histories and a report, which
name the run that it left; at the end both are compared.

A unit that is made from the same as before goes on from its state, also a dam of which only friction,
cohesion or tensile strength of cracks are another. Any other unit takes the place of the run's after it
was asked what that one was asked until then; it must exchange the same variables at the same points.
The acceleration keeps what it learnt unless it is set otherwise.

Examples:
  cofferdam branch runs/koyna --step 2846 --set coupling.acceleration=iqn-ils
      Does that step converge with another acceleration?
  cofferdam branch runs/koyna --step 1200 --set dam.cracks.0.friction_coefficient=0.8
      What if the crack were weaker from there on?
  cofferdam branch runs/koyna --step 1200
      Nothing changed: the same run again, bit for bit.

Exit status: as of `run`; 2 there is no way to branch there.";

/// Leaves a run; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    arguments.options.begin();
    told(execute(arguments))
}

fn execute(arguments: &Arguments) -> Result<Status, RunError> {
    let log = Log::of_exchanges(&arguments.run)?;
    let path = log.path().to_owned();
    if let Some(why) = other_build(log.head()) {
        complain(format!(
            "warning: {why}: the steps before step {} may not repeat bit for bit",
            arguments.step
        ));
    }
    let loaded = of_log(&log, &arguments.set, path.parent().unwrap_or(Path::new("")))?;
    let interrupted = prepared(arguments.options.transport)?;
    let step = log.first_of_window(arguments.step);
    if let Some(why) = no_way(log.head(), [&scene_of(&log)?, &loaded.scene], step) {
        return Err(RunError::NoWayOn { log: path, why });
    }
    let folder = match &arguments.output {
        Some(folder) => folder::claim(folder.clone())?,
        None => folder::claim_new(&format!("runs/{}-branch-{}", loaded.name, arguments.step))?,
    };
    let fork = Fork {
        checkpoint: log.checkpoint(step.saturating_sub(1))?,
        log: log.clone(),
        step,
        settings: arguments.set.clone(),
    };
    let job = Job {
        loaded: &loaded,
        options: &arguments.options,
        band: None,
        accuracy: None,
        folder: &folder,
        started: jiff::Timestamp::now().to_string(),
        settings: &arguments.set,
        interrupted: &interrupted,
    };
    let ended = job.carry_out(Beginning::Branch(fork));
    if !matches!(ended, Err(RunError::NoWayOn { .. } | RunError::NotThere { .. })) {
        compared(&log, &folder);
    }
    ended
}

/// Why a run cannot be left before `step` for `scene`.
fn no_way(head: &Head, [before, scene]: [&Scene; 2], step: u64) -> Option<String> {
    if before.ground_motion != scene.ground_motion {
        return Some("the ground moves as in the run; to move it otherwise, run the scene".to_owned());
    }
    if before.coupling.window != scene.coupling.window {
        return Some(format!(
            "a branch keeps the windows of its run (`coupling.window` = {}), by which its log is read; for others, run the scene",
            before.coupling.window
        ));
    }
    let parent = head.parent.as_ref().filter(|parent| step <= parent.step)?;
    Some(format!(
        "up to step {} it is the run {}; branch from that run, or from step {} on",
        parent.step,
        parent.log,
        parent.step + 1
    ))
}

/// Says how far a branch is from the run that it left.
fn compared(log: &Log, folder: &Path) {
    let comparison = Log::open(folder).and_then(|branch| compare([log, &branch]));
    match comparison {
        Ok(comparison) => say(format!("against the run: {}", crate::cli::log::diff::verdict(&comparison))),
        Err(error) => complain(error),
    }
}
