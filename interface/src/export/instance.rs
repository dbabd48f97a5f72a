use super::{Contents, ExportError};
use crate::{CallError, Causality, Packable, Variable, open, seal};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroUsize;

/// Value reference of the independent variable `time`.
const TIME: u32 = 0;

/// Where an instance stands in the life that FMI 3.0 prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Mode {
    Instantiated,
    Initialization,
    Step,
    Terminated,
}

impl Mode {
    fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "the state Instantiated",
            Self::Initialization => "Initialization Mode",
            Self::Step => "Step Mode",
            Self::Terminated => "the state Terminated",
        }
    }
}

/// A unit as the importer of its FMU drives it.
///
/// The unit is made when something of it is needed, at the latest when initialisation begins: so
/// parameters that are set before cost nothing. Changing one later in initialisation makes it anew.
pub struct Instance<U: Packable> {
    packed: Contents<U::Parameters>,
    parameters: U::Parameters,
    /// Inputs that were set while there is no unit.
    inputs: BTreeMap<u32, Vec<f64>>,
    made: Option<Made<U>>,
    mode: Mode,
    time: f64,
    states: HashMap<usize, Saved<U::State>>,
}

struct Made<U: Packable> {
    unit: U,
    /// The state that it was made in.
    new: U::State,
    /// The state before outputs were asked for in Initialization Mode, and the unit initialised for it.
    before_outputs: Option<U::State>,
}

struct Saved<S> {
    mode: Mode,
    time: f64,
    state: S,
}

/// What is written of a saved state.
#[derive(Serialize, Deserialize)]
struct SerialisedState {
    mode: Mode,
    time: f64,
    unit: Vec<u8>,
}

fn failed<E: std::error::Error + Send + Sync + 'static>(error: E) -> ExportError {
    ExportError::Unit(Box::new(error))
}

impl<U: Packable> Instance<U> {
    /// An instance of what an FMU holds.
    ///
    /// **Errors**: a start value for what is no input, or of the wrong length.
    pub fn new(packed: Contents<U::Parameters>) -> Result<Self, ExportError> {
        let parameters = packed.parameters.clone();
        let inputs = BTreeMap::new();
        let states = HashMap::new();
        let mut new =
            Self { packed, parameters, inputs, made: None, mode: Mode::Instantiated, time: 0.0, states };
        new.set_start_values()?;
        Ok(new)
    }

    fn set_start_values(&mut self) -> Result<(), ExportError> {
        for variable in U::VARIABLES.iter().filter(|v| v.causality == Causality::Input) {
            let zero = || vec![0.0; self.size(variable)];
            let start = self.packed.start.get(variable.name).cloned().unwrap_or_else(zero);
            self.set_input(variable, &start)?;
        }
        Ok(())
    }

    fn refused(&self, call: &'static str, remedy: &'static str) -> ExportError {
        ExportError::Mode { call, mode: self.mode.name(), remedy }
    }

    fn expect(&self, call: &'static str, modes: &[Mode], remedy: &'static str) -> Result<(), ExportError> {
        if modes.contains(&self.mode) { Ok(()) } else { Err(self.refused(call, remedy)) }
    }

    /// The unit, made now if it is not there.
    fn made(&mut self) -> Result<&mut Made<U>, ExportError> {
        if self.made.is_none() {
            let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
            let mut unit = U::from_parameters(self.parameters.clone(), threads).map_err(failed)?;
            let new = unit.save_state();
            for (reference, values) in &self.inputs {
                unit.set(*reference, values).map_err(failed)?;
            }
            self.made = Some(Made { unit, new, before_outputs: None });
        }
        // It is there.
        self.made.as_mut().ok_or(ExportError::Broken)
    }

    /// Gives up the unit because a parameter changes; its inputs stay.
    fn unmake(&mut self) -> Result<(), ExportError> {
        let Some(made) = self.made.take() else { return Ok(()) };
        for variable in U::VARIABLES.iter().filter(|v| v.causality == Causality::Input) {
            let mut values = vec![0.0; made.unit.size(variable)];
            made.unit.get(variable.value_reference, &mut values).map_err(failed)?;
            self.inputs.insert(variable.value_reference, values);
        }
        Ok(())
    }

    fn size(&self, variable: &Variable) -> usize {
        match &self.made {
            Some(made) => made.unit.size(variable),
            None => U::size_for(&self.parameters, variable),
        }
    }

    fn variable(reference: u32) -> Result<&'static Variable, CallError> {
        let found = U::VARIABLES.iter().find(|v| v.value_reference == reference);
        found.ok_or(CallError::UnknownVariable { unit: U::NAME, value_reference: reference })
    }

    /// Number of values of each variable; checks that `found` is their sum.
    fn sizes(&self, call: &'static str, references: &[u32], found: usize) -> Result<Vec<usize>, ExportError> {
        let size = |reference: &u32| match *reference {
            TIME => Ok(1),
            reference => Ok(self.size(Self::variable(reference)?)),
        };
        let sizes = references.iter().map(size).collect::<Result<Vec<usize>, CallError>>()?;
        let expected = sizes.iter().sum();
        if expected == found {
            Ok(sizes)
        } else {
            Err(ExportError::Values { call, references: references.len(), expected, found })
        }
    }

    /// Sets variables, one after the other, from `values`.
    ///
    /// **Errors**: unknown or unsettable variable, wrong number of values, a value that is not finite.
    pub fn set(&mut self, call: &'static str, references: &[u32], values: &[f64]) -> Result<(), ExportError> {
        if self.mode == Mode::Terminated {
            return Err(self.refused(call, "reset the instance first"));
        }
        let mut rest = values;
        for (reference, size) in references.iter().zip(self.sizes(call, references, values.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            if *reference == TIME {
                return Err(ExportError::Time);
            }
            let variable = Self::variable(*reference)?;
            let not_finite = |index: usize| {
                let (value, time) = (own[index], self.time);
                CallError::NonFinite { unit: U::NAME, variable: variable.name, index, value, time }
            };
            if let Some(index) = own.iter().position(|v| !v.is_finite()) {
                return Err(not_finite(index).into());
            }
            match variable.causality {
                Causality::Input => self.set_input(variable, own)?,
                Causality::Parameter => self.set_parameter(call, variable, own)?,
                Causality::CalculatedParameter | Causality::Output => {
                    return Err(CallError::NotSettable { unit: U::NAME, variable: variable.name }.into());
                }
            }
        }
        Ok(())
    }

    fn set_input(&mut self, variable: &'static Variable, values: &[f64]) -> Result<(), ExportError> {
        let expected = self.size(variable);
        if values.len() != expected {
            let (unit, variable, found) = (U::NAME, variable.name, values.len());
            return Err(CallError::Length { unit, variable, expected, found }.into());
        }
        let Some(made) = &mut self.made else {
            self.inputs.insert(variable.value_reference, values.to_vec());
            return Ok(());
        };
        if let Some(before) = made.before_outputs.take() {
            made.unit.restore_state(&before).map_err(failed)?;
        }
        made.unit.set(variable.value_reference, values).map_err(failed)
    }

    fn set_parameter(
        &mut self,
        call: &'static str,
        variable: &'static Variable,
        values: &[f64],
    ) -> Result<(), ExportError> {
        let remedy = "parameters are set before fmi3ExitInitializationMode";
        self.expect(call, &[Mode::Instantiated, Mode::Initialization], remedy)?;
        let numbers = U::numbers(&mut self.parameters, variable);
        if numbers.len() != values.len() {
            return Err(ExportError::Unchangeable { unit: U::NAME, variable: variable.name });
        }
        for (number, value) in numbers.into_iter().zip(values) {
            *number = *value;
        }
        self.unmake()
    }

    /// Gets variables, one after the other, into `values`.
    ///
    /// **Errors**: unknown variable, wrong number of values, an output before there are any.
    pub fn get(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &mut [f64],
    ) -> Result<(), ExportError> {
        let mut rest = values;
        for (reference, size) in references.iter().zip(self.sizes(call, references, rest.len())?) {
            let (own, others) = rest.split_at_mut(size);
            rest = others;
            match *reference {
                TIME => own.fill(self.time),
                reference => self.get_one(Self::variable(reference)?, own)?,
            }
        }
        Ok(())
    }

    fn get_one(&mut self, variable: &'static Variable, values: &mut [f64]) -> Result<(), ExportError> {
        let reference = variable.value_reference;
        match (variable.causality, &self.made) {
            (Causality::Parameter, _) => {
                for (value, number) in values.iter_mut().zip(U::numbers(&mut self.parameters, variable)) {
                    *value = *number;
                }
                Ok(())
            }
            (Causality::Input, None) => {
                values.copy_from_slice(self.inputs.get(&reference).map_or(&[], |v| v));
                Ok(())
            }
            _ => {
                let (mode, time) = (self.mode, self.time);
                let made = self.made()?;
                match made.unit.get(reference, values) {
                    // What depends on the inputs exists once the unit is initialised with them.
                    Err(_) if mode == Mode::Initialization && made.before_outputs.is_none() => {
                        made.initialise(time)?;
                        made.unit.get(reference, values).map_err(failed)
                    }
                    result => result.map_err(failed),
                }
            }
        }
    }

    /// Begins initialisation at `start_time` (s): the unit is made.
    pub fn enter_initialization(&mut self, call: &'static str, start_time: f64) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Instantiated], "it comes once, after instantiating or resetting")?;
        if !start_time.is_finite() {
            return Err(ExportError::StartTime { value: start_time });
        }
        self.made()?;
        (self.time, self.mode) = (start_time, Mode::Initialization);
        Ok(())
    }

    /// Ends initialisation.
    pub fn exit_initialization(&mut self, call: &'static str) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Initialization], "call fmi3EnterInitializationMode first")?;
        let time = self.time;
        let made = self.made()?;
        if made.before_outputs.is_none() {
            made.initialise(time)?;
        }
        made.before_outputs = None;
        self.mode = Mode::Step;
        Ok(())
    }

    /// Takes the step from `time` of length `communication_step` (s); returns its end.
    pub fn step(
        &mut self,
        call: &'static str,
        time: f64,
        communication_step: f64,
    ) -> Result<f64, ExportError> {
        self.expect(call, &[Mode::Step], "initialise the instance first; after fmi3Terminate, reset it")?;
        self.made()?.unit.step(time, communication_step).map_err(failed)?;
        self.time = time + communication_step;
        Ok(self.time)
    }

    /// Ends the simulation; results can still be read.
    pub fn terminate(&mut self, call: &'static str) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Step], "there is nothing to end")?;
        self.mode = Mode::Terminated;
        Ok(())
    }

    /// Goes back to where the instance began; saved states stay.
    pub fn reset(&mut self) -> Result<(), ExportError> {
        let changed = U::VARIABLES.iter().any(|variable| {
            let packed: Vec<f64> =
                U::numbers(&mut self.packed.parameters, variable).into_iter().map(|n| *n).collect();
            U::numbers(&mut self.parameters, variable).into_iter().ne(&packed)
        });
        if changed {
            self.parameters = self.packed.parameters.clone();
            self.made = None;
        }
        if let Some(made) = &mut self.made {
            made.before_outputs = None;
            made.unit.restore_state(&made.new).map_err(failed)?;
        }
        (self.mode, self.time) = (Mode::Instantiated, 0.0);
        self.set_start_values()
    }

    /// `sensitivity = Σ ∂(unknown)/∂(known) · seed` of one communication step, for all unknowns and knowns.
    pub fn directional_derivative(
        &mut self,
        call: &'static str,
        [unknowns, knowns]: [&[u32]; 2],
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Step], "there are derivatives of communication steps only")?;
        let known_sizes = self.sizes(call, knowns, seed.len())?;
        let unknown_sizes = self.sizes(call, unknowns, sensitivity.len())?;
        let unit = &self.made()?.unit;
        sensitivity.fill(0.0);
        let mut rest = sensitivity;
        for (unknown, size) in unknowns.iter().zip(unknown_sizes) {
            let (own, others) = rest.split_at_mut(size);
            rest = others;
            let mut part = vec![0.0; size];
            let mut seeds = seed;
            for (known, size) in knowns.iter().zip(&known_sizes) {
                let (seed, others) = seeds.split_at(*size);
                seeds = others;
                unit.directional_derivative(*unknown, *known, seed, &mut part).map_err(failed)?;
                own.iter_mut().zip(&part).for_each(|(sum, part)| *sum += part);
            }
        }
        Ok(())
    }

    /// Checks that `handle` is a saved state's.
    pub fn check_state(&self, call: &'static str, handle: usize) -> Result<(), ExportError> {
        self.saved(call, handle).map(|_| ())
    }

    fn saved(&self, call: &'static str, handle: usize) -> Result<&Saved<U::State>, ExportError> {
        self.states.get(&handle).ok_or(ExportError::UnknownState { call })
    }

    /// Saves the state under `handle`.
    pub fn save_state(&mut self, handle: usize) -> Result<(), ExportError> {
        let (mode, time) = (self.mode, self.time);
        let made = self.made()?;
        let state = made.before_outputs.clone().unwrap_or_else(|| made.unit.save_state());
        self.states.insert(handle, Saved { mode, time, state });
        Ok(())
    }

    /// Returns to the state saved under `handle`.
    pub fn restore_state(&mut self, call: &'static str, handle: usize) -> Result<(), ExportError> {
        self.made()?;
        let saved = self.states.get(&handle).ok_or(ExportError::UnknownState { call })?;
        if let Some(made) = &mut self.made {
            made.unit.restore_state(&saved.state).map_err(failed)?;
            made.before_outputs = None;
        }
        (self.mode, self.time) = (saved.mode, saved.time);
        Ok(())
    }

    /// Frees the state saved under `handle`.
    pub fn free_state(&mut self, call: &'static str, handle: usize) -> Result<(), ExportError> {
        self.states.remove(&handle).map(|_| ()).ok_or(ExportError::UnknownState { call })
    }

    /// The state saved under `handle` as bytes.
    pub fn serialise_state(&mut self, call: &'static str, handle: usize) -> Result<Vec<u8>, ExportError> {
        self.made()?;
        let Saved { mode, time, state } = self.saved(call, handle)?;
        let made = self.made.as_ref().ok_or(ExportError::Broken)?;
        let unit = made.unit.serialise_state(state).map_err(failed)?;
        Ok(seal(made.unit.fingerprint(), &SerialisedState { mode: *mode, time: *time, unit })?)
    }

    /// Reads what [`serialise_state`](Self::serialise_state) wrote, in any process, and saves it under `handle`.
    pub fn deserialise_state(&mut self, bytes: &[u8], handle: usize) -> Result<(), ExportError> {
        let unit = &self.made()?.unit;
        let SerialisedState { mode, time, unit: state } = open(unit.fingerprint(), bytes)?;
        let state = unit.deserialise_state(&state).map_err(failed)?;
        self.states.insert(handle, Saved { mode, time, state });
        Ok(())
    }
}

impl<U: Packable> Made<U> {
    /// Initialises the unit, and remembers how it was before.
    fn initialise(&mut self, start_time: f64) -> Result<(), ExportError> {
        let before = self.unit.save_state();
        self.unit.initialise(start_time).map_err(failed)?;
        self.before_outputs = Some(before);
        Ok(())
    }
}
