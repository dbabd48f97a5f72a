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
    /// The end of a step, after its exchanges.
    Step(LoggedStep),
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
            Self::Step(step) => Some(step.occasion.step),
            Self::Message(message) => Some(message.step),
            Self::Damage(_) | Self::End(_) | Self::Cut(_) => None,
        }
    }
}
