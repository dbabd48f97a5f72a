//! Small analytic units that take the dam's and the reservoir's places.

use cofferdam_coupling::participant::{
    Channel, ChannelShape, Description, Layout, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::Interval;
use cofferdam_unit::{Capabilities, Fingerprint, StateError, WetFace, open, seal};
use serde::{Serialize, de::DeserializeOwned};

/// Communication step number `step` (from 1) of equal ones (s).
pub fn interval(step: u64, communication_step: f64) -> Interval {
    let time = (step - 1) as f64 * communication_step;
    Interval::new(step, time, communication_step)
}

/// What a step makes of the state: the occasion, the inputs, room for the outputs.
type Step<S> = Box<dyn FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send>;

/// A state as bytes, and back.
type Bytes<S> =
    (fn(Fingerprint, &S) -> Result<Vec<u8>, StateError>, fn(Fingerprint, &[u8]) -> Result<S, StateError>);

/// A unit that is a state and a function.
pub struct SmallUnit<S> {
    description: Description,
    /// Prefix and number of points of each.
    faces: Vec<(String, usize)>,
    /// The points, where they matter.
    points: Option<WetFace>,
    now: S,
    saved: S,
    /// Outputs at initialisation.
    start: Vec<f64>,
    step: Step<S>,
    /// How it gives its state as bytes, if it does.
    bytes: Option<Bytes<S>>,
}

impl<S: Clone> SmallUnit<S> {
    /// In the dam's place, with one wet face.
    pub fn dam(
        points: usize,
        state: S,
        start: Vec<f64>,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Self {
        Self::structure("dam", &[("", points)], state, start, step)
    }

    /// A structure: pressure and hydrostatic pressure at each face, then ground (2) in; displacement and acceleration at
    /// each face out.
    pub fn structure(
        name: &str,
        faces: &[(&str, usize)],
        state: S,
        start: Vec<f64>,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Self {
        let inputs = ["interface_pressure", "hydrostatic_pressure"];
        let outputs = ["interface_displacement", "interface_acceleration"];
        Self::new(name, faces, (&inputs, &outputs), state, start, Box::new(step))
    }

    /// In the reservoir's place.
    pub fn reservoir(
        points: usize,
        state: S,
        start: Vec<f64>,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Self {
        Self::fluid("reservoir", points, state, start, step)
    }

    /// A fluid: acceleration and ground (2) in; pressure out.
    pub fn fluid(
        name: &str,
        points: usize,
        state: S,
        start: Vec<f64>,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Self {
        let variables = (&["interface_acceleration"][..], &["interface_pressure"][..]);
        Self::new(name, &[("", points)], variables, state, start, Box::new(step))
    }

    /// The same, but for steps of one length only.
    pub fn of_one_length(mut self) -> Self {
        self.description.capabilities.variable_communication_step = false;
        self
    }

    /// The same, which does not know the ground.
    pub fn without_ground(mut self) -> Self {
        let channels = self.description.inputs.channels().map(|(channel, _)| channel.clone());
        let others = channels.filter(|channel| channel.name != "ground_acceleration");
        self.description.inputs = Layout::new(others.collect());
        self
    }

    /// The same, which gives its state as bytes.
    pub fn in_bytes(mut self) -> Self
    where
        S: Serialize + DeserializeOwned,
    {
        self.bytes = Some((seal, open));
        self
    }

    /// The same, with the points of `face` and the hydrostatic pressure of water (1000 kg/m³, 9.81 m/s²) there.
    pub fn at(mut self, face: &WetFace) -> Self {
        self.points = Some(face.clone());
        self
    }

    fn new(
        name: &str,
        faces: &[(&str, usize)],
        (inputs, outputs): (&[&str], &[&str]),
        state: S,
        start: Vec<f64>,
        step: Step<S>,
    ) -> Self {
        let channel = |name: String, size, shape| Channel {
            name,
            value_reference: 0,
            unit: String::new(),
            size,
            shape,
        };
        let wet = |names: &[&str]| -> Vec<Channel> {
            let at = |&(prefix, points): &(&str, usize)| {
                let of = |name: &&str| channel(format!("{prefix}{name}"), points, ChannelShape::WetFace);
                names.iter().map(of).collect::<Vec<_>>()
            };
            faces.iter().flat_map(at).collect()
        };
        let mut inputs = wet(inputs);
        inputs.push(channel("ground_acceleration".to_owned(), 2, ChannelShape::List));
        let faces: Vec<_> = faces.iter().map(|&(prefix, points)| (prefix.to_owned(), points)).collect();
        let description = Description {
            name: name.to_owned(),
            solver: "small unit".to_owned(),
            fingerprint: Fingerprint::of(name, &faces).expect("a number is hashed"),
            inputs: Layout::new(inputs),
            outputs: Layout::new(wet(outputs)),
            readable: Layout::default(),
            capabilities: Capabilities {
                variable_communication_step: true,
                directional_derivative: false,
                saved_state: true,
            },
        };
        Self { description, faces, points: None, now: state.clone(), saved: state, start, step, bytes: None }
    }
}

impl<S> SmallUnit<S> {
    fn failed(&self, cause: StateError) -> ParticipantError {
        ParticipantError::Unit { participant: self.description.name.clone(), cause: Box::new(cause) }
    }
}

impl<S: Clone + Send> Participant for SmallUnit<S> {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        if let Some(face) = &self.points {
            let of = |value: fn([f64; 2], f64) -> f64| {
                Ok(face.points().iter().map(|p| value(*p, face.depth())).collect())
            };
            match variable {
                "interface_x" => return of(|p, _| p[0]),
                "interface_y" => return of(|p, _| p[1]),
                "hydrostatic_pressure" => return of(|p, depth| 1000.0 * 9.81 * (depth - p[1])),
                _ => (),
            }
        }
        let of = |(prefix, points): &(String, usize)| match variable.strip_prefix(prefix.as_str())? {
            "interface_y" => Some((0..*points).map(|i| i as f64).collect()),
            "interface_x" | "hydrostatic_pressure" => Some(vec![0.0; *points]),
            _ => None,
        };
        let (participant, asked) = (self.description.name.clone(), variable.to_owned());
        let missing = ParticipantError::Missing { participant, variable: asked };
        self.faces.iter().find_map(of).ok_or(missing)
    }

    fn initialise(&mut self, _: f64, _: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        outputs.copy_from_slice(&self.start);
        self.save_state()
    }

    fn step(&mut self, at: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        (self.step)(&mut self.now, at, inputs, outputs);
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.saved = self.now.clone();
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.now = self.saved.clone();
        Ok(())
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let Some((seal, _)) = self.bytes else { return Ok(None) };
        seal(self.description.fingerprint, &self.now).map(Some).map_err(|cause| self.failed(cause))
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        let Some((_, open)) = self.bytes else {
            return Err(ParticipantError::NotSerialised { participant: self.description.name.clone() });
        };
        self.now = open(self.description.fingerprint, state).map_err(|cause| self.failed(cause))?;
        Ok(())
    }
}
