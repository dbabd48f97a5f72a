//! Time integration, and solution of the static equilibrium.

mod central_difference;
mod dynamic_relaxation;
mod newton;

pub use central_difference::CentralDifference;
pub use dynamic_relaxation::{DynamicRelaxation, Relaxed};
pub use newton::SparseNewton;
