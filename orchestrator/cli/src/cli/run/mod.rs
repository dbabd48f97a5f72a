//! `cofferdam run`, `resume` and `branch`.

mod answer;
mod band;
mod beside;
pub mod branch;
mod folder;
mod job;
mod place;
pub mod resume;

use super::accuracy::{self, AccuracyError};
use super::output::{answer, speak_to_programs};
use super::plan::{self, PlanError};
use super::start::StartError;
use super::{Options, Run, Transport, check, complain, report};
use answer::NoAnswer;
use cofferdam_assembly::{AssemblyError, read_scene};
use cofferdam_coupling::observer::{ObserverError, Status};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::run_state::RunStateError;
use cofferdam_coupling::scheme::CouplingError;
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_log::{LogError, LogReadError};
use cofferdam_report::ManifestError;
use cofferdam_scene::SceneError;
use cofferdam_shared_memory::Starting;
use job::{Beginning, Job};
use miette::Diagnostic;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why a run ended without a result, or with a partial one.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum RunError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error("{}: {cause}; choose another --output", path.display())]
    Output { path: PathBuf, cause: std::io::Error },
    #[error("{} is not empty; choose another --output, nothing is overwritten", path.display())]
    OutputTaken { path: PathBuf },
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    LogRead(#[from] LogReadError),
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error(transparent)]
    Start(#[from] StartError),
    #[error("the response spectra: {0}; free some space or choose another --output")]
    Spectra(Box<dyn std::error::Error + Send + Sync>),
    #[error("the report: {0}")]
    Report(#[from] report::Failure),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Accuracy(#[from] AccuracyError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(#[from] PlanError),
    #[error("Ctrl-C cannot be caught: {0}; it takes a thread: allow more (`ulimit -u`)")]
    Signal(#[from] ctrlc::Error),
    #[error("{}: {why}", log.display())]
    NoWayOn { log: PathBuf, why: String },
    #[error("{unit} cannot be put where it was at the end of step {step}: {why}")]
    NotThere { unit: String, step: u64, why: String },
}

impl From<RunStateError> for RunError {
    fn from(cause: RunStateError) -> Self {
        Self::Simulation(cause.into())
    }
}

impl RunError {
    fn exit_status(&self) -> u8 {
        match self {
            Self::Scene(_)
            | Self::NoWayOn { .. }
            | Self::Simulation(SimulationError::State(RunStateError::OffGrid { .. })) => 2,
            Self::Participant(ParticipantError::Interrupted)
            | Self::Start(StartError::Participant(ParticipantError::Interrupted)) => INTERRUPTED,
            Self::Simulation(SimulationError::Coupling(
                CouplingError::NotConverged { .. }
                | CouplingError::Futile { .. }
                | CouplingError::Diverged { .. },
            )) => 3,
            Self::Start(StartError::Program(_)) => 1,
            Self::Accuracy(error) => error.exit_status(),
            Self::Plan(_) => 4,
            Self::Unit(_)
            | Self::Start(_)
            | Self::Participant(_)
            | Self::NotThere { .. }
            | Self::Simulation(
                // A unit that fails while a picture is taken of it has failed all the same.
                SimulationError::Coupling(_)
                | SimulationError::Observer(ObserverError::Unit(_) | ObserverError::NotTold { .. }),
            ) => 4,
            _ => 1,
        }
    }
}

const INTERRUPTED: u8 = 130;

/// Runs a scene; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Run) -> ExitCode {
    arguments.options.begin();
    match execute(arguments) {
        Ok((Status::Completed, promised)) => ExitCode::from(promised),
        other => told(other.map(|(status, _)| status)),
    }
}

impl Options {
    /// Keeps standard output for the answer in JSON, if that was asked for.
    fn begin(&self) {
        if self.json {
            speak_to_programs();
        }
    }
}

/// Reports how a run ended.
fn told(ended: Result<Status, RunError>) -> ExitCode {
    match ended {
        Ok(Status::Interrupted) => ExitCode::from(INTERRUPTED),
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            let status = error.exit_status();
            answer(&NoAnswer { status: format!("failed: {error}"), exit_status: status });
            complain(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

/// Also returns the exit status that a completed run has by the accuracy that was asked for.
fn execute(arguments: &Run) -> Result<(Status, u8), RunError> {
    let mut settings = arguments.set.clone();
    settings.extend(arguments.log.iter().map(|which| format!("log.exchanges=\"{which}\"")));
    let mut loaded = read_scene(&arguments.scene, &settings)?;
    let started = jiff::Timestamp::now();
    check_transport(arguments.options.transport)?;
    if let Some(folder) = &arguments.output {
        folder::check(folder)?;
    }
    let mut promise = None;
    let asked = arguments.accuracy.clone().or(loaded.scene.accuracy.map(Into::into));
    if let Some(asked) = &asked {
        let mut promised = accuracy::promise(&arguments.scene, &settings, &loaded, asked)?;
        promised.plan = plan::rows(&loaded)?;
        promised.plan.iter().for_each(plan::print_row);
        accuracy::announce(&promised);
        settings.extend(promised.record.chosen.iter().cloned());
        loaded = read_scene(&arguments.scene, &settings)?;
        // A run of the manifest is this run again, not another choice.
        loaded.scene.accuracy = None;
        promise = Some(promised);
    }
    // Not before: Ctrl-C ends a pilot at once, and leaves no folder.
    let interrupted = catch_interrupt()?;
    let folder = match &arguments.output {
        Some(folder) => folder::claim(folder.clone())?,
        None => folder::claim_new(&format!("runs/{}-{}", loaded.name, started.strftime("%Y%m%dT%H%M%SZ")))?,
    };
    check::warn(&loaded.warnings);
    let job = Job {
        loaded: &loaded,
        options: &arguments.options,
        band: arguments.band,
        accuracy: promise.as_ref(),
        folder: &folder,
        started: started.to_string(),
        settings: &settings,
        interrupted: &interrupted,
    };
    let status = job.carry_out(Beginning::Initialisation)?;
    Ok((status, promise.as_ref().map_or(0, accuracy::Promise::exit_status)))
}

/// Checks whether units can be connected and catches Ctrl-C: the flag is true once the user asked for the end.
fn prepared(transport: Transport) -> Result<Arc<AtomicBool>, RunError> {
    check_transport(transport)?;
    catch_interrupt()
}

fn check_transport(transport: Transport) -> Result<(), RunError> {
    if transport == Transport::SharedMemory { Ok(Starting::check()?) } else { Ok(()) }
}

/// A flag that the first Ctrl-C sets; the second Ctrl-C ends the process.
fn catch_interrupt() -> Result<Arc<AtomicBool>, RunError> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever asked the unit last: the scheme, or an observer.
    #[test]
    fn a_unit_that_fails_has_one_exit_status() {
        let failure = || ParticipantError::Ended {
            participant: "dam".into(),
            how: "was killed by signal 9".into(),
            when: "in step 580".into(),
        };
        let asked_by_observer = SimulationError::Observer(ObserverError::Unit(failure()));
        let asked_by_scheme = SimulationError::Coupling(CouplingError::Participant(failure()));
        for error in [asked_by_observer, asked_by_scheme] {
            assert_eq!(RunError::from(error).exit_status(), 4);
        }
    }
}
