use super::{
    Channel, Description, Layout, Message, Messages, Occasion, Participant, ParticipantError, check_finite,
};
use cofferdam_unit::{Causality, CoSimulation};
use std::time::{Duration, Instant};

/// A unit in this process.
pub struct InProcess<U: CoSimulation> {
    unit: U,
    /// The state in which it was given.
    new: U::State,
    description: Description,
    saved: Option<U::State>,
    busy: Duration,
    /// Occasion of the last call.
    occasion: Occasion,
    heard: Messages,
    messages: Vec<Message>,
}

impl<U: CoSimulation> InProcess<U> {
    /// Wraps `unit`; `solver` is its name and version, `heard` holds its messages from before.
    pub fn new(unit: U, solver: &str, heard: Messages) -> Self {
        let layout = |causalities: &[Causality]| {
            let variables = unit.variables().iter().filter(|v| causalities.contains(&v.causality));
            let channels = variables.map(|v| Channel {
                name: v.name.to_owned(),
                value_reference: v.value_reference,
                unit: v.unit.to_owned(),
                size: unit.size(v),
                shape: v.shape.into(),
            });
            Layout::new(channels.filter(|c| c.size > 0).collect())
        };
        let description = Description {
            name: unit.name().to_owned(),
            solver: solver.to_owned(),
            fingerprint: unit.fingerprint(),
            inputs: layout(&[Causality::Input]),
            outputs: layout(&[Causality::Output]),
            readable: layout(&[Causality::Parameter, Causality::CalculatedParameter, Causality::Local]),
            capabilities: unit.capabilities(),
        };
        let (busy, occasion) = (Duration::ZERO, Occasion::initialisation(0.0));
        let (new, messages) = (unit.save_state(), Vec::new());
        let mut wrapped = Self { unit, new, description, saved: None, busy, occasion, heard, messages };
        wrapped.keep_messages();
        wrapped
    }

    /// Calls the unit, collects its messages and measures the time of the call.
    fn call<T>(&mut self, call: impl FnOnce(&mut Self) -> T) -> T {
        let began = Instant::now();
        let heard = self.heard.clone();
        let result = heard.listen(|| call(self));
        self.busy += began.elapsed();
        self.keep_messages();
        result
    }

    fn keep_messages(&mut self) {
        let Occasion { step, iteration, time, .. } = self.occasion;
        let unit = &self.description.name;
        self.messages.extend(self.heard.take().into_iter().map(|(level, source, text)| Message {
            unit: unit.clone(),
            level,
            step,
            iteration,
            time,
            source,
            text,
        }));
    }

    fn failed(&self, error: U::Error) -> ParticipantError {
        ParticipantError::Unit { participant: self.description.name.clone(), cause: Box::new(error) }
    }

    fn set_inputs(&mut self, inputs: &[f64]) -> Result<(), U::Error> {
        for (channel, range) in self.description.inputs.channels() {
            self.unit.set(channel.value_reference, &inputs[range])?;
        }
        Ok(())
    }

    fn get_outputs(&self, outputs: &mut [f64]) -> Result<(), U::Error> {
        for (channel, range) in self.description.outputs.channels() {
            self.unit.get(channel.value_reference, &mut outputs[range])?;
        }
        Ok(())
    }
}

impl<U: CoSimulation> Participant for InProcess<U> {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let (variable, size) = self.description.find_readable(variable)?;
        let mut values = vec![0.0; size];
        let result = self.call(|this| this.unit.get(variable, &mut values));
        result.map_err(|e| self.failed(e))?;
        Ok(values)
    }

    fn read_at(&mut self, variable: &str, places: &[usize]) -> Result<Vec<f64>, ParticipantError> {
        let (variable, _) = self.description.find_readable(variable)?;
        let mut values = vec![0.0; places.len()];
        let result = self.call(|this| this.unit.get_at(variable, places, &mut values));
        result.map_err(|e| self.failed(e))?;
        Ok(values)
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.occasion = Occasion::initialisation(start_time);
        let result = self.call(|this| {
            this.set_inputs(inputs)?;
            this.unit.initialise(start_time)?;
            this.get_outputs(outputs)
        });
        result.map_err(|e| self.failed(e))?;
        check_finite(&self.description, outputs, start_time)
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.occasion = *occasion;
        let result = self.call(|this| {
            this.set_inputs(inputs)?;
            this.unit.step(occasion.time, occasion.communication_step)?;
            this.get_outputs(outputs)
        });
        result.map_err(|e| self.failed(e))?;
        check_finite(&self.description, outputs, occasion.end())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.saved = Some(self.call(|this| this.unit.save_state()));
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        let Some(state) = self.saved.take() else {
            let participant = self.description.name.clone();
            return Err(ParticipantError::Missing { participant, variable: "saved state".to_owned() });
        };
        let result = self.call(|this| this.unit.restore_state(&state));
        self.saved = Some(state);
        result.map_err(|e| self.failed(e))
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let bytes = self.call(|this| this.unit.serialise_state(&this.unit.save_state()));
        bytes.map(Some).map_err(|e| self.failed(e))
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        let result = self.call(|this| {
            let state = this.unit.deserialise_state(state)?;
            // What it keeps of its attempts besides its state belongs to another past.
            this.unit.restore_state(&this.new)?;
            this.unit.restore_state(&state)
        });
        result.map_err(|e| self.failed(e))
    }

    fn busy(&self) -> Duration {
        self.busy
    }

    fn messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }
}
