//! What units say while they compute, with its occasion.

use interface::Level;
use serde::{Deserialize, Serialize};

/// Something that a unit said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// Name of the unit.
    pub unit: String,
    /// How much it matters.
    pub level: Level,
    /// Number of the communication step, 0 before the first.
    pub step: u64,
    /// Iteration of that step.
    pub iteration: u32,
    /// Start of that step, s.
    pub time: f64,
    /// Where in the source it was said: the module.
    pub source: String,
    /// What was said.
    pub text: String,
}
