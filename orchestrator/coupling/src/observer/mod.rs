//! The interface to observers of a run: logs, histories, progress.

mod until;

pub use until::Until;

use crate::participant::{Description, ParticipantError};
use crate::scheme::{Graph, WindowReport};
use crate::signal::Signal;
use crate::stepping::Stepping;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Duration;

/// Data known before the first exchange.
pub struct Start<'a> {
    /// The units by their numbers.
    pub units: Vec<Description>,
    /// The external signals.
    pub signals: &'a [Signal],
    /// The planned communication steps.
    pub stepping: Stepping,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Status {
    /// All steps were taken, or those up to a state of rest that the run was to wait for.
    Completed,
    /// The user ended it.
    Interrupted,
    /// A condition ended it; the text names it.
    Stopped(String),
    /// A failure ended it; the text names it.
    Failed(String),
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Completed => f.write_str("completed"),
            Self::Interrupted => f.write_str("interrupted"),
            Self::Stopped(condition) => write!(f, "stopped: {condition}"),
            Self::Failed(message) => write!(f, "failed: {message}"),
        }
    }
}

/// Wall times of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Seconds", into = "Seconds")]
pub struct WallTime {
    /// From the first call to the last, initialisation included.
    pub total: Duration,
    /// Initialisation of all units: static start of the dam.
    pub initialisation: Duration,
    /// Communication steps without observers.
    pub coupling: Duration,
    /// Inside each unit, by its name, including states.
    pub inside: Vec<(String, Duration)>,
    /// Time in which a unit was computing: the sum of all, or the longest where all compute at once.
    pub units: Duration,
    /// Inside the observers: log, histories, progress.
    pub observers: Duration,
    /// For checkpoints: states of the run and of its units.
    pub checkpoints: Duration,
}

impl WallTime {
    /// Time inside the unit `name`.
    pub fn of(&self, name: &str) -> Duration {
        self.inside.iter().filter(|(unit, _)| unit == name).map(|(_, time)| *time).sum()
    }

    /// Time of the coupling that was spent in no unit.
    pub fn exchange(&self) -> Duration {
        self.coupling.saturating_sub(self.units)
    }
}

/// Wall times in s, which take equally many bytes whatever they are: the size of a run's state, which checkpoints wait for, must not
/// depend on them.
#[derive(Serialize, Deserialize)]
struct Seconds {
    times: [f64; 6],
    inside: Vec<(String, f64)>,
}

impl From<WallTime> for Seconds {
    fn from(wall: WallTime) -> Self {
        let WallTime { total, initialisation, coupling, inside, units, observers, checkpoints } = wall;
        let times = [total, initialisation, coupling, units, observers, checkpoints];
        let inside = inside.into_iter().map(|(unit, time)| (unit, time.as_secs_f64()));
        Self { times: times.map(|time| time.as_secs_f64()), inside: inside.collect() }
    }
}

impl From<Seconds> for WallTime {
    fn from(Seconds { times, inside }: Seconds) -> Self {
        let time = |seconds| Duration::try_from_secs_f64(seconds).unwrap_or_default();
        let [total, initialisation, coupling, units, observers, checkpoints] = times.map(time);
        let inside = inside.into_iter().map(|(unit, seconds)| (unit, time(seconds))).collect();
        Self { total, initialisation, coupling, inside, units, observers, checkpoints }
    }
}

/// Statistics of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Steps that each unit took, by its name, and how many of them repeated one.
    pub calls: Vec<(String, [u64; 2])>,
    /// Communication steps that were accepted without convergence.
    pub unconverged: u64,
    /// Windows in which other accelerations had to take over.
    pub fallbacks: u64,
    /// Windows that were repeated with shorter steps.
    pub rejected: u64,
    /// Change of the residual when values change by rounding, where it was measured.
    pub rounding_floor: Option<f64>,
    /// Largest norm of the backward fields.
    pub largest: f64,
    /// Largest relative difference of the work between faces that do not match.
    pub mapping_error: f64,
}

/// The end of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Ending {
    /// The ending.
    pub status: Status,
    /// Time reached, s.
    pub time: f64,
    /// Wall times.
    pub wall: WallTime,
    /// Statistics.
    pub statistics: Statistics,
}

/// From where a run can go on: its state between two windows, and those of its units.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Number of the last step before.
    pub step: u64,
    /// Its end, s.
    pub time: f64,
    /// The state of the run, without its units: [`RunState`](crate::run_state::RunState) as bytes.
    pub run: Vec<u8>,
    /// The states of the units by their numbers; `None` for one that gives none, or whose state was not wanted.
    pub units: Vec<Option<Vec<u8>>>,
}

/// What observers of a run are told that continues: what came before.
#[derive(Clone, Debug, PartialEq)]
pub enum Past {
    /// A window, accepted or not.
    Window(WindowReport),
    /// A checkpoint.
    Checkpoint(Checkpoint),
}

/// Why an observer failed.
#[derive(Debug, thiserror::Error)]
pub enum ObserverError {
    /// An observer from outside this module, such as the log.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
    /// A file of results.
    #[error("{}: {cause}; {remedy}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: std::io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// A unit could not be read.
    #[error(transparent)]
    Unit(#[from] ParticipantError),
    /// A setting asks for what a unit, such as one of another program, does not tell.
    #[error(
        "`{key}` needs `{variable}` of {unit}, which does not have it; leave `{key}` out, or let the unit tell it"
    )]
    NotTold {
        /// The setting.
        key: &'static str,
        /// The unit's variable.
        variable: String,
        /// The unit's name.
        unit: String,
    },
}

/// Observes a run. It changes no result, but may end the run.
///
/// **Call order**: `begin`, `window` for initialisation (step 0) and for every window of communication steps (usually
/// one step), followed by `inspect` if it was accepted, and by `checkpoint` where an observer wants one; `end` in any case. An
/// error ends the run. A run that continues from a log begins with `past` for every window of the log, in place of `window` and
/// `inspect`.
pub trait Observer {
    /// Before the first exchange.
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError>;

    /// After every window; one that failed or is repeated holds no accepted exchange.
    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError>;

    /// A window of the run that this one continues; by default as if it were computed now.
    fn past(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.window(report)
    }

    /// Reads variables that are not exchanged, at the end of the last accepted window.
    fn inspect(&mut self, _graph: &mut Graph) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Whether it wants a checkpoint at the end of the last accepted window: the units whose states belong to it.
    fn wants_checkpoint(&self) -> Option<Vec<bool>> {
        None
    }

    /// A checkpoint at the end of the last accepted window, wanted by itself or another.
    fn checkpoint(&mut self, _checkpoint: &Checkpoint) -> Result<(), ObserverError> {
        Ok(())
    }

    /// After the last window, however the run ended.
    fn end(&mut self, ending: &Ending) -> Result<(), ObserverError>;

    /// How the run ends after this window, if the observer ends it.
    fn ends(&self) -> Option<Status> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::{Fingerprint, open, seal};

    /// With times as they are, 127 s took a byte less than 128 s, and checkpoints lay elsewhere in a log of a slower machine.
    #[test]
    fn wall_times_take_equally_many_bytes() {
        let wall = |seconds: f64| {
            let time = Duration::from_secs_f64(seconds);
            WallTime {
                total: time,
                units: time,
                inside: vec![("dam".to_owned(), time)],
                ..WallTime::default()
            }
        };
        let here = Fingerprint::of("wall times", &()).expect("a hash");
        let bytes = |seconds: f64| seal(here, &wall(seconds)).expect("bytes");
        for seconds in [1e-6, 0.25, 127.0, 128.0, 3e5] {
            assert_eq!(bytes(seconds).len(), bytes(0.0).len(), "{seconds} s");
            assert_eq!(open::<WallTime>(here, &bytes(seconds)), Ok(wall(seconds)), "{seconds} s");
        }
    }
}
