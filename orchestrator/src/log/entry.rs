//! The entries of a log.

use crate::participant::{Message, Occasion};
use crate::scheme::UnitId;

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
    /// The request, in the order of the unit's input layout.
    pub inputs: Vec<f64>,
    /// The answer, in the order of the unit's output layout; `None` if the unit failed and gave none.
    pub outputs: Option<Vec<f64>>,
}

/// A communication step, accepted or only attempted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoggedStep {
    /// The step; its iteration is the number of iterations.
    pub occasion: Occasion,
    /// Whether the run continued with it.
    pub accepted: bool,
    /// Whether the units agreed to the tolerance.
    pub converged: bool,
    /// Pressure residual of its last iteration, Pa.
    pub residual: f64,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEnd {
    /// `completed`, `interrupted`, or `failed: ` with the reason.
    pub status: String,
    /// Time reached, s.
    pub time: f64,
}

/// One entry of a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A request and its answer.
    Exchange(LoggedExchange),
    /// The end of a step, after its exchanges.
    Step(LoggedStep),
    /// A message of a unit.
    Message(Message),
    /// The end of the run; nothing follows.
    End(LoggedEnd),
    /// The file is cut off at this byte, so that the end of the run is missing; nothing follows.
    Cut(u64),
}
