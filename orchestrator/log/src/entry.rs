//! The entries of a log.

use cofferdam_coupling::observer::Checkpoint;
use cofferdam_coupling::participant::{Message, Occasion};
use cofferdam_coupling::scheme::{InterfaceReport, IterationReport, UnitId};

/// A request and its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedExchange {
    /// Unit that was asked.
    pub unit: UnitId,
    /// The step that it was asked to take.
    pub occasion: Occasion,
    /// Whether the run continued with these values.
    pub accepted: bool,
    /// Number of the exchange in its run, from 1.
    pub sequence: u32,
    /// When the request was sent and when the answer arrived, s of wall time from the start of the run.
    pub wall_time: [f64; 2],
    /// The request, in the order of the unit's input layout.
    pub inputs: Vec<f64>,
    /// The answer, in the order of the unit's output layout; `None` if the unit failed and gave none.
    pub outputs: Option<Vec<f64>>,
}

/// What an iteration of a window did.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedIteration {
    /// Number of the window's first step, and of its steps.
    pub steps: [u64; 2],
    /// Number of the attempt, from 1.
    pub attempt: u32,
    /// What it did.
    pub report: IterationReport,
}

/// A communication step, accepted or only attempted.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedStep {
    /// The step; its iteration is the number of iterations.
    pub occasion: Occasion,
    /// Whether the run continued with it.
    pub accepted: bool,
    /// Whether the units agreed to the tolerance.
    pub converged: bool,
    /// Why no further iteration followed; empty in logs of earlier versions.
    pub outcome: String,
    /// Residual of its last iteration.
    pub residual: f64,
    /// Accelerations that were given up in its window.
    pub fallbacks: u32,
    /// Error of the linear interpolation of the backward fields; `None` where it is unknown.
    pub interpolation_error: Option<f64>,
    /// Largest norm of the backward fields in the run so far.
    pub largest: f64,
    /// Rounding floor of the residual; `None` until it is measured.
    pub rounding_floor: Option<f64>,
    /// Every interface at the step's end; none if the step was not accepted.
    pub interfaces: Vec<InterfaceReport>,
    /// Time inside each unit, s.
    pub unit_times: Vec<f64>,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEnd {
    /// `completed`, `interrupted`, or `failed: ` with the reason.
    pub status: String,
    /// Time reached, s.
    pub time: f64,
}

/// What is missing in a log that was recovered from a damaged or cut one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedDamage {
    /// First byte that could not be read, from the beginning of the damaged file.
    pub first: u64,
    /// Last byte that could not be read.
    pub last: u64,
    /// What was wrong.
    pub what: String,
}

impl std::fmt::Display for LoggedDamage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "bytes {} to {}: {}", self.first, self.last, self.what)
    }
}

/// One entry of a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A request and its answer.
    Exchange(LoggedExchange),
    /// What an iteration did, after the exchanges of its window.
    Iteration(LoggedIteration),
    /// The end of a step, after the iterations of its window.
    Step(LoggedStep),
    /// The state of the run at the end of the step before, and those of its units.
    Checkpoint(Checkpoint),
    /// A message of a unit.
    Message(Message),
    /// Here something is missing: exchanges before and after it need not follow each other.
    Damage(LoggedDamage),
    /// The end of the run; nothing follows.
    End(LoggedEnd),
    /// The file is cut off at this byte, so that the end of the run is missing; nothing follows.
    Cut(u64),
}

impl Entry {
    /// Number of the step that it belongs to, where it belongs to one.
    pub fn step(&self) -> Option<u64> {
        match self {
            Self::Exchange(exchange) => Some(exchange.occasion.step),
            Self::Iteration(iteration) => Some(iteration.steps[0]),
            Self::Step(step) => Some(step.occasion.step),
            Self::Checkpoint(checkpoint) => Some(checkpoint.step),
            Self::Message(message) => Some(message.step),
            Self::Damage(_) | Self::End(_) | Self::Cut(_) => None,
        }
    }
}
