use super::{Channel, Description, Layout, Participant, ParticipantError, check_finite};
use interface::{Causality, CoSimulation, Shape};

/// A unit that is an object of this process.
pub struct InProcess<U: CoSimulation> {
    unit: U,
    description: Description,
    saved: Option<U::State>,
}

impl<U: CoSimulation> InProcess<U> {
    /// Lets `unit` take part; `solver` names it and its version.
    pub fn new(unit: U, solver: &str) -> Self {
        let layout = |causality| {
            let variables = unit.variables().iter().filter(|v| v.causality == causality);
            let channels = variables.map(|v| Channel {
                name: v.name.to_owned(),
                value_reference: v.value_reference,
                unit: v.unit.to_owned(),
                size: unit.size(v),
                array: v.shape != Shape::Scalar,
            });
            Layout::new(channels.filter(|c| c.size > 0).collect())
        };
        let description = Description {
            name: unit.name().to_owned(),
            solver: solver.to_owned(),
            fingerprint: unit.fingerprint(),
            inputs: layout(Causality::Input),
            outputs: layout(Causality::Output),
            capabilities: unit.capabilities(),
        };
        Self { unit, description, saved: None }
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

    fn get_outputs(&self, time: f64, outputs: &mut [f64]) -> Result<(), ParticipantError> {
        for (channel, range) in self.description.outputs.channels() {
            self.unit.get(channel.value_reference, &mut outputs[range]).map_err(|e| self.failed(e))?;
        }
        check_finite(&self.description, outputs, time)
    }
}

impl<U: CoSimulation> Participant for InProcess<U> {
    fn description(&self) -> &Description {
        &self.description
    }

    fn fixed(&self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let found = self.unit.variables().iter().find(|v| v.name == variable).ok_or_else(|| {
            ParticipantError::Missing {
                participant: self.description.name.clone(),
                variable: variable.to_owned(),
            }
        })?;
        let mut values = vec![0.0; self.unit.size(found)];
        self.unit.get(found.value_reference, &mut values).map_err(|e| self.failed(e))?;
        Ok(values)
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.set_inputs(inputs).map_err(|e| self.failed(e))?;
        self.unit.initialise(start_time).map_err(|e| self.failed(e))?;
        self.get_outputs(start_time, outputs)
    }

    fn step(
        &mut self,
        time: f64,
        communication_step: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.set_inputs(inputs).map_err(|e| self.failed(e))?;
        self.unit.step(time, communication_step).map_err(|e| self.failed(e))?;
        self.get_outputs(time + communication_step, outputs)
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.saved = Some(self.unit.save_state());
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        match &self.saved {
            Some(state) => self.unit.restore_state(state).map_err(|e| ParticipantError::Unit {
                participant: self.description.name.clone(),
                cause: Box::new(e),
            }),
            None => Err(ParticipantError::Missing {
                participant: self.description.name.clone(),
                variable: "saved state".to_owned(),
            }),
        }
    }
}
