use super::{Channel, Description, Occasion, Participant, ParticipantError, check_finite};
use cofferdam_unit::{Fingerprint, StateError, open, seal};
use serde::{Serialize, de::DeserializeOwned};

/// A unit made of a state and a function, for examples, tests and small models.
///
/// The function receives the state, the step, and the inputs at the step's end; it advances the state and writes the outputs.
/// At initialisation the step has length 0. Only the state is saved and restored: the function must not keep anything that
/// changes in what it captures.
///
/// ```
/// use cofferdam_coupling::participant::{FunctionUnit, Occasion, Participant};
///
/// // A tank: the level rises by the inflow of a step.
/// let mut tank = FunctionUnit::new("tank", &[("inflow", "m3/s")], &[("level", "m")], 1.0, |level: &mut f64, step, q, y| {
///     *level += step.communication_step * q[0];
///     y[0] = *level;
/// })?;
/// let mut level = [0.0];
/// tank.initialise(0.0, &[0.0], &mut level)?;
/// tank.step(&Occasion { step: 1, communication_step: 0.5, ..Occasion::default() }, &[2.0], &mut level)?;
/// assert_eq!(level, [2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FunctionUnit<S> {
    description: Description,
    now: S,
    saved: S,
    step: Step<S>,
}

/// Takes a step: state, occasion, inputs, outputs.
type Step<S> = Box<dyn FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send>;

impl<S: Clone + Serialize> FunctionUnit<S> {
    /// The unit `name` with scalar `inputs` and `outputs`, each a name and an SI unit, from this initial `state`.
    ///
    /// **Errors**: the state cannot be hashed.
    pub fn new(
        name: &str,
        inputs: &[(&str, &str)],
        outputs: &[(&str, &str)],
        state: S,
        step: impl FnMut(&mut S, &Occasion, &[f64], &mut [f64]) + Send + 'static,
    ) -> Result<Self, StateError> {
        let channels = |variables: &[(&str, &str)]| {
            variables.iter().map(|(name, unit)| Channel::new(name, unit, 1)).collect()
        };
        let description = Description {
            solver: format!("function {name}"),
            fingerprint: Fingerprint::of(name, &(inputs, outputs, &state))?,
            ..Description::new(name, channels(inputs), channels(outputs))?
        };
        Ok(Self { description, saved: state.clone(), now: state, step: Box::new(step) })
    }
}

impl<S: Clone + Send + Serialize + DeserializeOwned> Participant for FunctionUnit<S> {
    fn description(&self) -> &Description {
        &self.description
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.step(&Occasion::initialisation(start_time), inputs, outputs)
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        (self.step)(&mut self.now, occasion, inputs, outputs);
        check_finite(&self.description, outputs, occasion.end())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.saved.clone_from(&self.now);
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.now.clone_from(&self.saved);
        Ok(())
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let state = seal(self.description.fingerprint, &self.now);
        state.map(Some).map_err(|cause| self.description.no_state(cause))
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        self.now =
            open(self.description.fingerprint, state).map_err(|cause| self.description.no_state(cause))?;
        Ok(())
    }
}
