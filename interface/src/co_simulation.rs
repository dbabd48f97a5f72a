use crate::{Fingerprint, StateError, Variable};
use serde::{Deserialize, Serialize};

/// Stage in the life of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Constructed, not yet initialised.
    Instantiated,
    /// Initialised; steps may be taken.
    Stepping,
}

/// What a unit can do in addition to stepping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capabilities {
    /// The length of a communication step may differ from step to step.
    pub variable_communication_step: bool,
    /// [`CoSimulation::directional_derivative`] is offered.
    pub directional_derivative: bool,
    /// States can be saved and restored, so that a step can be repeated. A description without this key is of a unit that
    /// can.
    #[serde(default = "yes")]
    pub saved_state: bool,
}

fn yes() -> bool {
    true
}

/// A call that breaks the contract, or data that the unit cannot accept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CallError {
    /// No such variable in this unit.
    #[error("{unit}: no variable has value reference {value_reference}; see the unit's modelDescription.xml")]
    UnknownVariable {
        /// Unit that was called.
        unit: &'static str,
        /// Requested value reference.
        value_reference: u32,
    },
    /// The variable is not an input.
    #[error("{unit}: `{variable}` cannot be set; it is an output, or fixed when the unit is made")]
    NotSettable {
        /// Unit that was called.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
    },
    /// The unit has no value for the variable.
    #[error(
        "{unit}: `{variable}` has no value; the unit's list of variables and what it outputs differ, which is a mistake of the program"
    )]
    NoValue {
        /// Unit that was called.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
    },
    /// Wrong number of values.
    #[error("{unit}: `{variable}` has {expected} values, {found} were given")]
    Length {
        /// Unit that was called.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
        /// Number of values of the variable.
        expected: usize,
        /// Number of values given.
        found: usize,
    },
    /// A value is NaN or infinite.
    #[error(
        "{unit}: `{variable}`[{index}] is {value} at t = {time} s; find the first unit whose output is not finite in the log"
    )]
    NonFinite {
        /// Unit that saw the value.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
        /// Index of the value, from 0.
        index: usize,
        /// The value.
        value: f64,
        /// Time of the step, s.
        time: f64,
    },
    /// A call at the wrong stage.
    #[error(
        "{unit}: `{call}` is not allowed when {stage:?}; the order is set, initialise, then set, step, get"
    )]
    Order {
        /// Unit that was called.
        unit: &'static str,
        /// Name of the call.
        call: &'static str,
        /// Stage the unit is in.
        stage: Stage,
    },
    /// The step does not start at the time of the unit.
    #[error(
        "{unit}: a step from t = {asked} s was requested, but the unit is at t = {time} s; restore the state saved at that time first"
    )]
    Time {
        /// Unit that was called.
        unit: &'static str,
        /// Start of the requested step, s.
        asked: f64,
        /// Time of the unit, s.
        time: f64,
    },
    /// The unit cannot take a step of this length.
    #[error(
        "{unit}: a communication step of {asked} s was requested, it can only take {own} s and whole multiples of it; \
             set the communication step, or the output interval, to one of these"
    )]
    CommunicationStep {
        /// Unit that was called.
        unit: &'static str,
        /// Requested length, s.
        asked: f64,
        /// Length for which the unit was made, s.
        own: f64,
    },
    /// The unit does not offer this derivative.
    #[error("{unit}: no derivative of variable {unknown} with respect to variable {known} is offered")]
    Derivative {
        /// Unit that was called.
        unit: &'static str,
        /// Value reference of the unknown.
        unknown: u32,
        /// Value reference of the known.
        known: u32,
    },
    /// A serialised state cannot be used here.
    #[error(transparent)]
    State(#[from] StateError),
}

/// The values at these `places` of `all`, NaN beyond its last.
pub fn at_places(all: &[f64], places: &[usize]) -> impl Iterator<Item = f64> {
    places.iter().map(|place| all.get(*place).copied().unwrap_or(f64::NAN))
}

/// What [`CoSimulation::get_at`] does by default: gets all values.
pub fn get_all_at<U: CoSimulation + ?Sized>(
    unit: &U,
    value_reference: u32,
    places: &[usize],
    values: &mut [f64],
) -> Result<(), U::Error> {
    let mut all = vec![0.0; unit.size(unit.variable(value_reference)?)];
    unit.get(value_reference, &mut all)?;
    values.iter_mut().zip(at_places(&all, places)).for_each(|(value, at)| *value = at);
    Ok(())
}

/// A co-simulation unit.
///
/// **Call order**: `set` (initial inputs), [`initialise`](Self::initialise), then for every
/// step `set`, [`step`](Self::step), `get`. To repeat a step: `restore_state`, `set`, `step`.
///
/// **States.** A saved state holds everything that later results depend on: time, motion,
/// contact and convolution history, the accepted inputs. Restoring does not alter it, and it may be
/// restored any number of times; after that, steps with the same inputs give outputs that are equal
/// bit for bit. Where a step has no single answer, as with a bond that breaks and holds by turns, a unit may settle it from the
/// attempts at this step so far; the same attempts then give the same bits. Saving and restoring cost the same at any time of a run; only serialising copies the
/// history.
pub trait CoSimulation: Send {
    /// Saved state of the unit.
    type State: Clone + Send + 'static;
    /// What can go wrong in the unit, its solver included.
    type Error: std::error::Error + From<CallError> + Send + Sync + 'static;

    /// Name of the unit, as messages and logs show it.
    fn name(&self) -> &'static str;

    /// The unit's variables.
    fn variables(&self) -> &'static [Variable];

    /// Number of values of `variable`.
    fn size(&self, variable: &Variable) -> usize;

    /// Hash of everything from which the unit was made; only units with the same hash exchange states.
    fn fingerprint(&self) -> Fingerprint;

    /// What the unit can do in addition to stepping.
    fn capabilities(&self) -> Capabilities;

    /// Ends initialisation at `start_time` (s); the inputs set before hold at that time.
    fn initialise(&mut self, start_time: f64) -> Result<(), Self::Error>;

    /// Sets an input for the end of the next step; before `initialise`, for the start time.
    ///
    /// **Errors**: unknown or unsettable variable, wrong length, a value that is not finite.
    fn set(&mut self, value_reference: u32, values: &[f64]) -> Result<(), Self::Error>;

    /// Advances from `time` by `communication_step` (s).
    fn step(&mut self, time: f64, communication_step: f64) -> Result<(), Self::Error>;

    /// Copies a variable's values at the current time into `values`.
    fn get(&self, value_reference: u32, values: &mut [f64]) -> Result<(), Self::Error>;

    /// The same of the values at these `places` of a variable, NaN beyond its last. A unit that computes each value by itself is spared
    /// the others.
    fn get_at(&self, value_reference: u32, places: &[usize], values: &mut [f64]) -> Result<(), Self::Error> {
        get_all_at(self, value_reference, places, values)
    }

    /// Saves the state at the current communication point.
    fn save_state(&self) -> Self::State;

    /// Returns to a saved state.
    fn restore_state(&mut self, state: &Self::State) -> Result<(), Self::Error>;

    /// Writes a state as bytes, together with a format version and the unit's fingerprint.
    fn serialise_state(&self, state: &Self::State) -> Result<Vec<u8>, Self::Error>;

    /// Reads a state written by a unit made from the same scene, in this or another process.
    fn deserialise_state(&self, bytes: &[u8]) -> Result<Self::State, Self::Error>;

    /// `sensitivity = ∂(unknown)/∂(known) · seed` of one communication step, exact.
    ///
    /// **Errors**: [`CallError::Derivative`] if the unit does not offer it.
    fn directional_derivative(
        &self,
        unknown: u32,
        known: u32,
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), Self::Error>;

    /// The variable with this value reference.
    fn variable(&self, value_reference: u32) -> Result<&'static Variable, CallError> {
        self.variables()
            .iter()
            .find(|v| v.value_reference == value_reference)
            .ok_or(CallError::UnknownVariable { unit: self.name(), value_reference })
    }

    /// Checks the number of values given for `variable`.
    fn check_length(&self, variable: &'static Variable, found: usize) -> Result<(), CallError> {
        let expected = self.size(variable);
        if expected == found {
            Ok(())
        } else {
            Err(CallError::Length { unit: self.name(), variable: variable.name, expected, found })
        }
    }

    /// Checks that all values of `variable` are finite at `time` (s).
    fn check_finite(&self, variable: &'static Variable, values: &[f64], time: f64) -> Result<(), CallError> {
        match values.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(index) => Err(CallError::NonFinite {
                unit: self.name(),
                variable: variable.name,
                index,
                value: values[index],
                time,
            }),
        }
    }
}
