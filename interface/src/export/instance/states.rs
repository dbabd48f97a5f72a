use super::made::{Made, failed};
use super::{Instance, Mode};
use crate::export::ExportError;
use crate::{Packable, StateError, open, seal};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A saved state.
pub(super) struct Saved<S> {
    mode: Mode,
    time: f64,
    stop_time: Option<f64>,
    experiment: (f64, Option<f64>),
    slopes: BTreeMap<u32, f64>,
    /// The numbers of all parameters.
    parameters: Vec<f64>,
    state: Kept<S>,
}

/// A state, or its bytes: only a unit with the same parameters can read them.
enum Kept<S> {
    State(S),
    Written(Vec<u8>),
}

/// The serialised form of a saved state.
#[derive(Serialize, Deserialize)]
struct SerialisedState {
    mode: Mode,
    time: f64,
    stop_time: Option<f64>,
    experiment: (f64, Option<f64>),
    slopes: BTreeMap<u32, f64>,
    parameters: Vec<f64>,
    unit: Vec<u8>,
}

impl<U: Packable> Instance<U> {
    /// Whether `handle` belongs to a saved state.
    pub fn has_state(&self, handle: usize) -> bool {
        self.states.contains_key(&handle)
    }

    /// Saves the state under `handle`.
    pub fn save_state(&mut self, handle: usize) -> Result<(), ExportError> {
        let (mode, time, stop_time) = (self.mode, self.time, self.stop_time);
        let (experiment, slopes) = (self.experiment, self.slopes.clone());
        let parameters = numbers_of::<U>(&mut self.parameters);
        let made = self.made()?;
        let state = made.before_outputs.clone().unwrap_or_else(|| made.unit.save_state());
        let state = Kept::State(state);
        self.states.insert(handle, Saved { mode, time, stop_time, experiment, slopes, parameters, state });
        Ok(())
    }

    /// Returns to the state saved under `handle`, its parameters included.
    pub fn restore_state(&mut self, call: &'static str, handle: usize) -> Result<(), ExportError> {
        let saved = self.states.get_mut(&handle).ok_or(ExportError::UnknownState { call })?;
        let mut parameters = None;
        if numbers_of::<U>(&mut self.parameters) != saved.parameters {
            let mut others = self.packed.parameters.clone();
            set_numbers::<U>(&mut others, &saved.parameters)?;
            parameters = Some(others);
        }
        let mut other = None;
        let made = match (&parameters, &mut self.made) {
            (None, Some(made)) => made,
            (parameters, _) => {
                let parameters = parameters.as_ref().unwrap_or(&self.parameters).clone();
                other.insert(Made::new(parameters, &self.prepared, &self.inputs)?)
            }
        };
        if let Kept::Written(bytes) = &saved.state {
            saved.state = Kept::State(made.unit.deserialise_state(bytes).map_err(failed)?);
        }
        if let Kept::State(state) = &saved.state {
            made.unit.restore_state(state).map_err(failed)?;
        }
        made.before_outputs = None;
        self.experiment = saved.experiment;
        self.slopes.clone_from(&saved.slopes);
        (self.mode, self.time, self.stop_time) = (saved.mode, saved.time, saved.stop_time);
        self.made = other.or(self.made.take());
        if let Some(parameters) = parameters {
            self.parameters = parameters;
        }
        Ok(())
    }

    /// Frees the state saved under `handle`.
    pub fn free_state(&mut self, call: &'static str, handle: usize) -> Result<(), ExportError> {
        self.states.remove(&handle).map(|_| ()).ok_or(ExportError::UnknownState { call })
    }

    /// The state saved under `handle` as bytes.
    pub fn serialise_state(&mut self, call: &'static str, handle: usize) -> Result<Vec<u8>, ExportError> {
        let saved = self.states.get(&handle).ok_or(ExportError::UnknownState { call })?;
        let unit = match &saved.state {
            Kept::Written(bytes) => bytes.clone(),
            Kept::State(state) => {
                let own;
                let made = match &self.made {
                    Some(made) if numbers_of::<U>(&mut self.parameters) == saved.parameters => made,
                    _ => {
                        let mut parameters = self.packed.parameters.clone();
                        set_numbers::<U>(&mut parameters, &saved.parameters)?;
                        own = Made::<U>::new(parameters, &self.prepared, &self.inputs)?;
                        &own
                    }
                };
                made.unit.serialise_state(state).map_err(failed)?
            }
        };
        let Saved { mode, time, stop_time, experiment, .. } = *saved;
        let (slopes, parameters) = (saved.slopes.clone(), saved.parameters.clone());
        Ok(seal(
            self.fingerprint,
            &SerialisedState { mode, time, stop_time, experiment, slopes, parameters, unit },
        )?)
    }

    /// Reads a state written by [`serialise_state`](Self::serialise_state), in this or another process, and saves it under
    /// `handle`.
    ///
    /// **Errors**: damaged bytes, or bytes of another FMU.
    pub fn deserialise_state(&mut self, bytes: &[u8], handle: usize) -> Result<(), ExportError> {
        let SerialisedState { mode, time, stop_time, experiment, slopes, parameters, unit } =
            open(self.fingerprint, bytes)?;
        set_numbers::<U>(&mut self.packed.parameters.clone(), &parameters)?;
        let state = Kept::Written(unit);
        self.states.insert(handle, Saved { mode, time, stop_time, experiment, slopes, parameters, state });
        Ok(())
    }
}

/// The numbers of all parameters that can be changed, in the order of the variables.
pub(super) fn numbers_of<U: Packable>(parameters: &mut U::Parameters) -> Vec<f64> {
    let mut numbers = Vec::new();
    for variable in U::VARIABLES {
        numbers.extend(U::numbers(parameters, variable).iter().map(|number| **number));
    }
    numbers
}

/// Sets the numbers that [`numbers_of`] returned.
fn set_numbers<U: Packable>(parameters: &mut U::Parameters, values: &[f64]) -> Result<(), StateError> {
    if numbers_of::<U>(parameters).len() != values.len() {
        return Err(StateError::NotAState { length: values.len() });
    }
    let mut rest = values.iter();
    for variable in U::VARIABLES {
        for (number, value) in U::numbers(parameters, variable).into_iter().zip(&mut rest) {
            *number = *value;
        }
    }
    Ok(())
}
