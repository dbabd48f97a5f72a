//! The door for whoever watches a run: log, histories, progress.

mod histories;
mod progress;

pub use histories::{Histories, HistoriesWriter};
pub use progress::Progress;

use crate::log::LogError;
use crate::participant::Description;
use crate::scene::GroundMotion;
use crate::scheme::StepReport;
use std::path::PathBuf;
use std::time::Duration;

/// What is known before the first exchange.
pub struct Start<'a> {
    /// The dam.
    pub dam: Description,
    /// The reservoir.
    pub reservoir: Description,
    /// What moves the ground.
    pub ground_motion: &'a GroundMotion,
    /// Length of a communication step, s.
    pub communication_step: f64,
    /// Number of communication steps planned.
    pub steps: u64,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Status {
    /// All steps were taken.
    Completed,
    /// The user ended it.
    Interrupted,
    /// A failure ended it; the message says which.
    Failed(String),
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Completed => f.write_str("completed"),
            Self::Interrupted => f.write_str("interrupted"),
            Self::Failed(message) => write!(f, "failed: {message}"),
        }
    }
}

/// Where the wall time of a run went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WallTime {
    /// From the first call to the last, initialisation included.
    pub total: Duration,
    /// Initialisation of both units: static start of the dam.
    pub initialisation: Duration,
    /// Communication steps, observers not included.
    pub coupling: Duration,
    /// Inside the dam, states included.
    pub dam: Duration,
    /// Inside the reservoir, states included.
    pub reservoir: Duration,
    /// Inside the observers: log, histories, progress.
    pub observers: Duration,
}

impl WallTime {
    /// Time of the coupling that was spent in neither unit.
    pub fn exchange(&self) -> Duration {
        self.coupling.saturating_sub(self.dam + self.reservoir)
    }
}

/// The end of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Ending {
    /// How it ended.
    pub status: Status,
    /// Time reached, s.
    pub time: f64,
    /// Where the wall time went.
    pub wall: WallTime,
}

/// An observer that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum ObserverError {
    /// The log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A history file.
    #[error("{}: {cause}; free some space or choose another --output", path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: csv::Error,
    },
}

/// Watches a run; never changes it.
///
/// **Call order**: `begin`, `step` for initialisation (step 0) and for every step, `end` in
/// any case. An error ends the run.
pub trait Observer {
    /// Before the first exchange.
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError>;

    /// After every step; a failed one holds no accepted exchange.
    fn step(&mut self, report: &StepReport) -> Result<(), ObserverError>;

    /// After the last step, however the run ended.
    fn end(&mut self, ending: &Ending) -> Result<(), ObserverError>;
}
