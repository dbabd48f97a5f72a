use super::WindowReport;
use crate::convergence::{Hopeless, Tolerance};
use crate::mapping::MappingError;
use crate::participant::ParticipantError;
use interface::StateError;

/// Why a communication step failed.
#[derive(Debug, thiserror::Error)]
pub enum CouplingError {
    /// A unit failed.
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    /// The interfaces do not connect the units.
    #[error("the units cannot be coupled: {cause}")]
    Graph {
        /// What is wrong.
        cause: String,
    },
    /// An implicit scheme with a unit whose steps cannot be repeated.
    #[error(
        "{participant} cannot save its state, so its steps cannot be repeated; let it save and restore its state (a class: `save` and \
         `restore`), or set coupling.scheme to \"serial-explicit\" or \"parallel-explicit\", which diverge where the water is heavy beside \
         the dam"
    )]
    NoState {
        /// Name of the participant.
        participant: String,
    },
    /// What the scheme is made from cannot be hashed.
    #[error(transparent)]
    Configuration(#[from] Box<StateError>),
    /// The units cannot step at the same time.
    #[error("no thread can be made: {cause}; allow more (`ulimit -u`), or choose a serial [coupling] scheme")]
    Thread {
        /// The error of the system.
        cause: std::io::Error,
    },
    /// The iteration limit was reached.
    #[error(
        "step {step} at t = {time} s did not converge in {iterations} iterations: pressure residual {pressure:e} Pa \
         ({pressure_ratio:.3e} of what is allowed), displacement {displacement:.3e}, tolerance {tolerance}; \
         raise [coupling] iteration_limit, choose another acceleration, or shorten communication_step for compressible \
         water (lengthen it for added mass)"
    )]
    NotConverged {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Number of iterations without those for measurements.
        iterations: u32,
        /// Pressure residual, Pa.
        pressure: f64,
        /// Pressure residual over its limit.
        pressure_ratio: f64,
        /// Displacement residual.
        displacement: f64,
        /// Tolerance ε.
        tolerance: Tolerance,
    },
    /// Further iterations would be useless.
    #[error(
        "step {step} at t = {time} s {why}, in iteration {iteration}; {}", why.remedy()
    )]
    Hopeless {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken.
        iteration: u32,
        /// The reason.
        why: Hopeless,
    },
    /// With diverging guesses the answer of a unit was not finite.
    #[error(
        "step {step} at t = {time} s diverges: in iteration {iteration} {cause}; choose another [coupling] acceleration, \
         or change communication_step"
    )]
    BlewUp {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken, from 2: in the first one the unit itself is the cause.
        iteration: u32,
        /// The value that was not finite.
        cause: ParticipantError,
    },
    /// A unit failed in an iteration, although it had taken the same step in an earlier one.
    #[error(
        "step {step} at t = {time} s: in iteration {iteration} {cause}; it took the step before with another guess, so the \
         guesses may diverge: choose another [coupling] acceleration, or change communication_step"
    )]
    GuessFailed {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken.
        iteration: u32,
        /// What the unit said.
        cause: ParticipantError,
    },
    /// A unit has frozen.
    #[error(
        "step {step} at t = {time} s: {participant} is frozen: its answers have been the same in all bits for {steps} \
         steps, though what it was given changed and it has answered to changes before; look at its last answers in the log"
    )]
    Frozen {
        /// Name of the participant.
        participant: String,
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Steps with the same answers.
        steps: u32,
    },
    /// After its state was restored, a unit gives another answer.
    #[error(
        "{participant} does not return to its saved state: restored and asked the same in step {step} from t = {time} s, it \
         answered {second:e} for `{variable}`[{index}] and {first:e} before; a saved state must hold all that later \
         answers depend on"
    )]
    StateNotRestored {
        /// Name of the participant.
        participant: String,
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// First variable that differs.
        variable: String,
        /// Index of the value, from 0.
        index: usize,
        /// The first answer.
        first: f64,
        /// The second.
        second: f64,
    },
    /// A unit that takes steps of one length only was to take another.
    #[error(
        "{participant} takes communication steps of one length only; leave out [time.adaptive] and \
         [coupling] on_failure = \"halve\", or choose water without memory"
    )]
    FixedStep {
        /// Name of the participant.
        participant: String,
    },
    /// The mass of the water is both in the dam's mass matrix and exchanged, or neither.
    #[error(
        "{participant} {} the water's added mass in its mass matrix, which the {} [coupling] scheme does not allow; \
         {}", if *included { "has" } else { "does not have" }, if *included { "chosen" } else { "added-mass" },
        if *included { "choose the added-mass scheme" } else { "choose another scheme" }
    )]
    AddedMass {
        /// Name of the participant.
        participant: String,
        /// Whether the mass is there.
        included: bool,
    },
    /// An implicit scheme with an iteration limit of 0.
    #[error(
        "the iteration limit is 0; allow an implicit scheme one iteration or more, or choose an explicit one"
    )]
    NoIteration,
    /// The wet faces of the two units cannot be mapped.
    #[error(transparent)]
    Mapping(#[from] MappingError),
    /// The points of the two units differ and form no wet faces that could be mapped.
    #[error(
        "interface point {index} lies at ({dam_x}, {dam_y}) in the dam and at ({reservoir_x}, {reservoir_y}) in the \
         reservoir, and they make no wet faces from the heel up; both need the same points"
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

impl CouplingError {
    /// Whether the coupling failed, so that shorter steps may help.
    pub fn is_of_coupling(&self) -> bool {
        matches!(
            self,
            Self::NotConverged { .. }
                | Self::Hopeless { .. }
                | Self::BlewUp { .. }
                | Self::GuessFailed { .. }
        )
    }
}

/// A failed window, with its report so far.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct StepFailure {
    /// Exchanges up to the failure.
    pub report: Box<WindowReport>,
    /// The cause.
    pub error: CouplingError,
}
