use std::borrow::Cow;

use super::{Acting, Load, LoadBasis};
use crate::AddedMass;

/// Inertia in a frame that moves with the ground, `−(M + X) ι a_g`; its amplitudes are the accelerations of the ground.
#[derive(Debug)]
pub(crate) struct Inertia(LoadBasis);

impl Inertia {
    /// That of nodes with this `mass` (kg/m), and of the added mass of `water`.
    pub fn new(mass: &[f64], water: Option<&AddedMass>) -> Self {
        let of_axis = |m: f64, axis: usize| if axis == 0 { [-m, 0.0] } else { [0.0, -m] };
        let concrete =
            mass.iter().enumerate().flat_map(|(node, m)| [0, 1].map(|axis| (node, axis, of_axis(*m, axis))));
        let of_water = |axis: usize| {
            let inertia = water.into_iter().flat_map(move |water| water.ground_inertia(axis));
            inertia.map(move |(node, values)| (node, axis, values.map(|value| -value)))
        };
        let entries = concrete.chain(of_water(0)).chain(of_water(1)).collect();
        Self(LoadBasis { columns: 2, entries })
    }
}

impl Load for Inertia {
    fn basis(&self) -> &LoadBasis {
        &self.0
    }

    fn amplitudes<'a>(&'a self, acting: &'a Acting) -> Cow<'a, [f64]> {
        Cow::Borrowed(&acting.ground_acceleration)
    }

    /// None: the static correction of modes has accelerations of the ground already.
    fn at_rest(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }
}
