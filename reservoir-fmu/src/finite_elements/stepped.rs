use super::{FiniteElements, Prepared};
use crate::time_domain::{Memory, TimeDomain};
use nalgebra::DMatrix;
use std::sync::OnceLock;

/// State of the water after a step, and the part of the next step that does not depend on its inputs, once it is asked for: most states
/// of an iteration are given up before.
struct Field {
    values: Vec<f64>,
    prepared: OnceLock<Prepared>,
}

impl Field {
    fn memory(values: Vec<f64>) -> Memory {
        Memory::of(Self { values, prepared: OnceLock::new() })
    }

    fn prepared(&self, water: &FiniteElements) -> &Prepared {
        self.prepared.get_or_init(|| water.prepare(&self.values))
    }
}

impl TimeDomain for FiniteElements {
    fn at_rest(&self) -> Memory {
        Field::memory(vec![0.0; self.state_len()])
    }

    fn pressure(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Option<Vec<f64>> {
        let pressure = |field: &Field| FiniteElements::pressure(self, field.prepared(self), velocity);
        memory.get().map(pressure)
    }

    fn push(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Option<Memory> {
        let field = memory.get::<Field>()?;
        let mut next = vec![0.0; self.state_len()];
        self.advance(&field.values, field.prepared(self), velocity, &mut next);
        Some(Field::memory(next))
    }

    fn instantaneous(&self, _length: f64) -> DMatrix<f64> {
        FiniteElements::instantaneous(self).clone()
    }

    fn values(&self, memory: &Memory) -> Option<Vec<f64>> {
        memory.get().map(|field: &Field| field.values.clone())
    }

    fn resume(&self, values: &[f64], _steps: usize) -> Option<Memory> {
        (values.len() == self.state_len()).then(|| Field::memory(values.to_vec()))
    }
}
