//! Series of runs in memory, for studies that vary one thing after the other.

use crate::accuracy::AccuracyError;
use crate::context::{Context, threads};
use crate::parallel;
use crate::picture::{self, Drawing};
use crate::table::Table;
use cofferdam_assembly::observer::{Histories, HistoriesWriter, Rest};
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::observer::{Ending, Status};
use cofferdam_coupling::scheme::{CouplingError, Graph};
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_motion::{GroundMotion, RecordError};
use cofferdam_scene::{LoadedScene, Scene, SceneError};
use miette::Diagnostic;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, SVGBackend};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Reason why a study ended early.
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
        /// The cause.
        cause: Box<SimulationError>,
    },
    /// A record that the user gave.
    #[error("{option} (a path from where the command runs): {cause}")]
    Record {
        /// The option that names it.
        option: &'static str,
        /// The cause.
        cause: Box<RecordError>,
    },
    /// A value of an option that does not fit the scene.
    #[error("{option} {value}: {remedy}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What is wrong, and the remedy.
        remedy: String,
    },
    /// A scene that does not fit the study.
    #[error("{what}; choose another scene")]
    Unfit {
        /// The missing property.
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
        /// The cause.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// A scene that does not fit a study; `what` is missing.
pub fn unfit(what: impl Into<String>) -> StudyError {
    StudyError::Unfit { what: what.into() }
}

/// The folder of a study's tables and pictures.
#[derive(Clone, Copy, Debug)]
pub struct StudyFolder<'a> {
    /// Its path.
    pub path: &'a Path,
}

impl StudyFolder<'_> {
    /// Creates the folder, or takes an empty one.
    ///
    /// **Errors**: [`StudyError::OutputTaken`], [`StudyError::File`].
    pub fn claim(&self) -> Result<(), StudyError> {
        let path = self.path;
        let empty =
            std::fs::create_dir_all(path).and_then(|()| Ok(std::fs::read_dir(path)?.next().is_none()));
        match empty {
            Ok(true) => Ok(()),
            Ok(false) => Err(StudyError::OutputTaken { path: path.to_owned() }),
            Err(cause) => Err(StudyError::File { path: path.to_owned(), cause: cause.into() }),
        }
    }

    /// Writes a file and reports its name.
    ///
    /// **Errors**: [`StudyError::File`].
    pub fn write(&self, name: &str, content: &str, context: &Context<'_>) -> Result<(), StudyError> {
        let path = self.path.join(name);
        std::fs::write(&path, content)
            .map_err(|cause| StudyError::File { path: path.clone(), cause: cause.into() })?;
        context.line(format!("wrote {}", path.display()));
        Ok(())
    }

    /// Writes a table as comma-separated values.
    ///
    /// **Errors**: [`StudyError::File`].
    pub fn write_table(&self, name: &str, table: &Table, context: &Context<'_>) -> Result<(), StudyError> {
        let text = table.csv().map_err(|cause| StudyError::File { path: self.path.join(name), cause })?;
        self.write(name, &text, context)
    }
}

/// Horizontal displacement of the crest, m.
pub const CREST: &str = "dam.crest_displacement.x";
/// Sliding of the lowest crack, m.
pub const SLIDING: &str = "dam.crack_sliding.0";

/// Result of a run.
pub struct Outcome {
    /// Its histories.
    pub histories: Histories,
    /// Status at the end.
    pub ending: Ending,
    /// Reason why the coupling failed.
    pub failure: Option<CouplingError>,
}

/// Runs a scene in this process under `motion`, keeping its histories in memory.
///
/// **Errors**: a unit cannot be made; a failure of the coupling comes with the outcome.
pub fn run_scene(
    scene: &Scene,
    motion: &GroundMotion,
    threads: NonZeroUsize,
    context: &Context<'_>,
) -> Result<Outcome, StudyError> {
    run_units(scene, motion, Assembly::with(scene, context.making(threads)).graph()?)
}

/// Runs all scenes, as many at once as there are cores.
pub fn run_all(scenes: &[LoadedScene], context: &Context<'_>) -> Result<Vec<Outcome>, StudyError> {
    run_each(&scenes.iter().collect::<Vec<_>>(), |_, outcome| Ok(outcome), context)
}

/// The same, keeping of each outcome what `keep` makes of it and the scene's index.
pub fn run_each<T: Send>(
    scenes: &[&LoadedScene],
    keep: impl Fn(usize, Outcome) -> Result<T, StudyError> + Sync,
    context: &Context<'_>,
) -> Result<Vec<T>, StudyError> {
    let begun = AtomicUsize::new(0);
    let numbered: Vec<_> = scenes.iter().enumerate().collect();
    parallel::try_map(&numbered, threads(None), |(index, loaded)| {
        let number = begun.fetch_add(1, Ordering::Relaxed) + 1;
        let outcome = run_scene(&loaded.scene, &loaded.ground_motion, NonZeroUsize::MIN, context)?;
        context.line(format!("{number} of {}: {}", scenes.len(), outcome.ending.status));
        keep(*index, outcome)
    })
}

/// The same with the given units.
pub fn run_units(scene: &Scene, motion: &GroundMotion, graph: Graph) -> Result<Outcome, StudyError> {
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
    pub fn completed(self, what: &str) -> Result<Self, StudyError> {
        match self.failure {
            Some(cause) => Err(StudyError::Run { what: what.to_owned(), cause: Box::new(cause.into()) }),
            None => {
                debug_assert_eq!(self.ending.status, Status::Completed);
                Ok(self)
            }
        }
    }

    /// A column; empty if there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        self.histories.column(name).unwrap_or(&[])
    }

    /// Largest absolute value of a column.
    pub fn peak(&self, name: &str) -> f64 {
        self.column(name).iter().fold(0.0, |a, b| a.max(b.abs()))
    }

    /// Last value of a column; 0 if it has none.
    pub fn last(&self, name: &str) -> f64 {
        self.column(name).last().copied().unwrap_or(0.0)
    }

    /// Mean number of dam steps per communication step from row `from` on.
    pub fn iterations(&self, from: usize) -> f64 {
        let counts = self.column("iterations").get(from..).unwrap_or(&[]);
        counts.iter().sum::<f64>() / counts.len().max(1) as f64
    }
}

/// Mean and standard deviation.
pub fn moments(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    [mean, (values.map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()]
}

/// The path of a scene's file as printed in the table of a study.
pub fn quoted(scene: &Path) -> String {
    let mut parts: Vec<_> =
        scene.components().rev().take(2).map(|c| c.as_os_str().to_string_lossy()).collect();
    parts.reverse();
    parts.join("/")
}

/// Relative L2 difference over the length of `found`; 0 if `exact` is zero.
pub fn relative(found: &[f64], exact: &[f64]) -> f64 {
    let apart: f64 = found.iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum();
    let whole: f64 = exact.iter().take(found.len()).map(|b| b * b).sum();
    if whole > 0.0 { (apart / whole).sqrt() } else { 0.0 }
}

/// An SVG of `size` that `draw` fills.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawing,
) -> Result<String, StudyError> {
    picture::svg(size, draw).map_err(|cause| StudyError::File { path: "picture".into(), cause })
}
