use nalgebra::{DMatrix, DVector};

use super::mode::SLOWED_TO;
use super::product::dot;
use crate::contact::ContactLaw;
use crate::release::{Carried, Release, plus};
use crate::structure::Structure;

/// Rigid motions of the blocks that cracks release, in modal coordinates, for [`Release`].
///
/// Fast modes, whose mass is not that of the concrete, are left out; rigid motions contain none of them unless added
/// mass couples the modes.
#[derive(Clone, Debug)]
pub(super) struct ModalRelease {
    /// α, 1/s.
    alpha: f64,
    /// Number of cracks' parts.
    seams: usize,
    carried: Carried,
    /// One for each link.
    blocks: Vec<BlockMomentum>,
}

/// `Rᵀ M Φ` and `Rᵀ M R` of a block, with its rigid motions R about the origin.
#[derive(Clone, Debug)]
struct BlockMomentum {
    of_rates: [Vec<f64>; 3],
    of_rigid: [[f64; 3]; 3],
}

impl ModalRelease {
    /// For mass damping `alpha` (1/s) of all blocks; `shapes` holds one row for each mode, with the
    /// squared frequencies `stiffness`.
    pub fn new(
        structure: &Structure<impl ContactLaw>,
        alpha: f64,
        shapes: &DMatrix<f64>,
        stiffness: &[f64],
    ) -> Self {
        let block = |block: &crate::Block| {
            let mut of_rates = [0, 1, 2].map(|_| DVector::zeros(shapes.nrows()));
            let mut of_rigid = [[0.0; 3]; 3];
            for node in block.nodes.clone() {
                let (mass, [x, y]) = (structure.mass[node], structure.mesh.nodes[node]);
                let [u, v] = [0, 1].map(|d| shapes.column(2 * node + d));
                // velocities of the node for unit rigid motions
                let units = [[1.0, 0.0], [0.0, 1.0], [-y, x]];
                for (i, [a, b]) in units.iter().enumerate() {
                    of_rates[i].axpy(mass * a, &u, 1.0);
                    of_rates[i].axpy(mass * b, &v, 1.0);
                    for (j, [c, d]) in units.iter().enumerate() {
                        of_rigid[i][j] += mass * (a * c + b * d);
                    }
                }
            }
            let slow = |square: f64| square < SLOWED_TO * SLOWED_TO * (1.0 - 1e-9);
            for momentum in &mut of_rates {
                for (value, &square) in momentum.iter_mut().zip(stiffness) {
                    *value = if slow(square) { *value } else { 0.0 };
                }
            }
            BlockMomentum { of_rates: of_rates.map(|momentum| momentum.data.into()), of_rigid }
        };
        let carried = structure.carried.clone();
        let blocks = carried.links.iter().map(|link| block(&structure.mesh.blocks[link.block])).collect();
        Self { alpha, seams: structure.cracks.len(), carried, blocks }
    }

    /// None: without mass damping, or if it drags blocks.
    pub fn none() -> Self {
        Self { alpha: 0.0, seams: 0, carried: Carried::default(), blocks: Vec::new() }
    }

    /// Whether no block is released.
    pub fn is_none(&self) -> bool {
        self.blocks.is_empty()
    }

    /// What blocks are carried by.
    pub fn carried(&self) -> &Carried {
        &self.carried
    }

    /// A release for evaluations that are a `time_step` (s) apart.
    pub fn start(&self, time_step: f64) -> Release {
        self.carried.release(self.seams, time_step)
    }

    /// Adds `α Jᵀ Rᵀ M P v` to the `forces` on the sides.
    #[inline(always)]
    pub fn add_dual(&self, release: &mut Release, rates: &[f64], forces: &mut [[f64; 2]]) {
        let Release { partings, rates: rigid, momenta } = release;
        for ((link, rigid), block) in self.carried.links.iter().zip(&*rigid).zip(&self.blocks).rev() {
            let mut momentum = momenta[link.block];
            for (i, momentum) in momentum.iter_mut().enumerate() {
                let ([a, b, c], [x, y, z]) = (block.of_rigid[i], *rigid);
                *momentum += dot(&block.of_rates[i], rates) - (a * x + b * y + c * z);
            }
            let parting = &partings[link.seam];
            if !parting.is_closed() {
                let [x, y, turning] = momentum;
                let share = link.sign * self.alpha;
                parting.add_dual([share * x, share * y, share * turning], forces);
            }
            if let Some(carrier) = link.carrier {
                momenta[carrier] = plus(momenta[carrier], momentum);
            }
        }
    }

    /// Adds `α Φᵀ M R j` to the `modal` forces; returns the sum of the nodal forces, N/m.
    #[inline(always)]
    pub fn add_rigid(&self, rigid: &[[f64; 3]], modal: &mut [f64]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (block, rate) in self.blocks.iter().zip(rigid) {
            for (momentum, rate) in block.of_rates.iter().zip(rate) {
                let rate = self.alpha * rate;
                for (force, m) in modal.iter_mut().zip(momentum) {
                    *force += m * rate;
                }
            }
            for (sum, row) in sum.iter_mut().zip(&block.of_rigid) {
                *sum += self.alpha * row.iter().zip(rate).map(|(m, rate)| m * rate).sum::<f64>();
            }
        }
        sum
    }
}
