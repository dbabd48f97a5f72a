//! Constant-strain triangles, four to a cell.

mod cst;
mod lanes;

pub use cst::{CrossedCells, ViscousStress};
