//! The interface to units: anything that takes part in a co-simulation.

mod description;
mod error;
mod function_unit;
mod in_process;
mod messages;
mod settings;

pub use cofferdam_unit::{Level, Messages};
pub use description::{Channel, ChannelShape, Description, Layout, check_finite};
pub use error::ParticipantError;
pub use function_unit::FunctionUnit;
pub use in_process::InProcess;
pub use messages::Message;
pub use settings::{AccelerationMeaning, ParameterValue};

use cofferdam_unit::at_places;
use std::time::Duration;

/// The step that a unit is asked to take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Occasion {
    /// Number of the communication step, from 1; 0 is initialisation.
    pub step: u64,
    /// Iteration of the communication step, from 1; 0 is initialisation.
    pub iteration: u32,
    /// Number of the attempt, from 1; each attempt has another step length.
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
/// **Call order**: [`initialise`](Self::initialise) once, or [`deserialise`](Self::deserialise), then [`save_state`](Self::save_state) and any number of
/// [`step`](Self::step), each after the first preceded by [`restore_state`](Self::restore_state); the next
/// `save_state` accepts the last step. Requests and answers are flat slices in the order of the description's
/// layouts. A participant keeps one saved state, which can be restored any number of times.
///
/// **Guarantees**: after restoring and stepping with the same inputs, every output is equal bit for bit; answers are
/// finite.
pub trait Participant: Send {
    /// Its description.
    fn description(&self) -> &Description;

    /// Whether its answers are known beforehand and do not depend on what it is asked.
    fn is_open_loop(&self) -> bool {
        false
    }

    /// Reads a variable that is not exchanged: fixed after initialisation, such as the hydrostatic pressure, or a field
    /// of the last step.
    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError>;

    /// The same of the values at these `places` of a variable, NaN beyond its last; by default all are read.
    fn read_at(&mut self, variable: &str, places: &[usize]) -> Result<Vec<f64>, ParticipantError> {
        Ok(at_places(&self.read(variable)?, places).collect())
    }

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

    /// Saves the state; it replaces the one saved before.
    fn save_state(&mut self) -> Result<(), ParticipantError>;

    /// Returns to the saved state.
    fn restore_state(&mut self) -> Result<(), ParticipantError>;

    /// The state at the end of the last step as bytes, for [`deserialise`](Self::deserialise); `None` where that is not
    /// offered, as by default.
    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        Ok(None)
    }

    /// Takes a state written by a unit made from the same scene, in this or another process, in the place of
    /// initialisation.
    ///
    /// **Errors**: it is not offered, as by default; the bytes are not a state of such a unit.
    fn deserialise(&mut self, _state: &[u8]) -> Result<(), ParticipantError> {
        Err(ParticipantError::NotSerialised { participant: self.description().name.clone() })
    }

    /// Time that the unit itself has spent in all calls so far, including saving and restoring states but not the
    /// communication; zero if it is negligible or not measured.
    fn busy(&self) -> Duration {
        Duration::ZERO
    }

    /// The messages of the unit since the last call; none by default.
    fn messages(&mut self) -> Vec<Message> {
        Vec::new()
    }
}
