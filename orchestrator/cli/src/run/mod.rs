//! `cofferdam run`, `resume` and `branch`.

mod answer;
pub mod branch;
pub mod resume;

use crate::context::context;
use crate::log::diff::verdict;
use crate::options::Options;
use crate::terminal::{answer, answer_programs, print, warn};
use answer::{Answer, NoAnswer};
use cofferdam_analysis::accuracy::{AccuracyError, Asked, Promise, Verdict};
use cofferdam_analysis::run::{PreparedRun, Request, RunError, RunOutcome, branch as branches, prepare};
use cofferdam_analysis::start::StartError;
use cofferdam_assembly::observer::Progress;
use cofferdam_coupling::observer::{ObserverError, Status};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::run_state::RunStateError;
use cofferdam_coupling::scheme::CouplingError;
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_report::text;
use miette::Diagnostic;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Arguments of `cofferdam run`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    ///
    /// scenes/README.md documents every key of a scene, with units and defaults. All errors in a scene are
    /// reported at once, with their lines, before the run starts. Doubtful choices give warnings and do not
    /// prevent the run. `cofferdam check` reports the same without running.
    pub scene: PathBuf,

    /// Change a value of the scene (repeatable)
    ///
    /// For example dam.element_size=2.5 or dam.cracks.0.elevation=60. The manifest of the results contains
    /// the scene as it was run.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for the results (default: runs/SCENE-TIME)
    ///
    /// The folder is created if necessary. A folder that is not empty is refused; nothing is overwritten.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    /// Exchanges to log: those of every iteration, accepted ones only, or none
    ///
    /// Short for --set log.exchanges=WHICH. Accepted exchanges need half of the disk space and suffice for
    /// `replay`, `branch` and `resume`. With none, intended for series of runs, the run can only be
    /// repeated from the start.
    #[arg(long, value_name = "WHICH", value_parser = ["every", "accepted", "none"])]
    pub log: Option<String>,

    /// Also run N perturbed replicates (1 % noise on the motion) and give each result a band
    ///
    /// The band consists of the 16 % quantile, the median and the 84 % quantile. A single run of a cracked
    /// dam is only one realisation. The replicates use the reduced dam if the run uses the full one.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(3..=10_000))]
    pub band: Option<u16>,

    /// Choose the numerics for this accuracy: 5%, or crest=2%,history=5%,sliding=20%
    ///
    /// Low-fidelity pilot runs determine the cheapest level whose expected error against the reference is
    /// small enough. The run reports the chosen level and whether the accuracy is kept, is not kept, or
    /// cannot be kept because a change of 1 % in the shaking changes the results by more. Element size,
    /// communication step, fidelity of the dam and time integration method of the water are chosen; the
    /// physical model is unchanged. docs/measurements/accuracy.md defines the quantities.
    #[arg(long, value_name = "SHARE", value_parser = clap::value_parser!(Asked))]
    pub accuracy: Option<Asked>,

    #[command(flatten)]
    pub options: Options,
}

pub const HELP: &str = "\
Results in the output folder:
  report.html     everything below on one page, for screen and print
  log.mcap        requests and responses of every iteration (MCAP, protobuf);
                  open it with Foxglove, PlotJuggler, Rerun or Python's mcap
  histories.csv   time histories of all scalar results
  response_spectra.csv, .svg
                  response spectra of ground and crest, 5 % damping
  snapshots.pvd   fields of the dam over time for ParaView, if the scene has
                  [snapshots]
  dam-*.csv, reservoir-*.csv, and tailwater-*.csv with [tailwater]
                  motion and pressure of the wet faces, one column per point
  manifest.toml   the scene with all defaults, versions, machine and summary

Examples:
  cofferdam run scenes/koyna-northridge-1994
      The cracked Koyna dam under a record of the 1994 Northridge earthquake.
  cofferdam run scenes/rigid-dam-ramp --output /tmp/ramp
      A rigid dam under a ramp of acceleration, with a closed-form solution.
  cofferdam run scenes/koyna-northridge-1994 --set dam.element_size=1.25
      The same dam with a finer mesh.
  cofferdam run scenes/koyna-northridge-1994 --band 16
      The scatter of the results when the motion is perturbed by 1 %.
  cofferdam run scenes/koyna-intact --accuracy 5%
      The cheapest run with an expected crest error of at most 5 %.
  cofferdam run scenes/koyna-northridge-1994 --json | jq .key_figures
      The key figures, for use by a program.

Ctrl-C ends a run after the current step. The log and the histories remain
readable, and the summary is marked as partial. A second Ctrl-C exits
immediately.

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid, 3 a step did not converge, 4 a unit failed, 130 interrupted. A
completed run with --accuracy: 0 the accuracy is kept, 6 not kept, 7 cannot be
kept.";

/// Reason why a run ended without a result, or with a partial result.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    #[error("Ctrl-C cannot be caught: {0}; this needs a thread; raise the limit (`ulimit -u`)")]
    Signal(#[from] ctrlc::Error),
}

/// The program's exit status.
fn exit_status(error: &RunError) -> u8 {
    match error {
        RunError::Scene(_)
        | RunError::NoWayOn { .. }
        | RunError::Simulation(SimulationError::State(RunStateError::OffGrid { .. })) => 2,
        RunError::Participant(ParticipantError::Interrupted)
        | RunError::Start(StartError::Participant(ParticipantError::Interrupted)) => INTERRUPTED,
        RunError::Simulation(SimulationError::Coupling(
            CouplingError::NotConverged { .. }
            | CouplingError::Futile { .. }
            | CouplingError::Diverged { .. },
        )) => 3,
        RunError::Start(StartError::Program(_)) => 1,
        RunError::Accuracy(error) => accuracy_status(error),
        RunError::Plan(_) => 4,
        RunError::Unit(_)
        | RunError::Start(_)
        | RunError::Participant(_)
        | RunError::NotThere { .. }
        | RunError::Simulation(
            // A unit that fails while a picture is taken of it has failed all the same.
            SimulationError::Coupling(_)
            | SimulationError::Observer(ObserverError::Unit(_) | ObserverError::NotTold { .. }),
        ) => 4,
        _ => 1,
    }
}

/// The exit status after a pilot that failed.
fn accuracy_status(error: &AccuracyError) -> u8 {
    match error {
        AccuracyError::Scene(_) | AccuracyError::Unfit { .. } => 2,
        AccuracyError::Run { .. } => 3,
        AccuracyError::Unit(_) => 4,
    }
}

const INTERRUPTED: u8 = 130;

/// Runs a scene; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    arguments.options.begin();
    match execute(arguments) {
        Ok((Status::Completed, promised)) => ExitCode::from(promised),
        other => told(other.map(|(status, _)| status)),
    }
}

impl Options {
    /// Reserves standard output for the result in JSON, if requested.
    fn begin(&self) {
        if self.json {
            answer_programs();
        }
    }
}

/// Reports how a run ended.
fn told(ended: Result<Status, Failure>) -> ExitCode {
    match ended {
        Ok(Status::Interrupted) => ExitCode::from(INTERRUPTED),
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match &error {
                Failure::Run(error) => exit_status(error),
                Failure::Signal(_) => 1,
            };
            answer(&NoAnswer { status: format!("failed: {error}"), exit_status: status });
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

/// Also returns the exit status of a completed run according to the requested accuracy.
fn execute(arguments: &Arguments) -> Result<(Status, u8), Failure> {
    let mut settings = arguments.set.clone();
    settings.extend(arguments.log.iter().map(|which| format!("log.exchanges=\"{which}\"")));
    let request = Request {
        scene: arguments.scene.clone(),
        settings,
        output: arguments.output.clone(),
        band: arguments.band,
        accuracy: arguments.accuracy.clone(),
        options: arguments.options.of_run(),
    };
    let run = prepare(&request, &context())?;
    let promised = run.promise().map_or(0, status_of_promise);
    Ok((carry_out(run, &arguments.options)?, promised))
}

/// The exit status of a completed run with an accuracy.
fn status_of_promise(promise: &Promise) -> u8 {
    match promise.verdict() {
        Verdict::Kept => 0,
        Verdict::NotKept => 6,
        Verdict::Impossible => 7,
    }
}

/// Runs to the end, or until Ctrl-C, and prints what came of it.
fn carry_out(run: PreparedRun, options: &Options) -> Result<Status, Failure> {
    // Not before: Ctrl-C ends a pilot at once, and leaves no folder.
    let interrupted = catch_interrupt()?;
    let mut progress = Progress::new(options.quiet);
    let outcome = run.carry_out(&context(), &interrupted, &mut [&mut progress])?;
    let RunOutcome { status, folder, summary, model, wall, parent, has_report, page_failure, failure } =
        outcome;
    answer(&Answer::of(&folder, &summary, &model, &wall));
    print(format!("\n{}{}{}", text::table(&summary), dam_lines(&model), text::wall_time(&wall)));
    let report = if has_report { "report, " } else { "" };
    print(format!("{report}log, histories and manifest are in {}", folder.display()));
    if let Some(cause) = page_failure {
        warn(format!("no report: {cause}"));
    }
    if let Some(parent) = parent {
        match branches::compare(&parent, &folder) {
            Ok(comparison) => print(format!("against the run: {}", verdict(&comparison))),
            Err(error) => warn(error),
        }
    }
    failure.map_or(Ok(status), |error| Err(error.into()))
}

/// The lines of the table that name the model.
fn dam_lines(model: &[(&str, String)]) -> String {
    let lines: String = model
        .iter()
        .map(|(what, words)| text::wrapped(&format!("  {what}: {words}"), "    ") + "\n")
        .collect();
    if lines.is_empty() { lines } else { text::heading("Model") + &lines }
}

/// A flag that the first Ctrl-C sets; the second Ctrl-C ends the process.
fn catch_interrupt() -> Result<Arc<AtomicBool>, ctrlc::Error> {
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

    /// The last caller of the unit: the scheme or an observer.
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
            assert_eq!(exit_status(&RunError::from(error)), 4);
        }
    }
}
