//! An FMU as a unit: FMI 3.0 or 2.0, for co-simulation.

mod error;
mod fmi2;
mod fmi3;
mod instance;
mod model;
mod unpacked;
mod wiring;

pub use error::FmuUnitError;
pub use unpacked::{UnpackError, sha256_of};

use cofferdam_coupling::participant::{
    Description, Message, Occasion, ParameterValue, Participant, ParticipantError, check_finite,
};
use cofferdam_unit::Role;
use cofferdam_unit::{Capabilities, Fingerprint, StateError, open, seal};
use fmi_rs::model_description::FMIMajorVersion;
use fmi_rs::sim::SimulationError;
use instance::{Instance, Said, Value};
use model::{Kind, Model};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use unpacked::Unpacked;
use wiring::{Run, Wires, Wiring, parameters};

/// An FMU in this process. Its library can do here whatever it likes: `cofferdam run` gives it a process of its own.
pub struct Fmu {
    /// Dropped before the files that it comes from.
    parts: Parts,
    description: Description,
    wiring: Wiring,
    /// All inputs, those of them that may change in every step, and all outputs.
    inputs: Vec<Run>,
    changing: Vec<Run>,
    outputs: Vec<Run>,
    occasion: Occasion,
    /// Start time (s) and inputs of its initialisation.
    started: Option<(f64, Vec<f64>)>,
    busy: Duration,
    messages: Vec<Message>,
    /// How to make another instance.
    maker: Maker,
}

/// What may be called from any thread, but not from two at once.
struct Parts {
    instance: Box<dyn Instance>,
    /// Another instance, initialised without inputs, that tells before initialisation what is fixed.
    preview: Option<Box<dyn Instance>>,
}

#[allow(unsafe_code)] // FMI lets any thread call an instance, one at a time; what instances say goes through a lock
unsafe impl Send for Parts {}

/// What to import.
#[derive(Clone, Copy, Debug)]
pub struct Import<'a> {
    /// The FMU, or the folder of an unpacked one.
    pub file: &'a Path,
    /// Its names for variables of the contract, where they are others.
    pub variables: &'a BTreeMap<String, String>,
    /// Values of its parameters by their names.
    pub parameters: &'a BTreeMap<String, ParameterValue>,
}

/// How an instance is made.
struct Maker {
    name: String,
    model: Model,
    library: PathBuf,
    parameters: Vec<(u32, Kind, Value)>,
    said: Said,
    unpacked: Unpacked,
}

impl Fmu {
    /// An FMU as a unit called `name`, for communication steps of `communication_step` (s), or of any length.
    ///
    /// **Errors**: [`FmuUnitError`], each with what would help.
    pub fn new(
        name: &str,
        role: Role,
        import: Import<'_>,
        communication_step: Option<f64>,
    ) -> Result<Self, FmuUnitError> {
        let unpacked = Unpacked::open(import.file)?;
        let model = Model::read(&unpacked)?;
        let mut wiring = Wiring::find(&model, role, import.variables)?;
        let parameters = parameters(&model, &wiring, import.parameters)?;
        if let (Some(fixed), Some(asked), false) = (model.fixed_step, communication_step, model.variable_step)
        {
            let steps = asked / fixed;
            if !(steps > 0.5 && (steps - steps.round()).abs() < 1e-6 * steps) {
                return Err(FmuUnitError::Step { asked, fixed });
            }
        }
        if model.only_once {
            // There is no second one that could tell them beforehand.
            wiring.readable = Wires::default();
        }
        let folder = match model.version {
            FMIMajorVersion::V2 => "binaries/linux64",
            FMIMajorVersion::V3 => "binaries/x86_64-linux",
        };
        let library = unpacked.folder().join(folder).join(format!("{}.so", model.identifier));
        if !library.is_file() {
            let library = format!("{folder}/{}.so", model.identifier);
            return Err(FmuUnitError::Platform { library, platforms: unpacked.platforms() });
        }
        let version = match model.version {
            FMIMajorVersion::V2 => "2.0",
            FMIMajorVersion::V3 => "3.0",
        };
        let tool = if model.tool.is_empty() { String::new() } else { format!(", by {}", model.tool) };
        let needed = if model.needs_tool { ", which must be installed here" } else { "" };
        let state = if model.saved_state { "" } else { ", without saved states" };
        let idle = match &wiring.idle[..] {
            [] => String::new(),
            idle => format!(", inputs left alone: {}", idle.join(", ")),
        };
        let description = Description {
            name: name.to_owned(),
            solver: format!("FMU {} of FMI {version}{tool}{needed}{state}{idle}", model.name),
            fingerprint: Fingerprint::of("fmu", &(&unpacked.sha256, import.variables, import.parameters))?,
            inputs: wiring.inputs.layout(),
            outputs: wiring.outputs.layout(),
            readable: wiring.readable.layout(),
            capabilities: Capabilities {
                variable_communication_step: model.variable_step,
                directional_derivative: false,
                saved_state: model.saved_state,
            },
        };
        let maker =
            Maker { name: name.to_owned(), model, library, parameters, said: Said::default(), unpacked };
        let instance = maker.instance()?;
        let mut fmu = Self {
            parts: Parts { instance, preview: None },
            inputs: wiring.inputs.runs(),
            changing: wiring.inputs.changing_runs(),
            outputs: wiring.outputs.runs(),
            description,
            wiring,
            occasion: Occasion::default(),
            started: None,
            busy: Duration::ZERO,
            messages: Vec::new(),
            maker,
        };
        fmu.keep_messages();
        Ok(fmu)
    }

    /// Calls it, collects what it says and measures the time.
    fn call<T>(
        &mut self,
        call: impl FnOnce(&mut Self) -> Result<T, FmuUnitError>,
    ) -> Result<T, ParticipantError> {
        let began = Instant::now();
        let result = call(self);
        self.busy += began.elapsed();
        self.keep_messages();
        result.map_err(|cause| ParticipantError::Unit {
            participant: self.description.name.clone(),
            cause: Box::new(cause),
        })
    }

    /// Initialises the instance.
    fn start(&mut self, time: f64, inputs: &[f64]) -> Result<(), FmuUnitError> {
        let Parts { instance, preview } = &mut self.parts;
        *preview = None;
        instance.enter_initialisation(time)?;
        set(&mut **instance, &self.inputs, inputs)?;
        instance.exit_initialisation()?;
        self.started = Some((time, inputs.to_vec()));
        Ok(())
    }

    fn keep_messages(&mut self) {
        let Occasion { step, iteration, time, .. } = self.occasion;
        let unit = &self.description.name;
        self.messages.extend(self.maker.said.take().into_iter().map(|(level, source, text)| Message {
            unit: unit.clone(),
            level,
            step,
            iteration,
            time,
            source,
            text,
        }));
    }
}

/// Sets the real variables of these runs to their part of `values`.
fn set(instance: &mut dyn Instance, runs: &[Run], values: &[f64]) -> Result<(), FmuUnitError> {
    runs.iter().try_for_each(|run| instance.set(&run.references, &values[run.values.clone()]))
}

/// Reads the variables of these runs into their part of `values`.
fn get(instance: &mut dyn Instance, runs: &[Run], values: &mut [f64]) -> Result<(), FmuUnitError> {
    runs.iter().try_for_each(|run| instance.get(run.kind, &run.references, &mut values[run.values.clone()]))
}

impl Maker {
    /// Another instance, with its parameters set.
    fn instance(&self) -> Result<Box<dyn Instance>, FmuUnitError> {
        let (model, said) = (&self.model, self.said.clone());
        let mut instance: Box<dyn Instance> = match model.version {
            FMIMajorVersion::V2 => Box::new(fmi2::Fmi2::new(&self.unpacked, model, &self.name, said)?),
            FMIMajorVersion::V3 => {
                Box::new(fmi3::Fmi3::new(&self.library, &self.unpacked, model, &self.name, said)?)
            }
        };
        for (reference, kind, value) in &self.parameters {
            instance.set_parameter(*reference, *kind, value)?;
        }
        Ok(instance)
    }
}

impl FmuUnitError {
    /// What hinders a library from being loaded, and what may help.
    fn of_library(error: SimulationError) -> Self {
        let cause = match error {
            // What the system said stands below "dlopen failed".
            SimulationError::Library { source, .. } => {
                source.source().map_or_else(|| source.to_string(), ToString::to_string)
            }
            SimulationError::Symbol { name, .. } => {
                let (cause, remedy) = (format!("it lacks the function {name}"), "FMI asks for all functions");
                return Self::Library { cause, remedy };
            }
            other => other.to_string(),
        };
        let remedy = if cause.contains("undefined symbol: Py") || cause.contains("undefined symbol: _Py") {
            "it runs in a Python process alone: set LD_PRELOAD to the library of that Python (libpython3.….so), or let its code \
             serve as a process, fidelity \"command\""
        } else if cause.contains("cannot open shared object file") {
            "install what it names, or export it again with that inside"
        } else if cause.contains("failed to map segment") {
            "set TMPDIR to a folder from which programs may run"
        } else {
            "export it again for this machine"
        };
        Self::Library { cause, remedy }
    }
}

impl Participant for Fmu {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let wire = self.wiring.readable.find(variable);
        let wire = wire.ok_or_else(|| self.description.missing(variable))?;
        let (kind, references) = (wire.kind, wire.references.clone());
        let mut values = vec![0.0; wire.channel.size];
        self.call(|this| {
            if this.started.is_some() {
                return this.parts.instance.get(kind, &references, &mut values);
            }
            if this.parts.preview.is_none() {
                let mut preview = this.maker.instance()?;
                preview.enter_initialisation(0.0)?;
                preview.exit_initialisation()?;
                this.parts.preview = Some(preview);
            }
            this.parts.preview.as_mut().map_or(Ok(()), |preview| preview.get(kind, &references, &mut values))
        })?;
        Ok(values)
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.occasion = Occasion::initialisation(start_time);
        self.call(|this| {
            this.start(start_time, inputs)?;
            get(&mut *this.parts.instance, &this.outputs, outputs)
        })?;
        check_finite(&self.description, outputs, start_time)
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.occasion = *occasion;
        self.call(|this| {
            set(&mut *this.parts.instance, &this.changing, inputs)?;
            this.parts.instance.step(occasion.time, occasion.communication_step)?;
            get(&mut *this.parts.instance, &this.outputs, outputs)
        })?;
        check_finite(&self.description, outputs, occasion.end())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        // An explicit scheme never returns to it.
        if !self.description.capabilities.saved_state {
            return Ok(());
        }
        self.call(|this| this.parts.instance.save())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.call(|this| this.parts.instance.restore())
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let Some(started) = self.started.clone().filter(|_| self.maker.model.state_as_bytes) else {
            return Ok(None);
        };
        let state = self.call(|this| this.parts.instance.serialise())?;
        let sealed = seal(self.description.fingerprint, &(started, state));
        sealed.map(Some).map_err(|cause| self.description.no_state(cause))
    }

    /// FMI lets a state be set in an instance that is initialised: a new one is, as the one was that gave the state.
    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        if !self.maker.model.state_as_bytes {
            return Err(ParticipantError::NotSerialised { participant: self.description.name.clone() });
        }
        let read = open(self.description.fingerprint, state);
        let ((time, inputs), own): ((f64, Vec<f64>), Vec<u8>) =
            read.map_err(|cause| self.description.no_state(cause))?;
        if inputs.len() != self.description.inputs.size() {
            return Err(self.description.no_state(StateError::NotAState { length: state.len() }));
        }
        self.occasion = Occasion::initialisation(time);
        self.call(|this| {
            if this.started.is_none() {
                this.start(time, &inputs)?;
            }
            this.parts.instance.deserialise(&own)
        })
    }

    fn busy(&self) -> Duration {
        self.busy
    }

    fn messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }
}
