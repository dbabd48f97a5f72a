//! Runs, resumed runs and branches: what `cofferdam run`, `resume` and `branch` do.
//!
//! Each begins with a function that checks the request and returns a [`PreparedRun`]: [`prepare`], [`resume::prepare`],
//! [`branch::prepare`]. [`PreparedRun::carry_out`] then claims the folder, computes, and writes all results.

use cofferdam_assembly::{AssemblyError, read_scene};
mod background;
mod band;
pub mod branch;
mod folder;
mod job;
mod model;
mod place;
pub mod resume;

pub(crate) use band::NOISE;

use crate::accuracy::{self, AccuracyError, Asked, Promise};
use crate::context::{Context, threads};
use crate::plan::{self, PlanError};
use crate::start::{StartError, Transport};
use cofferdam_coupling::observer::{Observer, Status, WallTime};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::run_state::RunStateError;
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_log::{Log, LogError, LogReadError};
use cofferdam_report::page::PageError;
use cofferdam_report::{ManifestError, Summary};
use cofferdam_scene::{LoadedScene, SceneError};
use cofferdam_shared_memory::Starting;
use job::{Beginning, Job};
use miette::Diagnostic;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Reason why a run ended without a result, or with a partial result.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum RunError {
    /// The scene.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The output folder.
    #[error("{}: {cause}; choose another --output", path.display())]
    Output {
        /// The folder.
        path: PathBuf,
        /// The cause.
        cause: std::io::Error,
    },
    /// A folder with something in it.
    #[error("{} is not empty; choose another --output, nothing is overwritten", path.display())]
    OutputTaken {
        /// The folder.
        path: PathBuf,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A log cannot be read.
    #[error(transparent)]
    LogRead(#[from] LogReadError),
    /// The manifest.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A unit.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A unit that fails while it is prepared.
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    /// A run that fails.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Units cannot be started.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The response spectra.
    #[error("the response spectra: {0}; free some space or choose another --output")]
    Spectra(Box<dyn std::error::Error + Send + Sync>),
    /// The page.
    #[error("the report: {0}")]
    Report(#[from] PageError),
    /// The choice of the numerics.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Accuracy(#[from] AccuracyError),
    /// The plan of the scene.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(#[from] PlanError),
    /// A run cannot be continued or left there.
    #[error("{}: {why}", log.display())]
    NoWayOn {
        /// The log.
        log: PathBuf,
        /// Reason and remedy.
        why: String,
    },
    /// A unit does not come to where it was.
    #[error("{unit} cannot be put where it was at the end of step {step}: {why}")]
    NotThere {
        /// The unit.
        unit: String,
        /// The step.
        step: u64,
        /// Why.
        why: String,
    },
}

impl From<RunStateError> for RunError {
    fn from(cause: RunStateError) -> Self {
        Self::Simulation(cause.into())
    }
}

/// Common settings of runs, resumed runs and branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Time at which the run ends, s; `None` for that of the scene. Earlier results are unaffected.
    pub until: Option<f64>,
    /// For preparing the reservoir's operator, and for large meshes of the dam. Results are equal, bit for bit, for any number.
    pub threads: NonZeroUsize,
    /// Transport of the units.
    pub transport: Transport,
    /// Longest time that a unit's process may take for a step, s.
    pub deadline: f64,
    /// Whether `report.html` is written.
    pub report: bool,
}

impl Default for Options {
    /// In this process, on all cores, with a report.
    fn default() -> Self {
        let threads = threads(None);
        Self { until: None, threads, transport: Transport::InProcess, deadline: 60.0, report: true }
    }
}

/// A requested run.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Folder that holds scene.toml, or a .toml file.
    pub scene: PathBuf,
    /// Values of the scene that are changed, `key=value`.
    pub settings: Vec<String>,
    /// Folder for the results; by default `runs/SCENE-TIME`.
    pub output: Option<PathBuf>,
    /// Number of replicates for a band.
    pub band: Option<u16>,
    /// The accuracy by which the numerics are chosen; by default that of the scene, if it has one.
    pub accuracy: Option<Asked>,
    /// Common settings.
    pub options: Options,
}

/// Where results go.
enum Folder {
    /// Into this folder, which must be new or empty.
    Given(PathBuf),
    /// Into a new one of this name, or of this name with a number.
    New(String),
    /// Into that of the run that is resumed.
    Own(PathBuf),
}

/// A run that was checked, before it takes its folder.
pub struct PreparedRun {
    loaded: LoadedScene,
    options: Options,
    band: Option<u16>,
    accuracy: Option<Promise>,
    folder: Folder,
    started: String,
    settings: Vec<String>,
    beginning: Beginning,
}

/// Result of a run that reached its first step; its files are written.
#[derive(Debug)]
pub struct RunOutcome {
    /// Status at the end of the computation.
    pub status: Status,
    /// Where the results are.
    pub folder: PathBuf,
    /// The numbers.
    pub summary: Summary,
    /// Damping and fidelity of the dam, each with its name.
    pub model: Vec<(&'static str, String)>,
    /// Where the time went.
    pub wall: WallTime,
    /// The log of the run that a branch left, for [`branch::compare`].
    pub parent: Option<Log>,
    /// Whether `report.html` was written.
    pub has_report: bool,
    /// Reason why it was not, in addition to a [`failure`](Self::failure).
    pub page_failure: Option<PageError>,
    /// Reason why the run failed, or which of its results could not be written.
    pub failure: Option<RunError>,
}

/// Reads and checks the scene of a run; with an accuracy, chooses its numerics by a pilot.
///
/// **Errors**: [`RunError`].
pub fn prepare(request: &Request, context: &Context<'_>) -> Result<PreparedRun, RunError> {
    let Request { scene, settings, output, band, options, .. } = request;
    let mut settings = settings.clone();
    let mut loaded = read_scene(scene, &settings)?;
    let started = jiff::Timestamp::now();
    check_transport(options.transport)?;
    if let Some(folder) = output {
        folder::check(folder)?;
    }
    let mut promise = None;
    let asked = request.accuracy.clone().or(loaded.scene.accuracy.map(Into::into));
    if let Some(asked) = &asked {
        let mut promised = accuracy::promise(scene, &settings, &loaded, asked, context)?;
        promised.plan = plan::rows(&loaded, context)?;
        promised.plan.iter().for_each(|row| context.line(plan::text(row)));
        accuracy::announce(&promised, context);
        settings.extend(promised.record.chosen.iter().cloned());
        loaded = read_scene(scene, &settings)?;
        // A run of the manifest is this run again, not another choice.
        loaded.scene.accuracy = None;
        promise = Some(promised);
    }
    let folder = match output {
        Some(folder) => Folder::Given(folder.clone()),
        None => Folder::New(format!("runs/{}-{}", loaded.name, started.strftime("%Y%m%dT%H%M%SZ"))),
    };
    Ok(PreparedRun {
        loaded,
        options: *options,
        band: *band,
        accuracy: promise,
        folder,
        started: started.to_string(),
        settings,
        beginning: Beginning::Initialisation,
    })
}

impl PreparedRun {
    /// The promised accuracy, if one was requested.
    pub fn promise(&self) -> Option<&Promise> {
        self.accuracy.as_ref()
    }

    /// Takes the folder, runs to the end or until `interrupted`, with `observers` in addition to those that write the results, and writes all
    /// results.
    ///
    /// **Errors**: [`RunError`] before the first step. A later failure comes with the outcome.
    pub fn carry_out(
        self,
        context: &Context<'_>,
        interrupted: &AtomicBool,
        observers: &mut [&mut dyn Observer],
    ) -> Result<RunOutcome, RunError> {
        let Self { loaded, options, band, accuracy, folder, started, settings, beginning } = self;
        let folder = match folder {
            Folder::Given(folder) => folder::claim(folder)?,
            Folder::New(name) => folder::claim_new(&name)?,
            Folder::Own(folder) => folder,
        };
        if let Beginning::Initialisation = beginning {
            context.reporter.scene_warnings(&loaded.warnings);
        }
        let job = Job {
            loaded: &loaded,
            options: &options,
            band,
            accuracy: accuracy.as_ref(),
            folder: &folder,
            started,
            settings: &settings,
            interrupted,
            context,
        };
        job.carry_out(beginning, observers)
    }
}

/// Checks whether units can be connected.
fn check_transport(transport: Transport) -> Result<(), RunError> {
    if transport == Transport::SharedMemory { Ok(Starting::check()?) } else { Ok(()) }
}
