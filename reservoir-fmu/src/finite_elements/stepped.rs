use super::{FiniteElements, Prepared};
use crate::time_domain::{Memory, TimeDomain};
use nalgebra::DMatrix;
use std::sync::Arc;

/// The water after a step, and the next step as far as it does not depend on what comes.
pub(crate) struct Field {
    values: Vec<f64>,
    prepared: Prepared,
}

impl FiniteElements {
    fn field(&self, values: Vec<f64>) -> Memory {
        let prepared = self.prepare(&values);
        Memory::Field(Arc::new(Field { values, prepared }))
    }
}

impl TimeDomain for FiniteElements {
    fn at_rest(&self) -> Memory {
        self.field(vec![0.0; self.state_len()])
    }

    fn pressure(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Vec<f64> {
        match memory {
            Memory::Field(field) => FiniteElements::pressure(self, &field.prepared, velocity),
            _ => Vec::new(),
        }
    }

    fn push(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Memory {
        let Memory::Field(field) = memory else { return Memory::None };
        let mut next = vec![0.0; self.state_len()];
        self.advance(&field.values, &field.prepared, velocity, &mut next);
        self.field(next)
    }

    fn instantaneous(&self, _length: f64) -> DMatrix<f64> {
        FiniteElements::instantaneous(self).clone()
    }

    fn values(&self, memory: &Memory) -> Vec<f64> {
        match memory {
            Memory::Field(field) => field.values.clone(),
            _ => Vec::new(),
        }
    }

    fn resume(&self, values: &[f64], _steps: usize) -> Option<Memory> {
        (values.len() == self.state_len()).then(|| self.field(values.to_vec()))
    }
}
