use super::WindowReport;
use crate::convergence::{IterationFailure, Tolerance};
use crate::mapping::MappingError;
use crate::participant::ParticipantError;
use cofferdam_unit::StateError;

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
        "{participant} cannot save its state, so its steps cannot be repeated; let it save and restore its state (a class: \
         `save` and `restore`), or set coupling.scheme to \"serial-explicit\" or \"parallel-explicit\", which diverge where \
         the second unit is heavy compared with the first"
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
        "step {step} at t = {time} s did not converge in {iterations} iterations: residual {residual:.3e} {unit} \
         ({relative_ratio:.3e} of what is allowed), change {change:.3e}, tolerance {tolerance}; \
         raise [coupling] iteration_limit, choose another acceleration, or shorten communication_step where the second \
         unit has a memory (lengthen it where it only adds mass)"
    )]
    NotConverged {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Number of iterations without those for measurements.
        iterations: u32,
        /// Norm of the residual.
        residual: f64,
        /// Its unit.
        unit: String,
        /// The residual over its limit.
        relative_ratio: f64,
        /// Relative change of the monitored quantity.
        change: f64,
        /// Tolerance ε.
        tolerance: Tolerance,
    },
    /// Further iterations would be useless.
    #[error(
        "step {step} at t = {time} s {}, in iteration {iteration}; {}", why.in_unit(unit), why.remedy()
    )]
    Futile {
        /// Number of the step.
        step: u64,
        /// Start of the step, s.
        time: f64,
        /// Iterations taken.
        iteration: u32,
        /// The reason.
        why: IterationFailure,
        /// Unit of its numbers.
        unit: String,
    },
    /// With diverging guesses the answer of a unit was not finite.
    #[error(
        "step {step} at t = {time} s diverges: in iteration {iteration} {cause}; choose another [coupling] acceleration, \
         or change communication_step"
    )]
    Diverged {
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
        "step {step} at t = {time} s: {participant} is frozen: its outputs have been bit-identical for {steps} \
         steps although its inputs changed, and it responded to changes before; look at its last outputs in the log"
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
        "{participant} does not return to its saved state: restored and called with the same inputs in step {step} from t = {time} s, it \
         returned {second:e} for `{variable}`[{index}], and {first:e} before; a saved state must hold everything that later \
         outputs depend on"
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
         [coupling] on_failure = \"halve\", or choose a unit without memory"
    )]
    FixedStep {
        /// Name of the participant.
        participant: String,
    },
    /// The response of the second unit is both included in the first and exchanged, or neither.
    #[error(
        "{participant} {} the response of {other} (`{variable}`), which the {} [coupling] scheme does not allow; \
         {}", if *included { "includes" } else { "does not include" }, if *included { "chosen" } else { "added-mass" },
        if *included { "choose the added-mass scheme" } else { "choose another scheme" }
    )]
    Included {
        /// Name of the first unit.
        participant: String,
        /// Name of the second unit.
        other: String,
        /// Variable of the first unit that tells it.
        variable: String,
        /// Whether the response is included.
        included: bool,
    },
    /// An implicit scheme with an iteration limit of 0.
    #[error(
        "the iteration limit is 0; allow an implicit scheme one iteration or more, or choose an explicit one"
    )]
    NoIteration,
    /// A change that no interface monitors is to converge.
    #[error(
        "the measure of a change needs a quantity, and no interface monitors one; set `monitored` of an interface to an output of \
         its first unit, or choose another measure"
    )]
    NotMonitored,
    /// The faces of the two units cannot be mapped.
    #[error(transparent)]
    Mapping(#[from] MappingError),
    /// The points of the two units differ and form no faces that could be mapped.
    #[error(
        "interface point {index} lies at ({}, {}) in the {} and at ({}, {}) in the {}, and they form no \
         lines that could be mapped; give both units the same points", first[0], first[1], units[0], second[0], second[1], units[1]
    )]
    Interface {
        /// Index of the point, from 0.
        index: usize,
        /// Names of the first unit and of the second.
        units: [String; 2],
        /// The point in the first unit (x, y), m.
        first: [f64; 2],
        /// The point in the second unit (x, y), m.
        second: [f64; 2],
    },
}

impl CouplingError {
    /// Whether the coupling failed, so that shorter steps may help.
    pub fn is_of_coupling(&self) -> bool {
        matches!(
            self,
            Self::NotConverged { .. }
                | Self::Futile { .. }
                | Self::Diverged { .. }
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
