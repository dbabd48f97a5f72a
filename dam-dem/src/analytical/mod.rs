//! Closed-form answers. Nothing here calls the solver.

pub mod newmark_1965;
pub mod vibration;
