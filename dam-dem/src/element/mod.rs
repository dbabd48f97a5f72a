//! Constant-strain triangles, four to a cell.

mod batch;
mod cst;
mod evaluation;
mod lanes;

pub use cst::{CrossedCells, ViscousStress};
