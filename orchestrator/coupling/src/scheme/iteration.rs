//! What an iteration of a window did.

use crate::acceleration::Correction;
use crate::convergence::Residuals;

/// What the guess of an iteration was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To come closer to the solution.
    Solution,
    /// To measure the Jacobian: one unknown is moved.
    Jacobian,
    /// To check that the units return to their saved states: the guess before, again.
    States,
    /// To measure the rounding floor: the guess before, moved by rounding.
    RoundingFloor,
}

impl Purpose {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Solution, Self::Jacobian, Self::States, Self::RoundingFloor];

    /// The word for it in logs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Solution => "solution",
            Self::Jacobian => "jacobian",
            Self::States => "states",
            Self::RoundingFloor => "rounding-floor",
        }
    }
}

/// The value whose answer is farthest from its guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPoint {
    /// Number of the step in the run.
    pub step: u64,
    /// Number of the interface, from 0.
    pub interface: usize,
    /// Number of the value that the first unit receives there, from 0.
    pub point: usize,
    /// What the first unit was given.
    pub given: f64,
    /// What the second unit answered.
    pub answered: f64,
}

/// What an iteration of a window did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationReport {
    /// Its number in the window, from 1.
    pub iteration: u32,
    /// What its guess was for.
    pub purpose: Purpose,
    /// How its guess came about; the first of a window is the predictor's.
    pub correction: Correction,
    /// How far its answer is from the guess; `None` where nothing was compared.
    pub residuals: Option<Residuals>,
    /// Where it is farthest; `None` where nothing was compared.
    pub worst: Option<WorstPoint>,
}
