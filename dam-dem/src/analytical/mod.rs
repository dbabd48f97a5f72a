//! Closed-form solutions. Nothing here calls the solver.

pub mod cantilever;
pub mod joint_waves;
pub mod layered_column;
pub mod newmark_1965;
pub mod vibration;
