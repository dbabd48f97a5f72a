//! The door for units: anything that takes part in a co-simulation.

mod empty_reservoir;
mod in_process;
mod messages;
mod prescribed;
mod shared_memory;

pub use empty_reservoir::EmptyReservoir;
pub use in_process::InProcess;
pub use interface::{Level, Messages};
pub use messages::Message;
pub use prescribed::Prescribed;
pub use shared_memory::{Deadlines, SharedMemory, Starting, Task, Word, host, layout_hash};

use crate::transport::TransportError;
use interface::{Capabilities, Fingerprint, Shape, StateError, Variable, WetFace};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// One variable as it travels: its place in a request or an answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Channel {
    /// Name of the variable.
    pub name: String,
    /// Value reference of the variable.
    pub value_reference: u32,
    /// SI unit.
    pub unit: String,
    /// Number of values.
    pub size: usize,
    /// The variable is an array by nature, even if `size` is 1.
    pub array: bool,
}

/// The variables of a request or an answer, one after another.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Layout {
    channels: Vec<Channel>,
}

impl Layout {
    /// A layout of `channels`, in this order.
    pub fn new(channels: Vec<Channel>) -> Self {
        Self { channels }
    }

    /// Total number of values.
    pub fn size(&self) -> usize {
        self.channels.iter().map(|c| c.size).sum()
    }

    /// Number of values of the longest variable.
    pub fn longest(&self) -> usize {
        self.channels.iter().map(|c| c.size).max().unwrap_or(0)
    }

    /// The channels, each with the range of its values.
    pub fn channels(&self) -> impl Iterator<Item = (&Channel, std::ops::Range<usize>)> {
        self.channels.iter().scan(0, |start, channel| {
            let range = *start..*start + channel.size;
            *start = range.end;
            Some((channel, range))
        })
    }

    /// The range of the variable `name`.
    pub fn range(&self, name: &str) -> Option<std::ops::Range<usize>> {
        self.channels().find(|(channel, _)| channel.name == name).map(|(_, range)| range)
    }

    /// Name and index of the value at `position`.
    pub fn locate(&self, position: usize) -> Option<(&str, usize)> {
        self.channels()
            .find(|(_, range)| range.contains(&position))
            .map(|(channel, range)| (channel.name.as_str(), position - range.start))
    }
}

/// What a participant is and exchanges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Name in logs and messages: `dam`, `reservoir`.
    pub name: String,
    /// What stands behind the name: solver and version.
    pub solver: String,
    /// Hash of everything it was made from.
    pub fingerprint: Fingerprint,
    /// Layout of a request.
    pub inputs: Layout,
    /// Layout of an answer.
    pub outputs: Layout,
    /// The variables that are not exchanged: those that are fixed after initialisation, and fields.
    pub readable: Layout,
    /// What it can do beyond plain stepping.
    pub capabilities: Capabilities,
}

impl Description {
    /// Of what stands in for a unit: takes steps of any length, and exchanges these variables for `face`.
    ///
    /// **Errors**: the face cannot be hashed.
    fn of_stand_in(
        name: &str,
        kind: &str,
        face: &WetFace,
        [inputs, outputs, readable]: [&[Variable]; 3],
    ) -> Result<Self, StateError> {
        let channel = |v: &Variable| Channel {
            name: v.name.to_owned(),
            value_reference: v.value_reference,
            unit: v.unit.to_owned(),
            size: if v.shape == Shape::Plane { 2 } else { face.len() },
            array: true,
        };
        let layout = |variables: &[Variable]| Layout::new(variables.iter().map(channel).collect());
        Ok(Self {
            name: name.to_owned(),
            solver: format!("{kind} {}", env!("CARGO_PKG_VERSION")),
            fingerprint: Fingerprint::of(kind, face)?,
            inputs: layout(inputs),
            outputs: layout(outputs),
            readable: layout(readable),
            capabilities: Capabilities { variable_communication_step: true, directional_derivative: false },
        })
    }

    /// That the unit has no such `variable` to be read.
    fn missing(&self, variable: &str) -> ParticipantError {
        ParticipantError::Missing { participant: self.name.clone(), variable: variable.to_owned() }
    }
}

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

/// What went wrong in a participant.
#[derive(Debug, thiserror::Error)]
pub enum ParticipantError {
    /// The unit refused or failed.
    #[error("{participant}: {cause}")]
    Unit {
        /// Name of the participant.
        participant: String,
        /// What the unit said.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The participant has no such variable.
    #[error("{participant} has no variable `{variable}`; it cannot take part in this coupling")]
    Missing {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
    },
    /// A coupled variable has another number of values than its counterpart.
    #[error(
        "{participant}: `{variable}` has {found} values, {expected} are needed; both units need the same points"
    )]
    Size {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
        /// Number of values needed.
        expected: usize,
        /// Number of values found.
        found: usize,
    },
    /// The unit's process said what is wrong.
    #[error("{text}")]
    Reported {
        /// What it said; names the unit.
        text: String,
    },
    /// The unit's process cannot be started.
    #[error("{participant}: its process cannot be started: {cause}; go on without by --transport in-process")]
    NotStarted {
        /// Name of the participant.
        participant: String,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The unit's process ended.
    #[error("{participant}: its process {how} {when}")]
    Ended {
        /// Name of the participant.
        participant: String,
        /// How it ended.
        how: String,
        /// Step and iteration, or what was being done.
        when: String,
    },
    /// The user did not want to wait any longer.
    #[error("interrupted while the units were made")]
    Interrupted,
    /// The unit does not answer.
    #[error(
        "{participant}: no answer for {seconds} s {when}, so its process was killed; if it needs longer, raise \
         --deadline (making and initialising may take sixty times as long)"
    )]
    Hung {
        /// Name of the participant.
        participant: String,
        /// How long it was waited for, s.
        seconds: f64,
        /// Step and iteration, or what was being done.
        when: String,
    },
    /// The unit's description cannot be read.
    #[error("{participant}: its description cannot be read: {cause}; run it from the same build")]
    Unintelligible {
        /// Name of the participant.
        participant: String,
        /// What is wrong with it.
        cause: String,
    },
    /// A request holds another number of values than it should.
    #[error(
        "{participant}: a request has {found} values, {expected} are the inputs; run both from the same build"
    )]
    Length {
        /// Name of the participant.
        participant: String,
        /// Number of values of the inputs.
        expected: usize,
        /// Number of values that came.
        found: usize,
    },
    /// A request asks for something unknown.
    #[error("{participant}: {command} is no command; run both from the same build")]
    Command {
        /// Name of the participant.
        participant: String,
        /// Number of the command.
        command: u32,
    },
    /// The way between two processes.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// An answer holds a value that is not finite.
    #[error(
        "{participant}: `{variable}`[{index}] became {value} in the step to t = {time} s; \
         look at the last exchanges in the log, and at the time step's safety factor and the mesh"
    )]
    NonFinite {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
        /// Index of the value, from 0.
        index: usize,
        /// The value.
        value: f64,
        /// End of the step, s.
        time: f64,
    },
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

/// Checks that an answer is finite.
pub(crate) fn check_finite(
    description: &Description,
    outputs: &[f64],
    time: f64,
) -> Result<(), ParticipantError> {
    let Some(position) = outputs.iter().position(|v| !v.is_finite()) else { return Ok(()) };
    let (variable, index) = description.outputs.locate(position).unwrap_or(("?", position));
    Err(ParticipantError::NonFinite {
        participant: description.name.clone(),
        variable: variable.to_owned(),
        index,
        value: outputs[position],
        time,
    })
}
