//! The door for units: anything that takes part in a co-simulation.

mod description;
mod empty_reservoir;
mod error;
mod in_process;
mod messages;
mod prescribed;
mod shared_memory;

pub use description::{Channel, ChannelShape, Description, Layout};
pub use empty_reservoir::EmptyReservoir;
pub use error::ParticipantError;
pub(crate) use error::check_finite;
pub use in_process::InProcess;
pub use interface::{Level, Messages};
pub use messages::Message;
pub use prescribed::Prescribed;
pub use shared_memory::{Deadlines, SharedMemory, Starting, Task, Word, host, layout_hash};

use std::time::Duration;

/// Which of its steps a unit is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Occasion {
    /// Number of the communication step, from 1; 0 is initialisation.
    pub step: u64,
    /// Iteration of the communication step, from 1; 0 is initialisation.
    pub iteration: u32,
    /// How often the step was begun anew with another length, from 1.
    pub attempt: u32,
    /// Start of the step, s.
    pub time: f64,
    /// Length H of the step, s; 0 at initialisation.
    pub communication_step: f64,
}

impl Occasion {
    /// Initialisation at `time` (s).
    pub fn initialisation(time: f64) -> Self {
        Self { attempt: 1, time, ..Self::default() }
    }

    /// End of the step, s.
    pub fn end(&self) -> f64 {
        self.time + self.communication_step
    }
}

impl std::fmt::Display for Occasion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { step, iteration, time, .. } = self;
        match step {
            0 => f.write_str("at initialisation"),
            _ => write!(f, "in step {step} from t = {time} s, iteration {iteration}"),
        }
    }
}

/// A unit that takes part in a co-simulation, wherever it runs.
///
/// **Call order**: [`initialise`](Self::initialise) once, then
/// [`save_state`](Self::save_state) and any number of [`step`](Self::step), each after the
/// first preceded by [`restore_state`](Self::restore_state); the next `save_state` accepts
/// the last step. Requests and answers are flat slices in the order of the description's
/// layouts. A participant keeps one saved state; restoring does not use it up.
///
/// **Guarantees**: restored and stepped with the same inputs, every output is equal bit for
/// bit; an answer is finite.
pub trait Participant: Send {
    /// What it is and exchanges.
    fn description(&self) -> &Description;

    /// Reads a variable that is not exchanged: fixed after initialisation, such as the hydrostatic pressure, or a field
    /// of the last step.
    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError>;

    /// Ends initialisation at `start_time` (s) and writes the first outputs.
    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError>;

    /// Takes the step of `occasion`.
    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError>;

    /// Saves the state, in the place of the one saved before.
    fn save_state(&mut self) -> Result<(), ParticipantError>;

    /// Returns to the saved state.
    fn restore_state(&mut self) -> Result<(), ParticipantError>;

    /// Time that the unit itself has spent in all calls so far, states included, the way to it not; zero if it
    /// is next to nothing or not measured.
    fn busy(&self) -> Duration {
        Duration::ZERO
    }

    /// What the unit has said since it was last asked; most have nothing to say.
    fn messages(&mut self) -> Vec<Message> {
        Vec::new()
    }
}
