//! The entries of a log.

use crate::participant::{Message, Occasion};
use crate::scheme::Side;

/// A request and its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedExchange {
    /// Unit that was asked.
    pub side: Side,
    /// Which of its steps.
    pub occasion: Occasion,
    /// The values that the run went on with.
    pub accepted: bool,
    /// Number of the exchange in its run, from 1.
    pub sequence: u32,
    /// The request, in the order of the unit's input layout.
    pub inputs: Vec<f64>,
    /// The answer, in the order of the unit's output layout; `None` if the unit failed and gave none.
    pub outputs: Option<Vec<f64>>,
}

/// A communication step that was taken, or tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoggedStep {
    /// The step; its iteration is the number of iterations.
    pub occasion: Occasion,
    /// The run went on with it.
    pub accepted: bool,
    /// The units agreed as closely as was asked.
    pub converged: bool,
    /// Pressure residual of its last iteration, Pa.
    pub residual: f64,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEnd {
    /// `completed`, `interrupted`, or `failed: ` and why.
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
    /// Something that a unit said.
    Message(Message),
    /// The end of the run; nothing follows.
    End(LoggedEnd),
    /// The file breaks off at this byte, and the run's end with it; nothing follows.
    Cut(u64),
}
