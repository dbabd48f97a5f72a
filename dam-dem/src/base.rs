//! The force of the dam on the ground.

use nalgebra::DVector;

use crate::model::{Body, Model};
use crate::wet::Wet;

/// Momentum balance of the whole dam, in the coordinates of its level of fidelity.
///
/// ```text
/// F_base = F_weight + F_static + Σ F_water − ιᵀ (M + X) (ü + ι a_g) − α_M ιᵀ M (u̇ − R j)
/// ```
///
/// R j is the sliding and rocking from which mass damping is released. The balance does not use stresses, which are singular at heel and toe, and is valid at every level of fidelity.
/// Forces of local damping count as forces of the ground, and so does the water in a joint along the base, which presses on it.
#[derive(Clone, Debug)]
pub(crate) struct BaseBalance {
    /// `ιᵀ (M + X)` along x and along y.
    momentum: [Vec<f64>; 2],
    /// `α ιᵀ M`.
    damping: [Vec<f64>; 2],
    /// `ιᵀ (M + X) ι`.
    mass: [[f64; 2]; 2],
    /// Sum of the weight and of the static loads.
    constant: [f64; 2],
    /// Force of a unit pressure at each interface point, m.
    pressure: Vec<[f64; 2]>,
}

impl BaseBalance {
    /// The balance of a `model` under `gravity` (m/s²).
    pub fn new(model: &Model, gravity: f64) -> Self {
        let Body { structure, wet, applied, .. } = model.body();
        let wet = wet.as_ref();
        let along = |axis: usize, factor: f64| {
            let mass = |i: usize| if i % 2 == axis { factor * structure.mass[i / 2] } else { 0.0 };
            DVector::from_fn(2 * structure.mass.len(), |i, _| mass(i))
        };
        let with_water = [0, 1].map(|axis| {
            let mut momentum = along(axis, 1.0);
            for (node, inertia) in structure.added_mass.iter().flat_map(|water| water.ground_inertia(axis)) {
                (0..2).for_each(|d| momentum[2 * node + d] += inertia[d]);
            }
            momentum
        });
        let mass = with_water
            .each_ref()
            .map(|momentum| [0, 1].map(|axis| momentum.iter().skip(axis).step_by(2).sum::<f64>()));
        let mut pressure = vec![[0.0; 2]; wet.map_or(0, Wet::len)];
        for &(_, point, force) in wet.map_or(&[][..], |wet| wet.load.entries()) {
            (0..2).for_each(|d| pressure[point][d] += force[d]);
        }
        let alpha = model.damping().rayleigh.mass;
        Self {
            momentum: with_water.map(|momentum| model.on_coordinates(momentum)),
            damping: [0, 1].map(|axis| model.on_coordinates(along(axis, alpha))),
            mass,
            constant: [applied[0], applied[1] - gravity * structure.mass.iter().sum::<f64>()],
            pressure,
        }
    }

    /// Force on the ground, N/m, mean over a step, from the mean `acceleration` relative to the ground, the
    /// velocity at both ends of the step, the mean force `α_M ιᵀ M R j` that mass damping `spared` (N/m), the mean
    /// acceleration of the `ground` (m/s²) and the mean `pressure` (Pa).
    pub fn force(
        &self,
        acceleration: &[f64],
        velocity: [&[f64]; 2],
        spared: [f64; 2],
        ground: [f64; 2],
        pressure: impl Iterator<Item = f64>,
    ) -> [f64; 2] {
        let mut force = self.constant;
        for (of_unit, p) in self.pressure.iter().zip(pressure) {
            (0..2).for_each(|d| force[d] += of_unit[d] * p);
        }
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        [0, 1].map(|d| {
            let inertia = product(&self.momentum[d], acceleration)
                + self.mass[d][0] * ground[0]
                + self.mass[d][1] * ground[1];
            let damping: f64 = velocity.iter().map(|v| product(&self.damping[d], v) / 2.0).sum();
            force[d] - inertia - damping + spared[d]
        })
    }
}
