mod derivatives;
mod made;
mod states;
mod values;

use super::{Contents, ExportError, PREPARED, Record};
use crate::{Causality, Fingerprint, Packable, Variable};
use made::{Made, Prepared, failed};
use serde::{Deserialize, Serialize};
use states::{Saved, numbers_of};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

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
            self.set_values(call, &references, &after)?;
            if let Err(error) = self.made()?.unit.step(time, communication_step) {
                self.set_values(call, &references, &before)?;
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
