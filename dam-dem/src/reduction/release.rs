use nalgebra::{DMatrix, DVector};

use super::mode::SLOWED_TO;
use crate::contact::ContactLaw;
use crate::release::{Release, plus};
use crate::structure::Structure;

/// Rigid motions of the blocks above cracks in modal coordinates, for [`Release`].
///
/// Fast modes, whose mass is not that of the concrete, are left out; rigid motions contain none of them unless added
/// mass couples the modes.
#[derive(Clone, Debug)]
pub(super) struct ModalRelease {
    /// α, 1/s.
    alpha: f64,
    blocks: Vec<BlockMomentum>,
}

/// `Rᵀ M Φ` and `Rᵀ M R` of a block, with its rigid motions R about the origin.
#[derive(Clone, Debug)]
struct BlockMomentum {
    of_rates: [Vec<f64>; 3],
    of_rigid: [[f64; 3]; 3],
}

impl ModalRelease {
    /// For mass damping `alpha` (1/s) of all blocks above cracks; `shapes` holds one row for each mode, with the
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
        Self { alpha, blocks: structure.mesh.blocks[1..].iter().map(block).collect() }
    }

    /// None: without mass damping, or if it drags blocks.
    pub const NONE: Self = Self { alpha: 0.0, blocks: Vec::new() };

    /// Number of cracks that release blocks.
    pub fn cracks(&self) -> usize {
        self.blocks.len()
    }

    /// Adds `α Jᵀ Rᵀ M P v` to the `forces` on the sides.
    pub fn add_dual(&self, release: &Release, rates: &[f64], forces: &mut [[f64; 2]]) {
        let mut above = [0.0; 3];
        let cracks = release.partings.iter().zip(&release.rates).zip(&self.blocks);
        for ((parting, rigid), block) in cracks.rev() {
            let momentum = [0, 1, 2].map(|i| {
                let whole = block.of_rates[i].iter().zip(rates).map(|(m, rate)| m * rate).sum::<f64>();
                whole - block.of_rigid[i].iter().zip(rigid).map(|(m, rate)| m * rate).sum::<f64>()
            });
            above = plus(above, momentum);
            if !parting.is_closed() {
                parting.add_dual(above.map(|momentum| self.alpha * momentum), forces);
            }
        }
    }

    /// Adds `α Φᵀ M R j` to the `modal` forces; returns the sum of the nodal forces, N/m.
    pub fn add_rigid(&self, rigid: &[[f64; 3]], modal: &mut [f64]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (block, rate) in self.blocks.iter().zip(rigid) {
            for (momentum, rate) in block.of_rates.iter().zip(rate) {
                modal.iter_mut().zip(momentum).for_each(|(force, m)| *force += self.alpha * m * rate);
            }
            for (sum, row) in sum.iter_mut().zip(&block.of_rigid) {
                *sum += self.alpha * row.iter().zip(rate).map(|(m, rate)| m * rate).sum::<f64>();
            }
        }
        sum
    }
}
