//! An FMU as a unit: FMI 3.0 or 2.0, for co-simulation.

mod error;
mod fmi2;
mod fmi2_library;
mod fmi3;
mod instance;
mod model;
mod naming;
mod surroundings;
mod text;
mod unpacked;
mod wiring;

pub use error::FmuUnitError;
pub use unpacked::{UnpackError, sha256_of};

use cofferdam_coupling::participant::{
    Description, Level, Message, Occasion, ParameterValue, Participant, ParticipantError, VariableNames,
    check_finite,
};
use cofferdam_unit::Role;
use cofferdam_unit::{Capabilities, Fingerprint, StateError, open, seal};
use fmi_rs::model_description::FMIMajorVersion;
use fmi_rs::sim::SimulationError;
use instance::{Experiment, Instance, Said, Value};
use model::{Kind, Model};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use surroundings::{Arithmetic, Changes, Surroundings};
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
    /// What its library changed, of which a warning was given.
    warned: Changes,
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
    pub variables: &'a BTreeMap<String, VariableNames>,
    /// Values of its parameters by their names.
    pub parameters: &'a BTreeMap<String, ParameterValue>,
    /// Planned end of the run, s, which it is told; none if that is not known.
    pub stop_time: Option<f64>,
}

/// How an instance is made.
struct Maker {
    name: String,
    model: Model,
    library: PathBuf,
    parameters: Vec<(u32, Kind, Value)>,
    said: Said,
    unpacked: Unpacked,
    stop: Option<f64>,
}

/// Share of a step by which its end may lie beyond that of the run by rounding.
const ROUNDING: f64 = 1e-9;

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
        let mut model = Model::read(&unpacked)?;
        let mut wiring = Wiring::find(&mut model, role, import.variables)?;
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
        let early = model.stop_time.zip(import.stop_time).filter(|(own, asked)| *own < asked * (1.0 - 1e-9));
        let stop = import.stop_time;
        let said = Said::default();
        let maker = Maker { name: name.to_owned(), model, library, parameters, said, unpacked, stop };
        let before = Surroundings::now();
        let instance = maker.instance();
        let changes = before.restore();
        let mut fmu = Self {
            parts: Parts { instance: instance?, preview: None },
            inputs: wiring.inputs.runs(),
            changing: wiring.inputs.changing_runs(),
            outputs: wiring.outputs.runs(),
            description,
            wiring,
            occasion: Occasion::default(),
            started: None,
            busy: Duration::ZERO,
            messages: Vec::new(),
            warned: Changes::new(),
            maker,
        };
        if let Some((own, asked)) = early {
            fmu.warn(
                "default experiment",
                format!(
                    "its modelDescription.xml tells of an experiment that stops at t = {own} s, and the run ends at t = {asked} s; make \
                     sure that it goes so far, or set `time.duration` to {own}"
                ),
            );
        }
        fmu.warn_of(changes);
        fmu.keep_messages();
        Ok(fmu)
    }

    /// Calls it, restores what it changes of the process, collects what it says and measures the time.
    fn call<T>(
        &mut self,
        call: impl FnOnce(&mut Self) -> Result<T, FmuUnitError>,
    ) -> Result<T, ParticipantError> {
        let before = Surroundings::now();
        self.call_within(call, || before.restore())
    }

    /// The same for a call that is made at every iteration and does little: restores the arithmetic alone.
    fn call_briefly<T>(
        &mut self,
        call: impl FnOnce(&mut Self) -> Result<T, FmuUnitError>,
    ) -> Result<T, ParticipantError> {
        let before = Arithmetic::now();
        self.call_within(call, || before.restore())
    }

    fn call_within<T>(
        &mut self,
        call: impl FnOnce(&mut Self) -> Result<T, FmuUnitError>,
        restore: impl FnOnce() -> Changes,
    ) -> Result<T, ParticipantError> {
        let began = Instant::now();
        let result = call(self);
        let changes = restore();
        self.busy += began.elapsed();
        self.warn_of(changes);
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
        instance.enter_initialisation(Experiment { start: time, stop: self.maker.stop })?;
        set(&mut **instance, &self.inputs, inputs)?;
        instance.exit_initialisation()?;
        self.started = Some((time, inputs.to_vec()));
        Ok(())
    }

    /// Warns of each thing once that its library changes of the process.
    fn warn_of(&mut self, changes: Changes) {
        for change in changes {
            // Whatever it changes to.
            let kind = change.split(',').next().unwrap_or_default().to_owned();
            if self.warned.insert(kind) {
                let name = &self.maker.model.name;
                let text =
                    format!("the library of FMU {name} changed {change}; that is restored after each call");
                self.warn("process state", text);
            }
        }
    }

    fn warn(&mut self, source: &str, text: String) {
        let Occasion { step, iteration, time, .. } = self.occasion;
        let (unit, source) = (self.description.name.clone(), source.to_owned());
        self.messages.push(Message { unit, level: Level::Warning, step, iteration, time, source, text });
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
            FMIMajorVersion::V2 => {
                Box::new(fmi2::Fmi2::new(&self.library, &self.unpacked, model, &self.name, said)?)
            }
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

/// Length of the step of `occasion`, s. A unit may refuse one that passes the end `stop` by rounding alone, so that one ends there.
fn until(stop: Option<f64>, occasion: &Occasion) -> f64 {
    let length = occasion.communication_step;
    match stop.map(|stop| (stop - occasion.time, occasion.end() - stop)) {
        Some((rest, beyond)) if beyond > 0.0 && beyond < ROUNDING * length => rest,
        _ => length,
    }
}

impl FmuUnitError {
    /// What hinders a library of FMI 3.0 from being loaded.
    fn of_library(error: SimulationError) -> Self {
        match error {
            SimulationError::Library { source, .. } => Self::of_loading(&source),
            SimulationError::Symbol { name, .. } => Self::without_function(&name),
            other => Self::Library { cause: other.to_string(), remedy: "export it again for this machine" },
        }
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
                preview.enter_initialisation(Experiment { start: 0.0, stop: this.maker.stop })?;
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
            this.parts.instance.step(occasion.time, until(this.maker.stop, occasion))?;
            get(&mut *this.parts.instance, &this.outputs, outputs)
        })?;
        check_finite(&self.description, outputs, occasion.end())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        // An explicit scheme never returns to it.
        if !self.description.capabilities.saved_state {
            return Ok(());
        }
        self.call_briefly(|this| this.parts.instance.save())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.call_briefly(|this| this.parts.instance.restore())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// For any number of steps of any length, the last step ends at the end as it is told, to the bit.
    #[test]
    fn last_step_ends_at_the_end() {
        let mut passed = 0;
        for length in [0.0025, 0.01, 1.0 / 3.0, 0.1, 7e-4] {
            for steps in 1..3000_u32 {
                let stop = f64::from(steps) * length;
                let time = f64::from(steps - 1) * length;
                let occasion = Occasion { time, communication_step: length, ..Occasion::default() };
                passed += u32::from(occasion.end() > stop);
                let taken = until(Some(stop), &occasion);
                assert!(time + taken <= stop && (taken - length).abs() < 1e-9 * length, "{steps} {length}");
            }
        }
        assert!(passed > 100, "{passed} would have passed it");
        // What is beyond it by more is the caller's wish.
        let beyond = Occasion { time: 1.0, communication_step: 0.1, ..Occasion::default() };
        assert_eq!([until(Some(1.0), &beyond), until(Some(1.05), &beyond), until(None, &beyond)], [0.1; 3]);
    }
}
