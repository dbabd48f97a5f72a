//! An instance of an FMU of FMI 3.0.

use super::error::FmuUnitError;
use super::instance::{Experiment, Instance, Said, Value};
use super::model::{Kind, Model};
use super::unpacked::Unpacked;
use cofferdam_coupling::participant::Level;
use fmi_rs::fmi3::FMU3;
use fmi_rs::fmi3::log::Logger;
use fmi_rs::fmi3::native::NativeLibrary;
use fmi_rs::fmi3::types::{fmi3FMUState, fmi3Status};
use std::path::Path;
use std::sync::Arc;

pub struct Fmi3 {
    fmu: Arc<FMU3>,
    said: Said,
    saved: Option<fmi3FMUState>,
}

struct Listener(Said);

impl Logger for Listener {
    fn log_call(&self, _: fmi3Status, _: &str) {}

    fn log_message(&self, status: fmi3Status, category: &str, message: &str) {
        let level = match status {
            fmi3Status::Ok => Level::Information,
            fmi3Status::Warning => Level::Warning,
            _ => Level::Error,
        };
        self.0.add(level, category, message);
    }
}

impl Fmi3 {
    /// Makes an instance called `name`, without events and early returns.
    pub fn new(
        library: &Path,
        unpacked: &Unpacked,
        model: &Model,
        name: &str,
        said: Said,
    ) -> Result<Self, FmuUnitError> {
        let library = NativeLibrary::load(library).map_err(FmuUnitError::of_library)?;
        let resources = Some(unpacked.folder().join("resources")).filter(|folder| folder.is_dir());
        let logger = Arc::new(Listener(said.clone()));
        let fmu = FMU3::instantiateCoSimulation(
            Box::new(library),
            resources.as_deref(),
            name,
            &model.token,
            false,
            true,
            false,
            false,
            logger,
            false,
            None,
        );
        let fmu = fmu.map_err(|_| FmuUnitError::NoInstance { message: said.last() })?;
        Ok(Self { fmu, said, saved: None })
    }

    fn done(&self, call: &'static str, status: fmi3Status) -> Result<(), FmuUnitError> {
        let status = match status {
            fmi3Status::Ok | fmi3Status::Warning => return Ok(()),
            fmi3Status::Discard => "fmi3Discard",
            fmi3Status::Error => "fmi3Error",
            fmi3Status::Fatal => "fmi3Fatal",
        };
        Err(FmuUnitError::Call { call, status, message: self.said.last() })
    }
}

impl Instance for Fmi3 {
    fn set_parameter(&mut self, reference: u32, kind: Kind, value: &Value) -> Result<(), FmuUnitError> {
        let fmu = &self.fmu;
        let of = [reference];
        let (call, status) = match (kind, value) {
            (Kind::Float64, Value::Numbers(values)) => ("fmi3SetFloat64", fmu.setFloat64(&of, values)),
            (Kind::Float32, Value::Numbers(values)) => {
                let values: Vec<f32> = values.iter().map(|value| *value as f32).collect();
                ("fmi3SetFloat32", fmu.setFloat32(&of, &values))
            }
            (Kind::Int8, Value::Whole(value)) => ("fmi3SetInt8", fmu.setInt8(&of, &[*value as i8])),
            (Kind::UInt8, Value::Whole(value)) => ("fmi3SetUInt8", fmu.setUInt8(&of, &[*value as u8])),
            (Kind::Int16, Value::Whole(value)) => ("fmi3SetInt16", fmu.setInt16(&of, &[*value as i16])),
            (Kind::UInt16, Value::Whole(value)) => ("fmi3SetUInt16", fmu.setUInt16(&of, &[*value as u16])),
            (Kind::Int32, Value::Whole(value)) => ("fmi3SetInt32", fmu.setInt32(&of, &[*value as i32])),
            (Kind::UInt32, Value::Whole(value)) => ("fmi3SetUInt32", fmu.setUInt32(&of, &[*value as u32])),
            (Kind::Int64, Value::Whole(value)) => ("fmi3SetInt64", fmu.setInt64(&of, &[*value])),
            (Kind::UInt64, Value::Whole(value)) => ("fmi3SetUInt64", fmu.setUInt64(&of, &[*value as u64])),
            (Kind::Boolean, Value::Flag(value)) => ("fmi3SetBoolean", fmu.setBoolean(&of, &[*value])),
            (Kind::String, Value::Text(value)) => ("fmi3SetString", fmu.setString(&of, &[value])),
            _ => return Ok(()),
        };
        self.done(call, status)
    }

    fn enter_initialisation(&mut self, experiment: Experiment) -> Result<(), FmuUnitError> {
        let entered = self.fmu.enterInitializationMode(None, experiment.start, experiment.stop);
        self.done("fmi3EnterInitializationMode", entered).map_err(|error| experiment.refused(error))
    }

    fn exit_initialisation(&mut self) -> Result<(), FmuUnitError> {
        self.done("fmi3ExitInitializationMode", self.fmu.exitInitializationMode())
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmuUnitError> {
        self.done("fmi3SetFloat64", self.fmu.setFloat64(references, values))
    }

    fn get(&mut self, kind: Kind, references: &[u32], values: &mut [f64]) -> Result<(), FmuUnitError> {
        let size = values.len();
        let (call, status) = match kind {
            Kind::Boolean => {
                let mut found = vec![false; size];
                let status = self.fmu.getBoolean(references, &mut found);
                values.iter_mut().zip(found).for_each(|(value, found)| *value = f64::from(u8::from(found)));
                ("fmi3GetBoolean", status)
            }
            Kind::Int32 => {
                let mut found = vec![0; size];
                let status = self.fmu.getInt32(references, &mut found);
                values.iter_mut().zip(found).for_each(|(value, found)| *value = f64::from(found));
                ("fmi3GetInt32", status)
            }
            Kind::Int64 => {
                let mut found = vec![0; size];
                let status = self.fmu.getInt64(references, &mut found);
                values.iter_mut().zip(found).for_each(|(value, found)| *value = found as f64);
                ("fmi3GetInt64", status)
            }
            _ => ("fmi3GetFloat64", self.fmu.getFloat64(references, values)),
        };
        self.done(call, status)
    }

    fn step(&mut self, time: f64, length: f64) -> Result<(), FmuUnitError> {
        let (mut event, mut terminate, mut early, mut reached) = (false, false, false, time + length);
        let repeated = self.saved.is_some();
        let status =
            self.fmu.doStep(time, length, !repeated, &mut event, &mut terminate, &mut early, &mut reached);
        self.done("fmi3DoStep", status)?;
        if terminate {
            return Err(FmuUnitError::Terminated { time: reached, message: self.said.last() });
        }
        if early {
            return Err(FmuUnitError::Early { reached, end: time + length });
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), FmuUnitError> {
        // A state that is there is filled again.
        let mut state = self.saved.unwrap_or(std::ptr::null_mut());
        let status = self.fmu.getFMUState(&mut state);
        self.saved = Some(state).filter(|state| !state.is_null());
        self.done("fmi3GetFMUState", status)
    }

    fn restore(&mut self) -> Result<(), FmuUnitError> {
        let state = self.saved.ok_or(FmuUnitError::NoState)?;
        self.done("fmi3SetFMUState", self.fmu.setFMUState(state))
    }

    fn serialise(&mut self) -> Result<Vec<u8>, FmuUnitError> {
        // Beside the saved state, which stays.
        let mut state = std::ptr::null_mut();
        let (mut size, mut bytes) = (0, Vec::new());
        let got = self.done("fmi3GetFMUState", self.fmu.getFMUState(&mut state));
        let written = got.and_then(|()| {
            self.done("fmi3SerializedFMUStateSize", self.fmu.serializedFMUStateSize(state, &mut size))?;
            bytes.resize(size, 0);
            self.done("fmi3SerializeFMUState", self.fmu.serializeFMUState(state, &mut bytes))
        });
        self.fmu.freeFMUState(&mut state);
        written.map(|()| bytes)
    }

    fn deserialise(&mut self, bytes: &[u8]) -> Result<(), FmuUnitError> {
        let mut state = std::ptr::null_mut();
        let read = self.done("fmi3DeserializeFMUState", self.fmu.deserializeFMUState(bytes, &mut state));
        let set = read.and_then(|()| self.done("fmi3SetFMUState", self.fmu.setFMUState(state)));
        self.fmu.freeFMUState(&mut state);
        set
    }
}

impl Drop for Fmi3 {
    fn drop(&mut self) {
        if let Some(mut state) = self.saved.take() {
            self.fmu.freeFMUState(&mut state);
        }
    }
}
