//! An instance of an FMU of FMI 2.0.

#![allow(unsafe_code)] // functions of C

use super::error::FmuUnitError;
use super::fmi2_library::{Instance2, OK, State, StateFunctions, Status, WARNING, Wanted};
use super::instance::{Experiment, Instance, Said, Value};
use super::model::{Kind, Model};
use super::unpacked::Unpacked;
use std::ffi::{CString, c_int};
use std::path::Path;

pub struct Fmi2 {
    fmu: Instance2,
    said: Said,
    saved: Option<State>,
}

/// Calls a function of the instance.
macro_rules! call {
    ($this:expr, $function:ident $(, $argument:expr)*) => {
        // The arguments are those of the standard; pointers come with the lengths of what they point to.
        unsafe { ($this.fmu.functions.$function)($this.fmu.component() $(, $argument)*) }
    };
}

impl Fmi2 {
    /// Makes an instance called `name`.
    pub fn new(
        library: &Path,
        unpacked: &Unpacked,
        model: &Model,
        name: &str,
        said: Said,
    ) -> Result<Self, FmuUnitError> {
        let wanted = Wanted {
            library,
            folder: unpacked.folder(),
            name,
            guid: &model.token,
            memory: model.wants_memory,
            states: model.saved_state,
            said: &said,
        };
        Ok(Self { fmu: Instance2::new(&wanted)?, said, saved: None })
    }

    fn done(&self, call: &'static str, status: Status) -> Result<(), FmuUnitError> {
        let status = match status {
            OK | WARNING => return Ok(()),
            2 => "fmi2Discard",
            3 => "fmi2Error",
            4 => "fmi2Fatal",
            5 => "fmi2Pending",
            _ => "a status that FMI 2.0 does not have",
        };
        Err(FmuUnitError::Call { call, status, message: self.said.last() })
    }

    fn states(&self) -> Result<StateFunctions, FmuUnitError> {
        self.fmu.states.ok_or(FmuUnitError::NoState)
    }

    /// Saves the state in `state`, which is made if it is null.
    fn save_in(&self, state: &mut State) -> Result<(), FmuUnitError> {
        let get = self.states()?.get;
        self.done("fmi2GetFMUstate", unsafe { get(self.fmu.component(), state) })
    }

    fn set_state(&self, state: State) -> Result<(), FmuUnitError> {
        let set = self.states()?.set;
        self.done("fmi2SetFMUstate", unsafe { set(self.fmu.component(), state) })
    }

    fn free(&self, mut state: State) {
        if let Some(states) = self.fmu.states.filter(|_| !state.is_null()) {
            unsafe { (states.free)(self.fmu.component(), &raw mut state) };
        }
    }

    fn bytes(&self, state: State) -> Result<Vec<u8>, FmuUnitError> {
        let (states, mut size) = (self.states()?, 0);
        let told = unsafe { (states.serialized_size)(self.fmu.component(), state, &raw mut size) };
        self.done("fmi2SerializedFMUstateSize", told)?;
        let mut bytes = vec![0; size];
        let written =
            unsafe { (states.serialize)(self.fmu.component(), state, bytes.as_mut_ptr(), bytes.len()) };
        self.done("fmi2SerializeFMUstate", written)?;
        Ok(bytes)
    }
}

impl Instance for Fmi2 {
    fn set_parameter(&mut self, reference: u32, kind: Kind, value: &Value) -> Result<(), FmuUnitError> {
        let of = &raw const reference;
        let (name, status) = match (kind, value) {
            (Kind::Float64, Value::Numbers(values)) => return self.set(&[reference], values),
            (Kind::Int32, Value::Whole(number)) => {
                let value = *number as c_int;
                ("fmi2SetInteger", call!(self, set_integer, of, 1, &raw const value))
            }
            (Kind::Boolean, Value::Flag(flag)) => {
                let value = c_int::from(*flag);
                ("fmi2SetBoolean", call!(self, set_boolean, of, 1, &raw const value))
            }
            (Kind::String, Value::Text(text)) => {
                // The text of C ends at the first zero.
                let text = CString::new(text.split('\0').next().unwrap_or_default()).unwrap_or_default();
                let value = text.as_ptr();
                ("fmi2SetString", call!(self, set_string, of, 1, &raw const value))
            }
            _ => return Ok(()),
        };
        self.done(name, status)
    }

    fn enter_initialisation(&mut self, experiment: Experiment) -> Result<(), FmuUnitError> {
        let Experiment { start, stop } = experiment;
        let (no_tolerance, tolerance, has_stop) = (0, 0.0, c_int::from(stop.is_some()));
        let told =
            call!(self, setup_experiment, no_tolerance, tolerance, start, has_stop, stop.unwrap_or(0.0));
        self.done("fmi2SetupExperiment", told).map_err(|error| experiment.refused(error))?;
        let entered = call!(self, enter_initialization_mode);
        self.done("fmi2EnterInitializationMode", entered).map_err(|error| experiment.refused(error))
    }

    fn exit_initialisation(&mut self) -> Result<(), FmuUnitError> {
        self.done("fmi2ExitInitializationMode", call!(self, exit_initialization_mode))
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmuUnitError> {
        let count = references.len().min(values.len());
        self.done("fmi2SetReal", call!(self, set_real, references.as_ptr(), count, values.as_ptr()))
    }

    fn get(&mut self, kind: Kind, references: &[u32], values: &mut [f64]) -> Result<(), FmuUnitError> {
        let count = references.len().min(values.len());
        let of = references.as_ptr();
        if kind == Kind::Float64 {
            return self.done("fmi2GetReal", call!(self, get_real, of, count, values.as_mut_ptr()));
        }
        let mut found = vec![0; count];
        let (call, status) = match kind {
            Kind::Boolean => ("fmi2GetBoolean", call!(self, get_boolean, of, count, found.as_mut_ptr())),
            _ => ("fmi2GetInteger", call!(self, get_integer, of, count, found.as_mut_ptr())),
        };
        values.iter_mut().zip(found).for_each(|(value, found)| *value = f64::from(found));
        self.done(call, status)
    }

    fn step(&mut self, time: f64, length: f64) -> Result<(), FmuUnitError> {
        let never_back = c_int::from(self.saved.is_none());
        self.done("fmi2DoStep", call!(self, do_step, time, length, never_back))
    }

    fn save(&mut self) -> Result<(), FmuUnitError> {
        // A state that is there is filled again.
        let mut state = self.saved.unwrap_or(std::ptr::null_mut());
        let saved = self.save_in(&mut state);
        self.saved = Some(state).filter(|state| !state.is_null());
        saved
    }

    fn restore(&mut self) -> Result<(), FmuUnitError> {
        self.set_state(self.saved.ok_or(FmuUnitError::NoState)?)
    }

    fn serialise(&mut self) -> Result<Vec<u8>, FmuUnitError> {
        // Beside the saved state, which stays.
        let mut state = std::ptr::null_mut();
        let bytes = self.save_in(&mut state).and_then(|()| self.bytes(state));
        self.free(state);
        bytes
    }

    fn deserialise(&mut self, bytes: &[u8]) -> Result<(), FmuUnitError> {
        let (states, mut state) = (self.states()?, std::ptr::null_mut());
        let read = unsafe {
            (states.deserialize)(self.fmu.component(), bytes.as_ptr(), bytes.len(), &raw mut state)
        };
        let set = self.done("fmi2DeSerializeFMUstate", read).and_then(|()| self.set_state(state));
        self.free(state);
        set
    }
}

impl Drop for Fmi2 {
    fn drop(&mut self) {
        if let Some(state) = self.saved.take() {
            self.free(state);
        }
    }
}
