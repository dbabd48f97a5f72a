//! Constant-strain triangles, four to a cell.

mod batch;
mod cst;
mod evaluation;
mod lanes;
mod parts;

pub use batch::ViscousStress;
pub use cst::CrossedCells;
