//! Messages of units, each with the step in which it was sent.

use cofferdam_unit::Level;
use serde::{Deserialize, Serialize};

/// A message of a unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// Name of the unit.
    pub unit: String,
    /// Severity.
    pub level: Level,
    /// Number of the communication step, 0 before the first.
    pub step: u64,
    /// Iteration of that step.
    pub iteration: u32,
    /// Start of that step, s.
    pub time: f64,
    /// Module of the source that sent it.
    pub source: String,
    /// The text.
    pub text: String,
}
