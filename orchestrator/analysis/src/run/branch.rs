//! Leaving a run at one of its steps.

use super::job::Beginning;
use super::place::Fork;
use super::resume::of_log;
use super::{Folder, Options, PreparedRun, RunError, check_transport};
use crate::context::Context;
use crate::provenance::other_build;
use cofferdam_assembly::log::scene_of;
use cofferdam_log::{Comparison, Head, Log, LogReadError, compare as compare_logs};
use cofferdam_scene::Scene;
use std::path::{Path, PathBuf};

/// A requested branch.
#[derive(Clone, Debug)]
pub struct Request {
    /// The log of a run, or the run's folder.
    pub run: PathBuf,
    /// First step that is computed with other settings; within a window of several steps, the first of the window.
    pub step: u64,
    /// Values of the scene that are changed from there on, `key=value`.
    pub settings: Vec<String>,
    /// Folder for the results; by default `runs/RUN-branch-N`.
    pub output: Option<PathBuf>,
    /// Common settings.
    pub options: Options,
}

/// Checks whether a run can be left at a step.
///
/// **Errors**: [`RunError::NoWayOn`]; a log that cannot be read; settings that are wrong.
pub fn prepare(request: &Request, context: &Context<'_>) -> Result<PreparedRun, RunError> {
    let log = Log::of_exchanges(&request.run)?;
    let path = log.path().to_owned();
    if let Some(why) = other_build(log.head()) {
        context.warning(format!(
            "warning: {why}: the steps before step {} may not repeat bit for bit",
            request.step
        ));
    }
    let loaded = of_log(&log, &request.settings, path.parent().unwrap_or(Path::new("")))?;
    check_transport(request.options.transport)?;
    let step = log.first_of_window(request.step);
    if let Some(why) = no_way(log.head(), [&scene_of(&log)?, &loaded.scene], step) {
        return Err(RunError::NoWayOn { log: path, why });
    }
    let folder = match &request.output {
        Some(folder) => Folder::Given(folder.clone()),
        None => Folder::New(format!("runs/{}-branch-{}", loaded.name, request.step)),
    };
    let fork = Fork {
        checkpoint: log.checkpoint(step.saturating_sub(1))?,
        log,
        step,
        settings: request.settings.clone(),
    };
    Ok(PreparedRun {
        loaded,
        options: request.options,
        band: None,
        accuracy: None,
        folder,
        started: jiff::Timestamp::now().to_string(),
        settings: request.settings.clone(),
        beginning: Beginning::Branch(fork),
    })
}

/// Reason why a run cannot be left before `step` for `scene`.
fn no_way(head: &Head, [before, scene]: [&Scene; 2], step: u64) -> Option<String> {
    if before.ground_motion != scene.ground_motion {
        return Some(
            "the ground motion of a branch is that of the run; to change it, run the scene".to_owned(),
        );
    }
    if before.coupling.window != scene.coupling.window {
        return Some(format!(
            "a branch keeps the windows of its run (`coupling.window` = {}); to change them, run the scene",
            before.coupling.window
        ));
    }
    let parent = head.parent.as_ref().filter(|parent| step <= parent.step)?;
    Some(format!(
        "up to step {} this is the run {}; branch from that run, or from step {} onwards",
        parent.step,
        parent.log,
        parent.step + 1
    ))
}

/// Difference of the branch in `folder` from its parent run, whose log is `parent`.
///
/// **Errors**: the branch has no log that can be read.
pub fn compare(parent: &Log, folder: &Path) -> Result<Comparison, LogReadError> {
    Log::open(folder).and_then(|branch| compare_logs([parent, &branch]))
}
