//! Constant-strain triangles, four to a cell.

mod batch;
mod cst;
mod evaluation;
mod parts;

pub use batch::ViscousStress;
pub use cst::CrossedCells;
