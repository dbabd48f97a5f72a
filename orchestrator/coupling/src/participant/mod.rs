//! The interface to units: anything that takes part in a co-simulation.

mod description;
mod error;
mod function_unit;
mod in_process;
mod messages;
mod settings;

pub use cofferdam_unit::{Capabilities, Fingerprint, Level, Messages, StateError};
pub use description::{Channel, ChannelShape, Description, Layout, check_finite};
pub use error::ParticipantError;
pub use function_unit::FunctionUnit;
pub use in_process::InProcess;
pub use messages::Message;
pub use settings::{AccelerationMeaning, ParameterValue, VariableNames};

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

/// A unit that takes part in a co-simulation, wherever it runs: y = f(u) over a communication step.
///
/// [`FunctionUnit`] is one made of a state and a function; implement the trait where a unit has arrays, files or a process of its
/// own. (A solver that is to become an FMU implements `CoSimulation` of `cofferdam-unit`, and [`InProcess`] makes it a participant.)
///
/// **Call order**: [`initialise`](Self::initialise) once, or [`deserialise`](Self::deserialise); then for each window of
/// communication steps [`save_state`](Self::save_state), and for each iteration one [`step`](Self::step) for every step of the
/// window in order, preceded by [`restore_state`](Self::restore_state) except in the first iteration. The next `save_state`
/// accepts the last steps. A participant keeps one saved state, which may be restored any number of times, also after a step
/// that failed.
///
/// **Requests and answers** are flat slices in the order of the description's layouts. Inputs are values at the end of the step;
/// within it, a unit may take them as linear in time. At initialisation the coupled inputs are 0 except for constant parts, and
/// the coupled outputs are not passed on. A step writes every output.
///
/// **Guarantees**: after restoring and stepping with the same inputs, every output is equal bit for bit; outputs are finite. A
/// scheme checks both.
///
/// **Errors**: of a step in a window's first iteration an error ends the run. Later it means that the guess was unusable: where the
/// settings allow it, the window is repeated in shorter steps. A unit whose description says that it has no saved state is refused
/// by implicit schemes; explicit ones also call `save_state`, which then does nothing.
///
/// ```
/// use cofferdam_coupling::participant::{Channel, Description, Occasion, Participant, ParticipantError};
///
/// /// Three tanks in a row, each of which drains into the next: input the inflow, outputs the levels and the outflow.
/// struct Tanks {
///     description: Description,
///     levels: [f64; 3],
///     saved: [f64; 3],
/// }
///
/// impl Participant for Tanks {
///     fn description(&self) -> &Description {
///         &self.description
///     }
///
///     fn initialise(&mut self, _: f64, _: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
///         outputs.copy_from_slice(&[&self.levels[..], &[self.levels[2]]].concat());
///         Ok(())
///     }
///
///     fn step(&mut self, occasion: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
///         let mut inflow = inputs[0];
///         for level in &mut self.levels {
///             let outflow = *level;
///             *level += occasion.communication_step * (inflow - outflow);
///             inflow = outflow;
///         }
///         self.initialise(0.0, inputs, outputs)
///     }
///
///     fn save_state(&mut self) -> Result<(), ParticipantError> {
///         self.saved = self.levels;
///         Ok(())
///     }
///
///     fn restore_state(&mut self) -> Result<(), ParticipantError> {
///         self.levels = self.saved;
///         Ok(())
///     }
/// }
///
/// let inputs = vec![Channel::new("inflow", "m3/s", 1)];
/// let outputs = vec![Channel::new("level", "m", 3), Channel::new("outflow", "m3/s", 1)];
/// let description = Description::new("tanks", inputs, outputs)?;
/// let mut tanks = Tanks { description, levels: [1.0; 3], saved: [1.0; 3] };
/// let (occasion, mut first, mut second) =
///     (Occasion { step: 1, iteration: 1, attempt: 1, time: 0.0, communication_step: 0.5 }, [0.0; 4], [0.0; 4]);
/// tanks.initialise(0.0, &[0.0], &mut first)?;
/// tanks.save_state()?;
/// tanks.step(&occasion, &[2.0], &mut first)?;
/// tanks.restore_state()?;
/// tanks.step(&occasion, &[2.0], &mut second)?;
/// assert_eq!(first, [1.5, 1.0, 1.0, 1.0]);
/// assert_eq!(first, second);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Participant: Send {
    /// Its description.
    fn description(&self) -> &Description;

    /// Whether its answers are known beforehand and do not depend on what it is asked.
    fn is_open_loop(&self) -> bool {
        false
    }

    /// Reads a variable that is not exchanged: one that is fixed after initialisation, or a field of the last step. By default
    /// there is none.
    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        Err(self.description().missing(variable))
    }

    /// The same of the values at these `places` of a variable, NaN beyond its last; by default all are read.
    fn read_at(&mut self, variable: &str, places: &[usize]) -> Result<Vec<f64>, ParticipantError> {
        Ok(at_places(&self.read(variable)?, places).collect())
    }

    /// Initialises the unit at `start_time` (s) and writes the first outputs.
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

    /// Takes a state written by a unit made from the same scene, in this or another process, in place of
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
