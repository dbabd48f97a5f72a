//! Resuming a run.

use super::job::Beginning;
use super::{Folder, Options, PreparedRun, RunError, check_transport};
use crate::context::Context;
use crate::provenance::other_build;
use cofferdam_assembly::log::ground_motion_of;
use cofferdam_log::{Extent, Log, LogWriter};
use cofferdam_scene::{LoadedScene, SceneError};
use std::path::Path;

/// Result of the check for resuming.
pub enum Resumption {
    /// Nothing, for this reason: the run came to its end.
    Nothing(String),
    /// The rest of the run.
    Rest(Box<PreparedRun>),
}

/// Checks whether the run in `folder` can continue after the last checkpoint in its log. `any_build` permits a program or
/// processor other than that of the run.
///
/// **Errors**: [`RunError::NoWayOn`]; a log that cannot be read.
pub fn prepare(
    folder: &Path,
    any_build: bool,
    options: &Options,
    context: &Context<'_>,
) -> Result<Resumption, RunError> {
    let log = Log::open(folder)?;
    let no_way = |why: String| Err(RunError::NoWayOn { log: log.path().to_owned(), why });
    if !folder.is_dir() {
        return no_way("give the folder of the run, to which its results are written".to_owned());
    }
    if LogWriter::is_busy(log.path()) {
        return no_way("the run is still running or being resumed; wait for its end, or stop it".to_owned());
    }
    let Extent { checkpoint, status, damage } = log.extent()?;
    if let Some(status) = status
        && (status == "completed" || status.starts_with("stopped") && !status.contains("--until"))
    {
        return Ok(Resumption::Nothing(format!("nothing to do: the run {status}")));
    }
    if let Some(why) = other_build(log.head()) {
        if !any_build {
            return no_way(format!(
                "{why}, so the rest would not belong to the same run; use the build and machine of the run, or --other-build"
            ));
        }
        context.warning(format!("warning: {why}"));
    }
    check_transport(options.transport)?;
    let loaded = of_log(&log, &[], folder)?;
    // In a branch, earlier checkpoints are those of its parent.
    let own = |step: u64| log.head().parent.as_ref().is_none_or(|parent| step >= parent.step);
    if log.head().parent.is_some() && checkpoint.as_ref().is_none_or(|checkpoint| !own(checkpoint.step)) {
        return no_way("this branch ended before it began; branch again".to_owned());
    }
    if let Some(damage) = damage {
        context.warning(format!("warning: {damage}"));
        context.line("the log up to there is kept, the rest is computed again");
    }
    Ok(Resumption::Rest(Box::new(PreparedRun {
        loaded,
        options: *options,
        band: None,
        accuracy: None,
        folder: Folder::Own(folder.to_owned()),
        started: log.head().started.clone(),
        settings: Vec::new(),
        beginning: Beginning::Resumed(log, checkpoint),
    })))
}

/// The scene of a log with `settings`, as it was loaded; the run is in `folder`.
pub fn of_log(log: &Log, settings: &[String], folder: &Path) -> Result<LoadedScene, SceneError> {
    let head = log.head();
    let manifest = std::fs::read_to_string(folder.join("manifest.toml")).unwrap_or_default();
    let manifest: Option<toml::Table> = manifest.parse().ok();
    let name = manifest.and_then(|table| Some(table.get("name")?.as_str()?.to_owned()));
    let of_folder =
        || folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let name = name.unwrap_or_else(of_folder);
    LoadedScene::of_log(name, &head.scene_text, settings, log.path(), ground_motion_of(log))
}
