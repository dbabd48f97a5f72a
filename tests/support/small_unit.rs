//! Small analytic units that take the dam's and the reservoir's places.

use interface::{Capabilities, Fingerprint};
use orchestrator::participant::{
    Channel, ChannelShape, Description, Layout, Occasion, Participant, ParticipantError,
};
use orchestrator::scheme::Interval;

/// Communication step number `step` (from 1) of equal ones (s), over ground at rest.
pub fn interval(step: u64, communication_step: f64) -> Interval {
    let time = (step - 1) as f64 * communication_step;
    Interval { step, time, communication_step, ground_acceleration: [0.0; 2] }
}

/// Names and numbers of values of variables.
type Sizes<'a> = &'a [(&'a str, usize)];

/// What a step makes of the state: the occasion, the inputs, room for the outputs.
type Step<S> = Box<dyn FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send>;

/// A unit that is a state and a function.
pub struct SmallUnit<S> {
    description: Description,
    points: usize,
    now: S,
    saved: S,
    /// Outputs at initialisation.
    start: Vec<f64>,
    step: Step<S>,
}

impl<S: Clone> SmallUnit<S> {
    /// In the dam's place: pressure, hydrostatic pressure and ground (2) in; displacement and acceleration out.
    pub fn dam(
        points: usize,
        state: S,
        start: Vec<f64>,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Self {
        let inputs =
            [("interface_pressure", points), ("hydrostatic_pressure", points), ("ground_acceleration", 2)];
        let outputs = [("interface_displacement", points), ("interface_acceleration", points)];
        Self::new("dam", points, (&inputs, &outputs), state, start, Box::new(step))
    }

    /// In the reservoir's place: acceleration and ground (2) in; pressure out.
    pub fn reservoir(
        points: usize,
        state: S,
        start: Vec<f64>,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Self {
        let inputs = [("interface_acceleration", points), ("ground_acceleration", 2)];
        let outputs = [("interface_pressure", points)];
        Self::new("reservoir", points, (&inputs, &outputs), state, start, Box::new(step))
    }

    /// The same, but for steps of one length only.
    pub fn of_one_length(mut self) -> Self {
        self.description.capabilities.variable_communication_step = false;
        self
    }

    fn new(
        name: &str,
        points: usize,
        (inputs, outputs): (Sizes<'_>, Sizes<'_>),
        state: S,
        start: Vec<f64>,
        step: Step<S>,
    ) -> Self {
        let layout = |variables: Sizes<'_>| {
            let channel = |(name, size): &(&str, usize)| Channel {
                name: (*name).to_owned(),
                value_reference: 0,
                unit: String::new(),
                size: *size,
                shape: match name.strip_prefix("interface_") {
                    Some(_) => ChannelShape::WetFace,
                    None => ChannelShape::List,
                },
            };
            Layout::new(variables.iter().map(channel).collect())
        };
        let description = Description {
            name: name.to_owned(),
            solver: "small unit".to_owned(),
            fingerprint: Fingerprint::of(name, &points).expect("a number is hashed"),
            inputs: layout(inputs),
            outputs: layout(outputs),
            readable: Layout::default(),
            capabilities: Capabilities { variable_communication_step: true, directional_derivative: false },
        };
        Self { description, points, now: state.clone(), saved: state, start, step }
    }
}

impl<S: Clone + Send> Participant for SmallUnit<S> {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        Ok(match variable {
            "interface_y" => (0..self.points).map(|i| i as f64).collect(),
            _ => vec![0.0; self.points],
        })
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
}
