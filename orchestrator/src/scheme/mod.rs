//! Coupling schemes: how the units take a communication step together.

mod predictor;
mod serial_implicit;

pub use predictor::Predictor;
pub use serial_implicit::SerialImplicit;

use crate::convergence::{Hopeless, Residuals};
use crate::participant::{Message, Occasion, Participant, ParticipantError};
use std::time::Duration;

/// Which of the two units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The dam: takes pressure, answers with motion.
    Dam,
    /// The reservoir: takes acceleration, answers with pressure.
    Reservoir,
}

/// The two units that are coupled.
pub struct Units {
    /// Takes pressure, answers with motion.
    pub dam: Box<dyn Participant>,
    /// Takes acceleration, answers with pressure.
    pub reservoir: Box<dyn Participant>,
}

/// One request and its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchange {
    /// Unit that was asked.
    pub side: Side,
    /// Iteration of the communication step, from 1; 0 is initialisation.
    pub iteration: u32,
    /// The values that the run went on with.
    pub accepted: bool,
    /// The request, in the order of the unit's input layout.
    pub inputs: Vec<f64>,
    /// The answer, in the order of the unit's output layout; empty if the unit failed and gave none.
    pub outputs: Vec<f64>,
    /// When the request was sent, since the run began.
    pub sent: Duration,
    /// When the answer had come, since the run began.
    pub answered: Duration,
}

/// What happened in a communication step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport {
    /// Number of the step, from 1; 0 is initialisation.
    pub step: u64,
    /// How often the step was begun anew with another length, from 1.
    pub attempt: u32,
    /// Start of the step, s.
    pub time: f64,
    /// Length of the step, s; 0 at initialisation.
    pub communication_step: f64,
    /// Ground acceleration (x, y) at the step's end, m/s².
    pub ground_acceleration: [f64; 2],
    /// Every exchange, in order.
    pub exchanges: Vec<Exchange>,
    /// Residuals of the last iteration; `None` at initialisation.
    pub residuals: Option<Residuals>,
    /// Relaxation factor used last.
    pub relaxation: f64,
    /// Time that the dam and the reservoir themselves took, states saved and restored included.
    pub solver_time: [Duration; 2],
    /// What the units said.
    pub messages: Vec<Message>,
}

impl StepReport {
    /// Number of iterations: dam steps, the confirming one included.
    pub fn iterations(&self) -> u32 {
        self.exchanges.last().map_or(0, |e| e.iteration)
    }

    /// The iteration `iteration` of this step.
    pub fn occasion(&self, iteration: u32) -> Occasion {
        let Self { step, attempt, time, communication_step, .. } = *self;
        Occasion { step, iteration, attempt, time, communication_step }
    }

    /// The accepted exchange with `side`.
    pub fn accepted(&self, side: Side) -> Option<&Exchange> {
        self.exchanges.iter().find(|e| e.side == side && e.accepted)
    }
}

/// Why a communication step failed.
#[derive(Debug, thiserror::Error)]
pub enum CouplingError {
    /// A unit failed.
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    /// Iterations ran out.
    #[error(
        "step {step} at t = {time} s did not converge in {iterations} iterations: pressure residual {pressure:e} Pa \
         ({pressure_ratio:.3e} of what is allowed), displacement {displacement:.3e}, tolerance {tolerance:e}; \
         raise [coupling] iteration_limit, choose another acceleration, or shorten communication_step for compressible \
         water (lengthen it for added mass)"
    )]
    NotConverged {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken.
        iterations: u32,
        /// Pressure residual, Pa.
        pressure: f64,
        /// Pressure residual over what is allowed.
        pressure_ratio: f64,
        /// Displacement residual.
        displacement: f64,
        /// Tolerance ε.
        tolerance: f64,
    },
    /// Going on would be in vain.
    #[error(
        "step {step} at t = {time} s {why}, in iteration {iteration}; choose another [coupling] acceleration, or change \
         communication_step"
    )]
    Hopeless {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken.
        iteration: u32,
        /// What was recognised.
        why: Hopeless,
    },
    /// The guesses became such that a unit could not answer with numbers.
    #[error(
        "step {step} at t = {time} s diverges: in iteration {iteration} {cause}; choose another [coupling] acceleration, \
         or change communication_step"
    )]
    BlewUp {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken, from 2: in the first, what is not finite is the unit's own.
        iteration: u32,
        /// What was not finite.
        cause: ParticipantError,
    },
    /// The wet faces of the two units differ.
    #[error(
        "interface point {index} lies at ({dam_x}, {dam_y}) in the dam and at ({reservoir_x}, {reservoir_y}) in the \
         reservoir; both need the same points"
    )]
    Interface {
        /// Index of the point, from 0.
        index: usize,
        /// x in the dam, m.
        dam_x: f64,
        /// y in the dam, m.
        dam_y: f64,
        /// x in the reservoir, m.
        reservoir_x: f64,
        /// y in the reservoir, m.
        reservoir_y: f64,
    },
}

/// A step that failed, with what had happened in it so far.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct StepFailure {
    /// Exchanges up to the failure.
    pub report: Box<StepReport>,
    /// Why it failed.
    pub error: CouplingError,
}
