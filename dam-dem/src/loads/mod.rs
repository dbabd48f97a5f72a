//! External forces on the dam: one file for each load.

mod anchor;
mod constant;
pub(crate) mod face;
mod fixed;
mod ice;
mod inertia;
mod silt;
mod surcharge;
mod tailwater;
mod uplift;
mod water;
mod weight;

use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use std::fmt::Debug;
use std::sync::Arc;

pub use anchor::Anchor;
pub(crate) use constant::Constant;
pub use constant::StaticLoad;
pub use ice::Ice;
pub(crate) use inertia::Inertia;
pub use silt::Silt;
pub use surcharge::Surcharge;
pub use tailwater::StillTailwater;
pub(crate) use uplift::{Joints, Opened, water_at};
pub(crate) use water::Water;
pub(crate) use weight::Weight;

pub(crate) use crate::load_basis::LoadBasis;
pub use crate::wet::PressureLoad;

/// External nodal forces that vary linearly over a communication step, N/m.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadPath {
    /// Forces at its start.
    pub start: Vec<[f64; 2]>,
    /// Forces at its end minus those at its start.
    pub change: Vec<[f64; 2]>,
}

impl LoadPath {
    /// Forces that do not vary.
    pub fn constant(forces: Vec<[f64; 2]>) -> Self {
        Self { change: vec![[0.0; 2]; forces.len()], start: forces }
    }
}

/// What acts on the dam at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Acting {
    /// Pressure at the interface points, hydrostatic pressure included, Pa.
    pub pressure: Vec<f64>,
    /// Acceleration of the ground, m/s².
    pub ground_acceleration: [f64; 2],
    /// Pressure of the water in the joints, at each of their contacts, Pa.
    pub uplift: Vec<f64>,
}

/// One load: nodal forces `F = B a`, linear in amplitudes a that vary over time.
pub(crate) trait Load: Debug + Send + Sync {
    /// The spatial basis B, which modes project.
    fn basis(&self) -> &LoadBasis;

    /// The amplitudes a, one for each column of B, under what acts.
    fn amplitudes<'a>(&'a self, acting: &'a Acting) -> Cow<'a, [f64]>;

    /// Amplitudes to which modes must respond exactly at rest.
    fn at_rest(&self) -> Vec<Vec<f64>>;
}

/// All loads on a dam.
#[derive(Clone, Debug)]
pub(crate) struct Loads(pub Vec<Arc<dyn Load>>);

impl Loads {
    /// Nodal forces of all loads, N/m.
    pub fn forces(&self, nodes: usize, acting: &Acting) -> Vec<[f64; 2]> {
        let mut forces = vec![[0.0; 2]; nodes];
        for load in &self.0 {
            load.basis().add(&load.amplitudes(acting), &mut forces);
        }
        forces
    }

    /// Nodal forces to which modes must respond exactly at rest, as columns.
    pub fn at_rest(&self, nodes: usize) -> DMatrix<f64> {
        let of_load = |load: &Arc<dyn Load>| {
            let basis = load.basis().matrix(nodes);
            load.at_rest().into_iter().map(move |amplitudes| &basis * DVector::from(amplitudes))
        };
        let columns: Vec<DVector<f64>> = self.0.iter().flat_map(of_load).collect();
        DMatrix::from_columns(&columns)
    }

    /// Bases with these `rows` (one for each mode; columns: x, then y of each node) in place of nodes.
    pub fn projected(&self, rows: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
        self.0.iter().map(|load| rows * load.basis().matrix(rows.ncols() / 2)).collect()
    }
}
