//! The spatial distribution of a load.

use nalgebra::DMatrix;

/// Nodal forces of unit amplitudes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LoadBasis {
    /// Number of amplitudes.
    pub columns: usize,
    /// Node, amplitude, and force per amplitude.
    pub entries: Vec<(usize, usize, [f64; 2])>,
}

impl LoadBasis {
    /// Adds `B a` to `forces` (N/m).
    pub fn add(&self, amplitudes: &[f64], forces: &mut [[f64; 2]]) {
        for &(node, column, force) in &self.entries {
            forces[node][0] += force[0] * amplitudes[column];
            forces[node][1] += force[1] * amplitudes[column];
        }
    }

    /// B, with x, then y of each of `nodes` nodes as rows.
    pub fn matrix(&self, nodes: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(2 * nodes, self.columns);
        for &(node, column, force) in &self.entries {
            (0..2).for_each(|d| matrix[(2 * node + d, column)] += force[d]);
        }
        matrix
    }

    /// Sum of the forces of each column.
    pub fn resultants(&self) -> Vec<[f64; 2]> {
        let mut sums = vec![[0.0; 2]; self.columns];
        for &(_, column, force) in &self.entries {
            (0..2).for_each(|d| sums[column][d] += force[d]);
        }
        sums
    }
}
