use super::{FiniteElements, Prepared};
use crate::time_domain::{Memory, TimeDomain};
use nalgebra::DMatrix;

/// State of the water after a step, and the part of the next step that does not depend on its inputs.
struct Field {
    values: Vec<f64>,
    prepared: Prepared,
}

impl FiniteElements {
    fn field(&self, values: Vec<f64>) -> Memory {
        let prepared = self.prepare(&values);
        Memory::of(Field { values, prepared })
    }
}

impl TimeDomain for FiniteElements {
    fn at_rest(&self) -> Memory {
        self.field(vec![0.0; self.state_len()])
    }

    fn pressure(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Option<Vec<f64>> {
        let pressure = |field: &Field| FiniteElements::pressure(self, &field.prepared, velocity);
        memory.get().map(pressure)
    }

    fn push(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Option<Memory> {
        let field = memory.get::<Field>()?;
        let mut next = vec![0.0; self.state_len()];
        self.advance(&field.values, &field.prepared, velocity, &mut next);
        Some(self.field(next))
    }

    fn instantaneous(&self, _length: f64) -> DMatrix<f64> {
        FiniteElements::instantaneous(self).clone()
    }

    fn values(&self, memory: &Memory) -> Option<Vec<f64>> {
        memory.get().map(|field: &Field| field.values.clone())
    }

    fn resume(&self, values: &[f64], _steps: usize) -> Option<Memory> {
        (values.len() == self.state_len()).then(|| self.field(values.to_vec()))
    }
}
