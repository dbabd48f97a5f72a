//! `cofferdam study`: series of runs, their tables and pictures.

mod accuracy;
mod ambient;
mod fidelity;
mod figure;
mod ledger;
mod meshes;
mod paper;
mod resolution;
mod rest;
mod seek;
mod sensitivity;
mod shaking;
mod stability;
mod tolerance;
mod windows;

use super::accuracy::AccuracyError;
use super::table::Table;
use super::{complain, making, parallel, say, threads};
use cofferdam_assembly::observer::{Histories, HistoriesWriter, Rest};
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::{Assembly, AssemblyError, read_scene};
use cofferdam_coupling::observer::{Ending, Status};
use cofferdam_coupling::scheme::{CouplingError, Graph};
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_motion::{GroundMotion, RecordError};
use cofferdam_scene::{LoadedScene, Scene, SceneError};
use miette::Diagnostic;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The studies.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Where each acceleration converges: densities, steps, meshes, water
    #[command(after_long_help = stability::HELP)]
    Stability(Arguments),
    /// Errors of all levels of numerics, and whether `run --accuracy` keeps what it promises
    #[command(after_long_help = accuracy::HELP)]
    Accuracy(accuracy::AccuracyArguments),
    /// Accuracy and cost of the tolerance
    #[command(after_long_help = tolerance::HELP)]
    Tolerance(Arguments),
    /// Accuracy and cost of the models of the water
    #[command(after_long_help = fidelity::HELP)]
    Fidelity(Arguments),
    /// How fine the elements of the wet face must be: errors against the closed form, and time
    #[command(after_long_help = resolution::HELP)]
    Resolution(Arguments),
    /// How much the results depend on mesh, time steps and modelling choices
    #[command(after_long_help = sensitivity::HELP)]
    Sensitivity(Arguments),
    /// How far the results scatter with the shaking, and whether every run reaches its end
    #[command(after_long_help = shaking::HELP)]
    Shaking(Arguments),
    /// How the error of the energy balance falls with the time step
    #[command(after_long_help = ledger::HELP)]
    Ledger(Arguments),
    /// One crack in five meshes, beside what a little more or less shaking does
    #[command(after_long_help = meshes::HELP)]
    Meshes(Arguments),
    /// What the block does after the ground has stopped, beside what eigenvalues say
    #[command(after_long_help = rest::HELP)]
    Rest(Arguments),
    /// Whether energy drifts in minutes of ambient vibration
    #[command(after_long_help = ambient::HELP)]
    Ambient(Arguments),
    /// How fast a step is found in a long log
    #[command(after_long_help = seek::HELP)]
    Seek(seek::SeekArguments),
    /// The paper's figures from our runs, beside what its text states
    #[command(after_long_help = paper::HELP)]
    Paper(paper::PaperArguments),
    /// Errors of the paper's short windows and of its missing condition at the far end
    #[command(after_long_help = windows::HELP)]
    Windows(Arguments),
}

/// Arguments of all studies.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder that holds scene.toml, or a .toml file
    scene: PathBuf,

    /// Change a value of the scene; may be given several times
    #[arg(short, long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Folder for tables and pictures; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Fewer runs, or shorter ones
    #[arg(long)]
    coarse: bool,
}

/// Why a study ended early.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum StudyError {
    /// The scene.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A choice of numerics.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Accuracy(#[from] AccuracyError),
    /// A unit.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A run that must succeed.
    #[error("{what}: {cause}")]
    Run {
        /// Which run.
        what: String,
        /// What was wrong.
        cause: Box<SimulationError>,
    },
    /// A record that the user gave.
    #[error("{option} (a path from where the command runs): {cause}")]
    Record {
        /// The option that names it.
        option: &'static str,
        /// What was wrong.
        cause: Box<RecordError>,
    },
    /// A scene that does not fit the study.
    #[error("{what}; choose another scene")]
    Unfit {
        /// What is missing.
        what: String,
    },
    /// A folder with something in it.
    #[error("{} is not empty; choose another --output, nothing is overwritten", path.display())]
    OutputTaken {
        /// The folder.
        path: PathBuf,
    },
    /// A file.
    #[error("{}: {cause}; choose another --output", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was wrong.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
}

fn unfit(what: impl Into<String>) -> StudyError {
    StudyError::Unfit { what: what.into() }
}

/// Runs a study and reports the result.
pub fn run(command: &Command) -> ExitCode {
    let done = match command {
        Command::Stability(arguments) => stability::run(arguments),
        Command::Accuracy(arguments) => accuracy::run(arguments),
        Command::Tolerance(arguments) => tolerance::run(arguments),
        Command::Ambient(arguments) => ambient::run(arguments),
        Command::Fidelity(arguments) => fidelity::run(arguments),
        Command::Resolution(arguments) => resolution::run(arguments),
        Command::Sensitivity(arguments) => sensitivity::run(arguments),
        Command::Ledger(arguments) => ledger::run(arguments),
        Command::Meshes(arguments) => meshes::run(arguments),
        Command::Paper(arguments) => paper::run(arguments),
        Command::Rest(arguments) => rest::run(arguments),
        Command::Seek(arguments) => seek::run(arguments),
        Command::Shaking(arguments) => shaking::run(arguments),
        Command::Windows(arguments) => windows::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match &error {
                StudyError::Scene(_) | StudyError::Unfit { .. } | StudyError::Record { .. } => 2,
                StudyError::Run { .. } => 3,
                StudyError::Accuracy(error) => error.exit_status(),
                StudyError::Unit(_) => 4,
                StudyError::File { .. } | StudyError::OutputTaken { .. } => 1,
            };
            complain(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

impl Arguments {
    fn load(&self) -> Result<LoadedScene, StudyError> {
        let loaded = read_scene(&self.scene, &self.set)?;
        let path = &self.output;
        let empty =
            std::fs::create_dir_all(path).and_then(|()| Ok(std::fs::read_dir(path)?.next().is_none()));
        match empty {
            Ok(true) => Ok(loaded),
            Ok(false) => Err(StudyError::OutputTaken { path: path.clone() }),
            Err(cause) => Err(StudyError::File { path: path.clone(), cause: cause.into() }),
        }
    }

    /// Writes a file into the output folder and prints its name.
    fn write(&self, name: &str, content: &str) -> Result<(), StudyError> {
        let path = self.output.join(name);
        std::fs::write(&path, content)
            .map_err(|cause| StudyError::File { path: path.clone(), cause: cause.into() })?;
        say(format!("wrote {}", path.display()));
        Ok(())
    }

    /// Writes a table as comma-separated values.
    fn write_table(&self, name: &str, table: &Table) -> Result<(), StudyError> {
        let text = table.csv().map_err(|cause| StudyError::File { path: self.output.join(name), cause })?;
        self.write(name, &text)
    }
}

const CREST: &str = "dam.crest_displacement.x";
/// Of the lowest crack.
const SLIDING: &str = "dam.crack_sliding.0";

/// Result of a run.
struct Outcome {
    histories: Histories,
    ending: Ending,
    failure: Option<CouplingError>,
}

/// Runs a scene in this process under `motion`, keeping its histories in memory.
///
/// **Errors**: a unit cannot be made; a failure of the coupling comes with the outcome.
fn run_scene(scene: &Scene, motion: &GroundMotion, threads: NonZeroUsize) -> Result<Outcome, StudyError> {
    run_units(scene, motion, Assembly::with(scene, making(threads)).graph()?)
}

/// Runs all scenes, as many at once as there are cores.
fn run_all(scenes: &[LoadedScene]) -> Result<Vec<Outcome>, StudyError> {
    run_each(&scenes.iter().collect::<Vec<_>>(), |_, outcome| Ok(outcome))
}

/// The same, keeping of each outcome what `keep` makes of it and the scene's index.
fn run_each<T: Send>(
    scenes: &[&LoadedScene],
    keep: impl Fn(usize, Outcome) -> Result<T, StudyError> + Sync,
) -> Result<Vec<T>, StudyError> {
    let begun = AtomicUsize::new(0);
    let numbered: Vec<_> = scenes.iter().enumerate().collect();
    parallel::try_map(&numbered, threads(None), |(index, loaded)| {
        let number = begun.fetch_add(1, Ordering::Relaxed) + 1;
        let outcome = run_scene(&loaded.scene, &loaded.ground_motion, NonZeroUsize::MIN)?;
        say(format!("{number} of {}: {}", scenes.len(), outcome.ending.status));
        keep(*index, outcome)
    })
}

/// The same with the given units.
fn run_units(scene: &Scene, motion: &GroundMotion, graph: Graph) -> Result<Outcome, StudyError> {
    let wrong = |cause| StudyError::Run { what: scene.title.clone(), cause: Box::new(cause) };
    let mut histories = HistoriesWriter::in_memory();
    let mut simulation = match simulation_of(scene, motion, graph) {
        Ok(simulation) => simulation,
        Err(error) => return Err(wrong(error)),
    };
    let mut rest = Rest::new(&scene.time);
    let (ending, failure) = simulation.run(&mut [&mut histories, &mut rest], &AtomicBool::new(false));
    let failure = match failure {
        None => None,
        Some(SimulationError::Coupling(error)) => Some(error),
        Some(error @ (SimulationError::Observer(_) | SimulationError::State(_))) => return Err(wrong(error)),
    };
    Ok(Outcome { histories: histories.histories, ending, failure })
}

impl Outcome {
    /// The outcome, if the run reached its end.
    fn completed(self, what: &str) -> Result<Self, StudyError> {
        match self.failure {
            Some(cause) => Err(StudyError::Run { what: what.to_owned(), cause: Box::new(cause.into()) }),
            None => {
                debug_assert_eq!(self.ending.status, Status::Completed);
                Ok(self)
            }
        }
    }

    fn column(&self, name: &str) -> &[f64] {
        self.histories.column(name).unwrap_or(&[])
    }

    /// Largest absolute value of a column.
    fn peak(&self, name: &str) -> f64 {
        self.column(name).iter().fold(0.0, |a, b| a.max(b.abs()))
    }

    /// Last value of a column; 0 if it has none.
    fn last(&self, name: &str) -> f64 {
        self.column(name).last().copied().unwrap_or(0.0)
    }

    /// Mean number of dam steps per communication step from row `from` on.
    fn iterations(&self, from: usize) -> f64 {
        let counts = self.column("iterations").get(from..).unwrap_or(&[]);
        counts.iter().sum::<f64>() / counts.len().max(1) as f64
    }
}

/// Mean and standard deviation.
fn moments(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    [mean, (values.map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()]
}

/// The path of a scene's file as printed in the table of a study.
fn quoted(scene: &Path) -> String {
    let mut parts: Vec<_> =
        scene.components().rev().take(2).map(|c| c.as_os_str().to_string_lossy()).collect();
    parts.reverse();
    parts.join("/")
}

/// Relative L2 difference over the length of `found`; 0 if `exact` is zero.
fn relative(found: &[f64], exact: &[f64]) -> f64 {
    let apart: f64 = found.iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum();
    let whole: f64 = exact.iter().take(found.len()).map(|b| b * b).sum();
    if whole > 0.0 { (apart / whole).sqrt() } else { 0.0 }
}
