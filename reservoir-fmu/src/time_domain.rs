//! How water with a memory is stepped: one trait, several methods.
//!
//! Depends on the memories of `convolution`, `finite_elements` and `rational`.

use crate::convolution::History;
use crate::finite_elements::Field;
use crate::rational::State;
use nalgebra::DMatrix;
use std::sync::Arc;

/// Pressure at the ends of communication steps from the velocities there, which are linear in between.
///
/// A step is asked for several times from the same memory, and taken once: [`pressure`](Self::pressure)
/// answers, [`push`](Self::push) goes on. A memory is never changed, so that it can be kept and shared.
///
/// **Shapes and units**: velocities of the interface points along n, then of the ground along x and y
/// (m/s, since the start); pressures at the interface points (Pa); `length` of the step in s.
pub(crate) trait TimeDomain: Send + Sync {
    /// The memory of water at rest.
    fn at_rest(&self) -> Memory;

    /// Pressure at the end of the step of `length` after `memory` if velocities are `velocity` there.
    fn pressure(&self, memory: &Memory, velocity: &[f64], length: f64) -> Vec<f64>;

    /// The memory after that step.
    fn push(&self, memory: &Memory, velocity: &[f64], length: f64) -> Memory;

    /// `∂p/∂v` at the end of a step of `length`, points × inputs: exact, as all methods are linear.
    fn instantaneous(&self, length: f64) -> DMatrix<f64>;

    /// All that a memory holds, to be written.
    fn values(&self, memory: &Memory) -> Vec<f64>;

    /// The memory that holds `values` after `steps` steps, equal bit for bit; none if there are not as many
    /// values as there should be.
    fn resume(&self, values: &[f64], steps: usize) -> Option<Memory>;
}

/// What water remembers, in the form of its method. A clone shares what is long.
#[derive(Clone, Default)]
pub(crate) enum Memory {
    /// Of water without memory.
    #[default]
    None,
    /// Velocities of all steps.
    History(History),
    /// States of a recursion.
    State(Arc<State>),
    /// Pressures at the nodes of finite elements.
    Field(Arc<Field>),
}
