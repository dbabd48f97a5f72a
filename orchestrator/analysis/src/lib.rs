//! Series of runs and their statistics.

pub mod statistics;
