use super::ParticipantError;
use cofferdam_unit::{Capabilities, Fingerprint, Shape, StateError, Variable, WetFace};
use serde::{Deserialize, Serialize};

/// One variable of a request or an answer.
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
    /// The kind of the variable.
    pub shape: ChannelShape,
}

impl Channel {
    /// The variable `name` of `size` values in `unit`: a scalar, or a list where there are more than one. Its value reference,
    /// which only FMUs use, is 0.
    pub fn new(name: &str, unit: &str, size: usize) -> Self {
        let shape = if size == 1 { ChannelShape::Scalar } else { ChannelShape::List };
        Self { name: name.to_owned(), value_reference: 0, unit: unit.to_owned(), size, shape }
    }
}

/// The kind of variable that a [`Channel`] carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChannelShape {
    /// One value.
    Scalar,
    /// Two values: along x, along y.
    Plane,
    /// One value a point of the wet face.
    WetFace,
    /// One value each of other things, such as cracks or nodes; any array of a log, which does not name them.
    List,
}

impl ChannelShape {
    /// Whether the variable is an array, even if it has a single value.
    pub fn is_array(self) -> bool {
        self != Self::Scalar
    }
}

impl From<Shape> for ChannelShape {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Scalar => Self::Scalar,
            Shape::Plane => Self::Plane,
            Shape::InterfacePoints | Shape::TailwaterPoints => Self::WetFace,
            Shape::Modes
            | Shape::Cracks
            | Shape::StressPoints
            | Shape::Nodes
            | Shape::Triangles
            | Shape::Contacts => Self::List,
        }
    }
}

/// The variables of a request or an answer, one after another.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Layout {
    channels: Vec<Channel>,
}

impl Layout {
    /// The first variable that another layout does not hold in the same place, size and unit, or that only the other holds; whether
    /// a list lies over the wet face does not count.
    pub fn unlike(&self, other: &Self) -> Option<String> {
        let of = |layout: &Self| -> Vec<_> {
            layout.channels().map(|(c, range)| (c.name.clone(), c.unit.clone(), range)).collect()
        };
        let (mine, others) = (of(self), of(other));
        type Channels = [(String, String, std::ops::Range<usize>)];
        let missing = |from: &Channels, to: &Channels| {
            from.iter().find(|channel| !to.contains(*channel)).map(|(name, ..)| name.clone())
        };
        missing(&mine, &others).or_else(|| missing(&others, &mine))
    }

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

    /// Whether `other` has the same variables at the same places. Lists count like any other array: a log does not
    /// distinguish them.
    pub fn agrees_with(&self, other: &Self) -> bool {
        let seen = |channel: &Channel| {
            let Channel { name, value_reference, unit, size, shape } = channel;
            (name.clone(), *value_reference, unit.clone(), *size, shape.is_array())
        };
        self.channels.iter().map(seen).eq(other.channels.iter().map(seen))
    }

    /// Name and index of the value at `position`.
    pub fn locate(&self, position: usize) -> Option<(&str, usize)> {
        self.channels()
            .find(|(_, range)| range.contains(&position))
            .map(|(channel, range)| (channel.name.as_str(), position - range.start))
    }
}

/// Description of a participant and of its variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Name in logs and messages: `dam`, `reservoir`.
    pub name: String,
    /// Solver and version.
    pub solver: String,
    /// Hash of everything that the unit was made from.
    pub fingerprint: Fingerprint,
    /// Layout of a request.
    pub inputs: Layout,
    /// Layout of an answer.
    pub outputs: Layout,
    /// The variables that are not exchanged: those that are fixed after initialisation, and fields.
    pub readable: Layout,
    /// Optional capabilities.
    pub capabilities: Capabilities,
}

impl Description {
    /// The description of a unit that saves its state and takes steps of any length.
    ///
    /// Its fingerprint, by which a resumed run recognises its units, is made from these arguments; set
    /// [`fingerprint`](Self::fingerprint) where the unit depends on more.
    ///
    /// **Errors**: they cannot be hashed.
    pub fn new(name: &str, inputs: Vec<Channel>, outputs: Vec<Channel>) -> Result<Self, StateError> {
        Ok(Self {
            name: name.to_owned(),
            solver: name.to_owned(),
            fingerprint: Fingerprint::of(name, &(&inputs, &outputs))?,
            inputs: Layout::new(inputs),
            outputs: Layout::new(outputs),
            readable: Layout::default(),
            capabilities: Capabilities {
                variable_communication_step: true,
                directional_derivative: false,
                saved_state: true,
            },
        })
    }

    /// The description of a stand-in for a unit, which takes steps of any length and exchanges these variables on
    /// `face`.
    ///
    /// **Errors**: the face cannot be hashed.
    pub fn of_stand_in(
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
            shape: v.shape.into(),
        };
        let layout = |variables: &[Variable]| Layout::new(variables.iter().map(channel).collect());
        Ok(Self {
            name: name.to_owned(),
            solver: format!("{kind} {}", env!("CARGO_PKG_VERSION")),
            fingerprint: Fingerprint::of(kind, face)?,
            inputs: layout(inputs),
            outputs: layout(outputs),
            readable: layout(readable),
            capabilities: Capabilities {
                variable_communication_step: true,
                directional_derivative: false,
                saved_state: true,
            },
        })
    }

    /// Value reference and size of a variable that is not exchanged.
    ///
    /// **Errors**: [`ParticipantError::Missing`], also for an exchanged one.
    pub fn find_readable(&self, name: &str) -> Result<(u32, usize), ParticipantError> {
        let mut channels = self.readable.channels();
        let found = channels.find(|(channel, _)| channel.name == name);
        found.map(|(c, range)| (c.value_reference, range.len())).ok_or_else(|| self.missing(name))
    }

    /// The error that bytes are no state of the unit, or that it has none as bytes.
    pub fn no_state(&self, cause: StateError) -> ParticipantError {
        ParticipantError::Unit { participant: self.name.clone(), cause: Box::new(cause) }
    }

    /// The error that the unit has no readable `variable`.
    pub fn missing(&self, variable: &str) -> ParticipantError {
        ParticipantError::Missing { participant: self.name.clone(), variable: variable.to_owned() }
    }
}

/// Checks that an answer is finite.
pub fn check_finite(description: &Description, outputs: &[f64], time: f64) -> Result<(), ParticipantError> {
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
