use super::{Contents, ContentsError, ExportError, PREPARED, Record};
use crate::variables::TIME;
use crate::{CallError, Causality, Fingerprint, Packable, StateError, Variable, open, seal};
use serde::{Deserialize, Serialize};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Fraction of a communication step by which its end may pass the stop time, because sums of steps are rounded.
const STOP_TOLERANCE: f64 = 1e-3;

/// References from here on name single values: the value reference of their variable times this number, plus their index.
pub const ELEMENTS: u32 = 1 << 16;

/// The reference of value `index` of the variable `value_reference`, as FMI 2.0 and descriptions by scalars need it.
pub const fn element(value_reference: u32, index: usize) -> u32 {
    value_reference * ELEMENTS + index as u32
}

/// State of an instance in the state machine of FMI.
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

/// A unit as the importer of its FMU uses it.
///
/// The unit is made when it is first needed, at the latest when initialisation begins. Parameters that are set before
/// therefore cost nothing; a parameter that changes during initialisation makes the unit again.
///
/// A refused call changes nothing.
pub struct Instance<U: Packable> {
    packed: Contents<U::Parameters>,
    prepared: Prepared<U::Parameters>,
    fingerprint: Fingerprint,
    /// The variables of this FMU, and their numbers of values.
    variables: BTreeMap<u32, (&'static Variable, usize)>,
    /// Inputs that records drive, and their numbers of values.
    driven: Vec<(&'static Variable, usize)>,
    parameters: U::Parameters,
    /// Inputs that were set before the unit was made.
    inputs: BTreeMap<u32, Vec<f64>>,
    /// Time derivatives of single values of inputs during the next step, by their references.
    slopes: BTreeMap<u32, f64>,
    made: Option<Made<U>>,
    mode: Mode,
    time: f64,
    stop_time: Option<f64>,
    /// Start and stop time for a version of FMI that sets them before it begins initialisation, s.
    experiment: (f64, Option<f64>),
    states: HashMap<usize, Saved<U::State>>,
}

/// What was prepared for the parameters that were packed.
struct Prepared<P> {
    path: PathBuf,
    parameters: P,
}

struct Made<U: Packable> {
    unit: U,
    /// The state of the unit when it was made.
    new: U::State,
    /// The state before the unit was initialised because outputs were read in Initialization Mode.
    before_outputs: Option<U::State>,
}

struct Saved<S> {
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

fn failed<E: std::error::Error + Send + Sync + 'static>(error: E) -> ExportError {
    ExportError::Unit(Box::new(error))
}

impl<U: Packable> Instance<U> {
    /// An instance with the contents of an FMU, whose folder of resources may hold what is [`PREPARED`] for them.
    ///
    /// **Errors**: a start value for a variable that is not an input, or of the wrong length.
    pub fn new(packed: Contents<U::Parameters>, resources: &Path) -> Result<Self, ExportError> {
        let mut parameters = packed.parameters.clone();
        let prepared = Prepared { path: resources.join(PREPARED), parameters: parameters.clone() };
        let (mut variables, mut driven) = (BTreeMap::new(), Vec::new());
        for variable in U::VARIABLES {
            let size = U::size_for(&parameters, variable);
            let numbers = U::numbers(&mut parameters, variable).len();
            if packed.drives(variable.name) && is_input(variable) {
                driven.push((variable, size));
            } else if size > 0 && (variable.causality != Causality::Parameter || numbers == size) {
                variables.insert(variable.value_reference, (variable, size));
            }
        }
        let input = |name: &str| variables.values().find(|(v, _)| v.name == name && is_input(v));
        for (name, values) in &packed.start {
            let expected = input(name).map_or(0, |(_, size)| *size);
            if expected != values.len() {
                return Err(ExportError::Start { name: name.clone(), expected, found: values.len() });
            }
        }
        let mut new = Self {
            fingerprint: Fingerprint::of(U::NAME, &packed)?,
            packed,
            prepared,
            variables,
            driven,
            parameters,
            inputs: BTreeMap::new(),
            slopes: BTreeMap::new(),
            made: None,
            mode: Mode::Instantiated,
            time: 0.0,
            stop_time: None,
            experiment: (0.0, None),
            states: HashMap::new(),
        };
        new.set_start_values()?;
        Ok(new)
    }

    fn set_start_values(&mut self) -> Result<(), ExportError> {
        for (variable, size) in
            self.variables.values().copied().filter(|(v, _)| is_input(v)).collect::<Vec<_>>()
        {
            let start = self.packed.start.get(variable.name).cloned();
            self.set_input(variable, &start.unwrap_or_else(|| vec![0.0; size]))?;
        }
        Ok(())
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    fn refused(&self, call: &'static str, remedy: &'static str) -> ExportError {
        ExportError::Mode { call, mode: self.mode.name(), remedy }
    }

    fn expect(&self, call: &'static str, modes: &[Mode], remedy: &'static str) -> Result<(), ExportError> {
        if modes.contains(&self.mode) { Ok(()) } else { Err(self.refused(call, remedy)) }
    }

    /// The unit; it is made now if there is none.
    fn made(&mut self) -> Result<&mut Made<U>, ExportError> {
        if self.made.is_none() {
            self.made = Some(Made::new(self.parameters.clone(), &self.prepared, &self.inputs)?);
        }
        // It was just made.
        self.made.as_mut().ok_or(ExportError::Broken)
    }

    /// Sets the inputs that records drive to their values at `time` (s).
    fn drive(&mut self, time: f64) -> Result<(), ExportError> {
        for &(variable, size) in &self.driven {
            let Some(values) = Record::values(&self.packed.records, variable.name, size, time) else {
                continue;
            };
            if let Some(made) = &mut self.made {
                made.unit.set(variable.value_reference, &values).map_err(failed)?;
            }
            self.inputs.insert(variable.value_reference, values);
        }
        Ok(())
    }

    /// Drops the unit because a parameter changes, and keeps its inputs.
    fn unmake(&mut self) -> Result<(), ExportError> {
        let Some(made) = self.made.take() else { return Ok(()) };
        for (reference, (_, size)) in self.variables.iter().filter(|(_, (v, _))| is_input(v)) {
            let mut values = vec![0.0; *size];
            made.unit.get(*reference, &mut values).map_err(failed)?;
            self.inputs.insert(*reference, values);
        }
        Ok(())
    }

    fn variable(&self, reference: u32) -> Result<(&'static Variable, usize), CallError> {
        let unknown = CallError::UnknownVariable { unit: U::NAME, value_reference: reference };
        self.variables.get(&reference).copied().ok_or(unknown)
    }

    /// The variable of a single value, and its index.
    fn value(&self, reference: u32) -> Result<(&'static Variable, usize), CallError> {
        let (of, index) = (reference / ELEMENTS, (reference % ELEMENTS) as usize);
        let found = self.variable(of).ok().filter(|(_, size)| index < *size);
        let unknown = CallError::UnknownVariable { unit: U::NAME, value_reference: reference };
        found.map(|(variable, _)| (variable, index)).ok_or(unknown)
    }

    /// Number of values of each reference; checks that `found` is their sum.
    fn sizes(&self, call: &'static str, references: &[u32], found: usize) -> Result<Vec<usize>, ExportError> {
        let size = |reference: &u32| match *reference {
            TIME => Ok(1),
            ELEMENTS.. => self.value(*reference).map(|_| 1),
            reference => self.variable(reference).map(|(_, size)| size),
        };
        let sizes = references.iter().map(size).collect::<Result<Vec<usize>, CallError>>()?;
        let expected = sizes.iter().sum();
        if expected == found { Ok(sizes) } else { Err(ExportError::Values { call, expected, found }) }
    }

    /// Sets variables from `values`, all of them or none.
    ///
    /// **Errors**: unknown or unsettable variable, wrong number of values, a value that is not finite.
    pub fn set(&mut self, call: &'static str, references: &[u32], values: &[f64]) -> Result<(), ExportError> {
        if self.mode == Mode::Terminated {
            return Err(self.refused(call, "reset the instance first"));
        }
        if references.iter().all(|reference| *reference < ELEMENTS) {
            return self.set_whole(call, references, values);
        }
        let (references, values) = self.whole(call, references, values)?;
        self.set_whole(call, &references, &values)
    }

    /// Whole variables in place of single values; the other values of these variables stay what they are.
    fn whole(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &[f64],
    ) -> Result<(Vec<u32>, Vec<f64>), ExportError> {
        let mut whole = BTreeMap::<u32, Vec<f64>>::new();
        let mut rest = values;
        for (reference, size) in references.iter().zip(self.sizes(call, references, values.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            let (of, first) = match *reference {
                ELEMENTS.. => (reference / ELEMENTS, (reference % ELEMENTS) as usize),
                reference => (reference, 0),
            };
            let all = match whole.entry(of) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(free) => free.insert(self.now(of)?),
            };
            all[first..first + size].copy_from_slice(own);
        }
        let (references, values): (Vec<_>, Vec<_>) = whole.into_iter().unzip();
        Ok((references, values.concat()))
    }

    /// The values that an input or parameter has; zeros for what cannot be set and need not have a value now.
    fn now(&mut self, reference: u32) -> Result<Vec<f64>, ExportError> {
        if reference == TIME {
            return Ok(vec![self.time]);
        }
        let (variable, size) = self.variable(reference)?;
        let mut now = vec![0.0; size];
        if is_input(variable) || variable.causality == Causality::Parameter {
            self.get_one(variable, &mut now)?;
        }
        Ok(now)
    }

    fn set_whole(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &[f64],
    ) -> Result<(), ExportError> {
        let (mut settings, mut rest) = (Vec::with_capacity(references.len()), values);
        for (reference, size) in references.iter().zip(self.sizes(call, references, values.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            if *reference == TIME {
                return Err(ExportError::Time);
            }
            let (variable, _) = self.variable(*reference)?;
            self.check_setting(call, variable, own)?;
            settings.push((variable, own));
        }
        // If the unit refuses one input, the others must not stay set.
        let before = match &self.made {
            Some(made) if settings.len() > 1 => Some((made.unit.save_state(), made.before_outputs.clone())),
            _ => None,
        };
        let (parameters, inputs): (Vec<_>, Vec<_>) =
            settings.into_iter().partition(|(variable, _)| variable.causality == Causality::Parameter);
        for (variable, values) in inputs {
            if let Err(error) = self.set_input(variable, values) {
                if let (Some(made), Some((before, before_outputs))) = (&mut self.made, before) {
                    made.unit.restore_state(&before).map_err(failed)?;
                    made.before_outputs = before_outputs;
                }
                return Err(error);
            }
        }
        parameters.into_iter().try_for_each(|(variable, values)| self.set_parameter(variable, values))
    }

    /// Checks whether a variable can be set to these values, as far as possible without the unit.
    fn check_setting(
        &self,
        call: &'static str,
        variable: &'static Variable,
        values: &[f64],
    ) -> Result<(), ExportError> {
        let (unit, variable_name, time) = (U::NAME, variable.name, self.time);
        let not_finite = values.iter().position(|v| !v.is_finite()).map(|index| (index, values[index]));
        match (variable.causality, not_finite) {
            (Causality::CalculatedParameter | Causality::Output | Causality::Local, _) => {
                Err(CallError::NotSettable { unit, variable: variable_name }.into())
            }
            (Causality::Parameter, Some((index, value))) => {
                Err(ExportError::NonFiniteParameter { unit, variable: variable_name, index, value })
            }
            (Causality::Parameter, None) => {
                let remedy = "parameters are set before initialisation ends";
                self.expect(call, &[Mode::Instantiated, Mode::Initialization], remedy)
            }
            (Causality::Input, Some((index, value))) => {
                Err(CallError::NonFinite { unit, variable: variable_name, index, value, time }.into())
            }
            (Causality::Input, None) => Ok(()),
        }
    }

    fn set_input(&mut self, variable: &'static Variable, values: &[f64]) -> Result<(), ExportError> {
        let Some(made) = &mut self.made else {
            self.inputs.insert(variable.value_reference, values.to_vec());
            return Ok(());
        };
        if let Some(before) = made.before_outputs.take() {
            made.unit.restore_state(&before).map_err(failed)?;
        }
        made.unit.set(variable.value_reference, values).map_err(failed)
    }

    fn set_parameter(&mut self, variable: &'static Variable, values: &[f64]) -> Result<(), ExportError> {
        let mut numbers = U::numbers(&mut self.parameters, variable);
        if numbers.iter().map(|number| **number).eq(values.iter().copied()) {
            return Ok(());
        }
        numbers.iter_mut().zip(values).for_each(|(number, value)| **number = *value);
        self.unmake()
    }

    /// Copies the values of the variables, one after the other, into `values`.
    ///
    /// **Errors**: unknown variable, wrong number of values, an output before the unit has outputs.
    pub fn get(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &mut [f64],
    ) -> Result<(), ExportError> {
        let mut rest = values;
        // Single values of one variable mostly follow each other.
        let mut last = (TIME, Vec::new());
        for (reference, size) in references.iter().zip(self.sizes(call, references, rest.len())?) {
            let (own, others) = rest.split_at_mut(size);
            rest = others;
            match *reference {
                TIME => own.fill(self.time),
                ELEMENTS.. => {
                    let (variable, index) = self.value(*reference)?;
                    if last.0 != variable.value_reference {
                        let mut all = vec![0.0; self.variable(variable.value_reference)?.1];
                        self.get_one(variable, &mut all)?;
                        last = (variable.value_reference, all);
                    }
                    own[0] = last.1[index];
                }
                reference => self.get_one(self.variable(reference)?.0, own)?,
            }
        }
        Ok(())
    }

    /// Sets time derivatives of single values of inputs for the next step alone: what was set is the value at its start, and
    /// the value at its end follows.
    ///
    /// **Errors**: not an input, an order other than 1, a derivative that is not finite.
    pub fn set_slopes(
        &mut self,
        call: &'static str,
        references: &[u32],
        orders: &[i32],
        slopes: &[f64],
    ) -> Result<(), ExportError> {
        let remedy = "set derivatives of inputs between steps";
        self.expect(call, &[Mode::Instantiated, Mode::Initialization, Mode::Step], remedy)?;
        for (reference, (order, slope)) in references.iter().zip(orders.iter().zip(slopes)) {
            let (variable, index) = self.value(*reference)?;
            if *order != 1 || !is_input(variable) {
                let (variable, order) = (variable.name, *order);
                return Err(ExportError::InputDerivative { unit: U::NAME, variable, order });
            }
            if !slope.is_finite() {
                let (unit, variable, value, time) = (U::NAME, variable.name, *slope, self.time);
                return Err(CallError::NonFinite { unit, variable, index, value, time }.into());
            }
        }
        self.slopes.extend(references.iter().copied().zip(slopes.iter().copied()));
        Ok(())
    }

    /// The inputs that have derivatives: their references, and what they are now.
    fn sloping(&mut self, call: &'static str) -> Result<(Vec<u32>, Vec<f64>), ExportError> {
        let references: Vec<u32> = self.slopes.keys().copied().collect();
        let mut values = vec![0.0; references.len()];
        self.get(call, &references, &mut values)?;
        Ok((references, values))
    }

    fn get_one(&mut self, variable: &'static Variable, values: &mut [f64]) -> Result<(), ExportError> {
        let reference = variable.value_reference;
        match (variable.causality, &self.made, self.inputs.get(&reference)) {
            (Causality::Parameter, ..) => {
                let numbers = U::numbers(&mut self.parameters, variable);
                values.iter_mut().zip(numbers).for_each(|(value, number)| *value = *number);
                Ok(())
            }
            (Causality::Input, None, Some(set)) => {
                values.copy_from_slice(set);
                Ok(())
            }
            _ => {
                let (mode, time) = (self.mode, self.time);
                let made = self.made()?;
                match made.unit.get(reference, values) {
                    // Values that depend on the inputs exist only after the unit has been initialised.
                    Err(_) if mode == Mode::Initialization && made.before_outputs.is_none() => {
                        made.initialise(time)?;
                        made.unit.get(reference, values).map_err(failed)
                    }
                    result => result.map_err(failed),
                }
            }
        }
    }

    /// Sets start and stop time (s) for [`enter_initialization_of_experiment`](Self::enter_initialization_of_experiment).
    pub fn set_experiment(
        &mut self,
        call: &'static str,
        start_time: f64,
        stop_time: Option<f64>,
    ) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Instantiated], "call it before initialisation, or reset the instance")?;
        check_interval(start_time, stop_time)?;
        self.experiment = (start_time, stop_time);
        Ok(())
    }

    /// [`enter_initialization`](Self::enter_initialization) with the times that were set, from 0 without a stop if none were.
    pub fn enter_initialization_of_experiment(&mut self, call: &'static str) -> Result<(), ExportError> {
        let (start_time, stop_time) = self.experiment;
        self.enter_initialization(call, start_time, stop_time)
    }

    /// Begins initialisation at `start_time` (s) and makes the unit. Steps beyond `stop_time` (s) will be refused.
    pub fn enter_initialization(
        &mut self,
        call: &'static str,
        start_time: f64,
        stop_time: Option<f64>,
    ) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Instantiated], "call it once, after instantiating or resetting")?;
        check_interval(start_time, stop_time)?;
        self.drive(start_time)?;
        self.made()?;
        (self.time, self.stop_time, self.mode) = (start_time, stop_time, Mode::Initialization);
        Ok(())
    }

    /// Ends initialisation.
    pub fn exit_initialization(&mut self, call: &'static str) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Initialization], "enter Initialization Mode first")?;
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
        self.expect(call, &[Mode::Step], "initialise the instance first; after it was terminated, reset it")?;
        let end = time + communication_step;
        if let Some(stop_time) = self.stop_time
            && end > stop_time + STOP_TOLERANCE * communication_step
        {
            return Err(ExportError::BeyondStop { end, stop_time });
        }
        self.drive(end)?;
        if self.slopes.is_empty() {
            self.made()?.unit.step(time, communication_step).map_err(failed)?;
        } else {
            let (references, before) = self.sloping(call)?;
            let slopes = self.slopes.values();
            let after: Vec<f64> =
                before.iter().zip(slopes).map(|(value, slope)| value + communication_step * slope).collect();
            self.set(call, &references, &after)?;
            if let Err(error) = self.made()?.unit.step(time, communication_step) {
                self.set(call, &references, &before)?;
                return Err(failed(error));
            }
            self.slopes.clear();
        }
        self.time = end;
        Ok(end)
    }

    /// Ends the simulation; results can still be read.
    pub fn terminate(&mut self, call: &'static str) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Step], "no simulation is running: free or reset the instance")?;
        self.mode = Mode::Terminated;
        Ok(())
    }

    /// Returns to the state after instantiation; saved states are kept.
    pub fn reset(&mut self) -> Result<(), ExportError> {
        let packed = numbers_of::<U>(&mut self.packed.parameters);
        if numbers_of::<U>(&mut self.parameters) != packed {
            self.parameters = self.packed.parameters.clone();
            self.made = None;
        }
        if let Some(made) = &mut self.made {
            made.before_outputs = None;
            made.unit.restore_state(&made.new).map_err(failed)?;
        }
        (self.mode, self.time, self.stop_time) = (Mode::Instantiated, 0.0, None);
        self.experiment = (0.0, None);
        self.slopes.clear();
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
        self.expect(call, &[Mode::Step], "derivatives exist only of communication steps, in Step Mode")?;
        let seeds = self.seeds(call, knowns, seed)?;
        let unknown_sizes = self.sizes(call, unknowns, sensitivity.len())?;
        let mut rest = sensitivity;
        let mut last = (TIME, Vec::new());
        for (unknown, size) in unknowns.iter().zip(unknown_sizes) {
            let (own, others) = rest.split_at_mut(size);
            rest = others;
            let (of, first) = match *unknown {
                ELEMENTS.. => (unknown / ELEMENTS, (unknown % ELEMENTS) as usize),
                unknown => (unknown, 0),
            };
            if last.0 != of || of == TIME {
                let mut sum = vec![0.0; if of == TIME { 1 } else { self.variable(of)?.1 }];
                let mut part = sum.clone();
                let unit = &self.made()?.unit;
                for (known, seed) in &seeds {
                    if [of, *known].contains(&TIME) {
                        let (unknown, known) = (of, *known);
                        return Err(CallError::Derivative { unit: U::NAME, unknown, known }.into());
                    }
                    unit.directional_derivative(of, *known, seed, &mut part).map_err(failed)?;
                    sum.iter_mut().zip(&part).for_each(|(sum, part)| *sum += part);
                }
                last = (of, sum);
            }
            own.copy_from_slice(&last.1[first..first + size]);
        }
        Ok(())
    }

    /// The seed of each variable among `knowns`, zero for the single values that are not among them.
    fn seeds(
        &self,
        call: &'static str,
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<(u32, Vec<f64>)>, ExportError> {
        let mut seeds: Vec<(u32, Vec<f64>)> = Vec::new();
        let mut rest = seed;
        for (known, size) in knowns.iter().zip(self.sizes(call, knowns, seed.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            if *known < ELEMENTS {
                seeds.push((*known, own.to_vec()));
                continue;
            }
            let (variable, index) = self.value(*known)?;
            let of = variable.value_reference;
            let place = match seeds.iter().position(|(known, _)| *known == of) {
                Some(place) => place,
                None => {
                    seeds.push((of, vec![0.0; self.variable(of)?.1]));
                    seeds.len() - 1
                }
            };
            seeds[place].1[index] += own[0];
        }
        Ok(seeds)
    }

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

impl<P> Prepared<P> {
    /// The bytes of the file, if there is one.
    fn read(&self) -> Result<Option<Vec<u8>>, ContentsError> {
        match std::fs::read(&self.path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(cause) => Err(ContentsError::Unreadable { path: self.path.clone(), cause }),
        }
    }
}

impl<U: Packable> Made<U> {
    fn new(
        parameters: U::Parameters,
        prepared: &Prepared<U::Parameters>,
        inputs: &BTreeMap<u32, Vec<f64>>,
    ) -> Result<Self, ExportError> {
        let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
        let fits = U::serves(&prepared.parameters, &parameters);
        let mut unit = match if fits { prepared.read()? } else { None } {
            // An error of the parameters is not reported as one of the file.
            Some(bytes) => match U::from_prepared(parameters.clone(), &bytes, threads) {
                Ok(unit) => unit,
                Err(cause) => {
                    U::from_parameters(parameters, threads).map_err(failed)?;
                    let path = prepared.path.clone();
                    return Err(ContentsError::Prepared { path, cause: Box::new(cause) }.into());
                }
            },
            None => U::from_parameters(parameters, threads).map_err(failed)?,
        };
        let new = unit.save_state();
        for (reference, values) in inputs {
            unit.set(*reference, values).map_err(failed)?;
        }
        Ok(Self { unit, new, before_outputs: None })
    }

    /// Initialises the unit and keeps its state before that.
    fn initialise(&mut self, start_time: f64) -> Result<(), ExportError> {
        let before = self.unit.save_state();
        self.unit.initialise(start_time).map_err(failed)?;
        self.before_outputs = Some(before);
        Ok(())
    }
}

fn check_interval(start_time: f64, stop_time: Option<f64>) -> Result<(), ExportError> {
    let stops = stop_time.is_none_or(|stop| stop.is_finite() && stop >= start_time);
    if start_time.is_finite() && stops {
        return Ok(());
    }
    Err(ExportError::Interval { start_time, stop_time: stop_time.unwrap_or(f64::INFINITY) })
}

fn is_input(variable: &Variable) -> bool {
    variable.causality == Causality::Input
}

/// The numbers of all parameters that can be changed, in the order of the variables.
fn numbers_of<U: Packable>(parameters: &mut U::Parameters) -> Vec<f64> {
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
