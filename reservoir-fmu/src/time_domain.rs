//! Time stepping of water with a memory: one trait, several methods.

use nalgebra::DMatrix;
use std::any::Any;
use std::sync::Arc;

/// Pressure at the ends of communication steps from the velocities there, which are linear in between.
///
/// [`pressure`](Self::pressure) may be called several times from the same memory, once per trial of a step;
/// [`push`](Self::push) then gives the memory after the accepted step. A memory is never changed, so it can be kept and
/// shared. What is asked of a memory is none for a memory of another method.
///
/// **Shapes and units**: velocities of the interface points along n, then of the ground along x and y
/// (m/s, since the start); pressures at the interface points (Pa); `length` of the step in s.
pub(crate) trait TimeDomain: Send + Sync {
    /// The memory of water at rest.
    fn at_rest(&self) -> Memory;

    /// Pressure at the end of the step of `length` after `memory` if velocities are `velocity` there.
    fn pressure(&self, memory: &Memory, velocity: &[f64], length: f64) -> Option<Vec<f64>>;

    /// The memory after that step.
    fn push(&self, memory: &Memory, velocity: &[f64], length: f64) -> Option<Memory>;

    /// `∂p/∂v` at the end of a step of `length`, points × inputs: exact, as all methods are linear.
    fn instantaneous(&self, length: f64) -> DMatrix<f64>;

    /// All values of a memory, for serialisation.
    fn values(&self, memory: &Memory) -> Option<Vec<f64>>;

    /// The memory with these `values` after `steps` steps, equal bit for bit to the original; none if the number of
    /// values is wrong.
    fn resume(&self, values: &[f64], steps: usize) -> Option<Memory>;
}

/// Memory of the water, in the form of its method; empty for water without memory. Clones share the content.
#[derive(Clone, Default)]
pub(crate) struct Memory(Option<Arc<dyn Any + Send + Sync>>);

impl Memory {
    /// A memory that holds `content`.
    pub fn of(content: impl Any + Send + Sync) -> Self {
        Self(Some(Arc::new(content)))
    }

    /// The content, if it is of type `T`.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.as_deref().and_then(|content| content.downcast_ref())
    }
}
