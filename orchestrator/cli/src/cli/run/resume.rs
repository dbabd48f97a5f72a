//! `cofferdam resume`.

use super::answer::NoAnswer;
use super::job::{Beginning, Job};
use super::{RunError, prepared, told};
use crate::cli::output::answer;
use crate::cli::{Options, complain, other_build, say};
use cofferdam_assembly::log::ground_motion_of;
use cofferdam_coupling::observer::Status;
use cofferdam_log::{Extent, Log, LogWriter};
use cofferdam_scene::{LoadedScene, SceneError};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `cofferdam resume`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The run's folder
    pub run: PathBuf,

    /// Go on though the program or the processor is another than that of the run
    ///
    /// The results are then those of two programs, and not bit for bit those of an uninterrupted run.
    #[arg(long)]
    pub other_build: bool,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
The run goes on after the last checkpoint in its log, in its own folder, and ends like one that was not
interrupted: log, histories and summary are the same, bit for bit, but for wall times. It does not matter
how it was interrupted: Ctrl-C, --until, a killed process, a full disk, a crash. What the log holds after
the checkpoint is computed again. The log is replaced once the new one holds all that came before the
checkpoint; until then the old one is left alone.

Units that give no state are asked again what the run asked them, up to the checkpoint.

Examples:
  cofferdam run scenes/koyna-northridge-1994 --until 5 --output runs/koyna
      The first five seconds.
  cofferdam resume runs/koyna
      The rest.

Exit status: as of `run`; 2 the run cannot be continued.";

/// Goes on with a run; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    arguments.options.begin();
    told(execute(arguments))
}

fn execute(arguments: &Arguments) -> Result<Status, RunError> {
    let log = Log::open(&arguments.run)?;
    let no_way = |why: String| Err(RunError::NoWayOn { log: log.path().to_owned(), why });
    if !arguments.run.is_dir() {
        return no_way("give the folder of the run, which its results go to".to_owned());
    }
    if LogWriter::is_busy(log.path()) {
        return no_way("its run is going on, or being resumed; wait for its end, or end it".to_owned());
    }
    let Extent { checkpoint, status, damage } = log.extent()?;
    if let Some(status) = status
        && (status == "completed" || status.starts_with("stopped") && !status.contains("--until"))
    {
        let said = format!("nothing to do: the run {status}");
        answer(&NoAnswer { status: said.clone(), exit_status: 0 });
        say(said);
        return Ok(Status::Completed);
    }
    if let Some(why) = other_build(log.head()) {
        if !arguments.other_build {
            return no_way(format!(
                "{why}, so that the rest would not be that of one run; take the build and machine of the run, or --other-build"
            ));
        }
        complain(format!("warning: {why}"));
    }
    let interrupted = prepared(arguments.options.transport)?;
    let loaded = of_log(&log, &[], &arguments.run)?;
    // In a branch, earlier checkpoints are those of its parent.
    let own = |step: u64| log.head().parent.as_ref().is_none_or(|parent| step >= parent.step);
    if log.head().parent.is_some() && checkpoint.as_ref().is_none_or(|checkpoint| !own(checkpoint.step)) {
        return no_way("this branch ended before it began; branch again".to_owned());
    }
    if let Some(damage) = damage {
        complain(format!("warning: {damage}"));
        say("what the log holds before is kept, the rest is computed again");
    }
    let job = Job {
        loaded: &loaded,
        options: &arguments.options,
        band: None,
        accuracy: None,
        folder: &arguments.run,
        started: log.head().started.clone(),
        settings: &[],
        interrupted: &interrupted,
    };
    job.carry_out(Beginning::Resumed(log, checkpoint))
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
