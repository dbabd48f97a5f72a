//! An instance of an FMU of FMI 2.0.

use super::error::FmuUnitError;
use super::instance::{Instance, Said, Value};
use super::model::{Kind, Model};
use super::unpacked::Unpacked;
use cofferdam_coupling::participant::Level;
use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::{fmi2FMUstate, fmi2Status};
use fmi_rs::fmi2::{CS, FMU2};
use std::sync::Arc;

pub struct Fmi2 {
    fmu: Arc<FMU2<CS>>,
    said: Said,
    saved: Option<fmi2FMUstate>,
}

struct Listener(Said);

impl Logger for Listener {
    fn log_call(&self, _: fmi2Status, _: &str) {}

    fn log_message(&self, status: fmi2Status, category: &str, message: &str) {
        let level = match status {
            fmi2Status::Ok => Level::Information,
            fmi2Status::Warning => Level::Warning,
            _ => Level::Error,
        };
        self.0.add(level, category, message);
    }
}

impl Fmi2 {
    /// Makes an instance called `name`.
    pub fn new(unpacked: &Unpacked, model: &Model, name: &str, said: Said) -> Result<Self, FmuUnitError> {
        let logger = Arc::new(Listener(said.clone()));
        let fmu = FMU2::<CS>::new(
            unpacked.folder(),
            &model.identifier,
            name,
            &model.token,
            false,
            true,
            false,
            logger,
            model.wants_memory,
        );
        let fmu = fmu.map_err(|error| match error {
            fmi_rs::sim::SimulationError::FMICall => FmuUnitError::NoInstance { message: said.last() },
            other => FmuUnitError::of_library(other),
        })?;
        Ok(Self { fmu, said, saved: None })
    }

    fn done(&self, call: &'static str, status: fmi2Status) -> Result<(), FmuUnitError> {
        let status = match status {
            fmi2Status::Ok | fmi2Status::Warning => return Ok(()),
            fmi2Status::Discard => "fmi2Discard",
            fmi2Status::Error => "fmi2Error",
            fmi2Status::Fatal => "fmi2Fatal",
            fmi2Status::Pending => "fmi2Pending",
        };
        Err(FmuUnitError::Call { call, status, message: self.said.last() })
    }
}

impl Instance for Fmi2 {
    fn set_parameter(&mut self, reference: u32, kind: Kind, value: &Value) -> Result<(), FmuUnitError> {
        let of = [reference];
        let (call, status) = match (kind, value) {
            (Kind::Float64, Value::Numbers(values)) => ("fmi2SetReal", self.fmu.setReal(&of, values)),
            (Kind::Int32, Value::Whole(value)) => {
                ("fmi2SetInteger", self.fmu.setInteger(&of, &[*value as i32]))
            }
            (Kind::Boolean, Value::Flag(value)) => {
                ("fmi2SetBoolean", self.fmu.setBoolean(&of, &[i32::from(*value)]))
            }
            (Kind::String, Value::Text(value)) => ("fmi2SetString", self.fmu.setString(&of, &[value])),
            _ => return Ok(()),
        };
        self.done(call, status)
    }

    fn enter_initialisation(&mut self, start_time: f64) -> Result<(), FmuUnitError> {
        self.done("fmi2SetupExperiment", self.fmu.setupExperiment(None, start_time, None))?;
        self.done("fmi2EnterInitializationMode", self.fmu.enterInitializationMode())
    }

    fn exit_initialisation(&mut self) -> Result<(), FmuUnitError> {
        self.done("fmi2ExitInitializationMode", self.fmu.exitInitializationMode())
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmuUnitError> {
        self.done("fmi2SetReal", self.fmu.setReal(references, values))
    }

    fn get(&mut self, kind: Kind, references: &[u32], values: &mut [f64]) -> Result<(), FmuUnitError> {
        if kind == Kind::Float64 {
            return self.done("fmi2GetReal", self.fmu.getReal(references, values));
        }
        let mut found = vec![0; values.len()];
        let (call, status) = match kind {
            Kind::Boolean => ("fmi2GetBoolean", self.fmu.getBoolean(references, &mut found)),
            _ => ("fmi2GetInteger", self.fmu.getInteger(references, &mut found)),
        };
        values.iter_mut().zip(found).for_each(|(value, found)| *value = f64::from(found));
        self.done(call, status)
    }

    fn step(&mut self, time: f64, length: f64) -> Result<(), FmuUnitError> {
        let never_back = i32::from(self.saved.is_none());
        self.done("fmi2DoStep", self.fmu.doStep(time, length, never_back))
    }

    fn save(&mut self) -> Result<(), FmuUnitError> {
        let mut state = self.saved.unwrap_or(std::ptr::null_mut());
        let status = self.fmu.getFMUstate(&mut state);
        self.saved = Some(state).filter(|state| !state.is_null());
        self.done("fmi2GetFMUstate", status)
    }

    fn restore(&mut self) -> Result<(), FmuUnitError> {
        let state = self.saved.ok_or(FmuUnitError::NoState)?;
        self.done("fmi2SetFMUstate", self.fmu.setFMUstate(state))
    }

    fn serialise(&mut self) -> Result<Vec<u8>, FmuUnitError> {
        // Beside the saved state, which stays.
        let mut state = std::ptr::null_mut();
        let (mut size, mut bytes) = (0, Vec::new());
        let got = self.done("fmi2GetFMUstate", self.fmu.getFMUstate(&mut state));
        let written = got.and_then(|()| {
            self.done("fmi2SerializedFMUstateSize", self.fmu.serializedFMUstateSize(state, &mut size))?;
            bytes.resize(size, 0);
            self.done("fmi2SerializeFMUstate", self.fmu.serializeFMUstate(state, &mut bytes))
        });
        self.fmu.freeFMUstate(&mut state);
        written.map(|()| bytes)
    }

    fn deserialise(&mut self, bytes: &[u8]) -> Result<(), FmuUnitError> {
        let mut state = std::ptr::null_mut();
        let read = self.done("fmi2DeSerializeFMUstate", self.fmu.deSerializeFMUstate(bytes, &mut state));
        let set = read.and_then(|()| self.done("fmi2SetFMUstate", self.fmu.setFMUstate(state)));
        self.fmu.freeFMUstate(&mut state);
        set
    }
}

impl Drop for Fmi2 {
    fn drop(&mut self) {
        if let Some(mut state) = self.saved.take() {
            self.fmu.freeFMUstate(&mut state);
        }
    }
}
