//! Inertia of the water at the wet face, as part of the mass matrix of the dam.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::DamError;
use crate::error::require;
use crate::wet::Wet;

/// Water without memory, as mass of the nodes on the wet face.
///
/// With the pressure `p = −A a` for the acceleration a of the interface points along n, their motion
/// `a = N ü` and the nodal forces `B p`, the mass of the water is `B A N`. The kinetic energy depends on its
/// symmetric part only. Therefore
///
/// ```text
/// X = ½ (B A N + (B A N)ᵀ)
/// (M + X) ü + … = F − (M + X) ι a_g
/// ```
///
/// which conserves energy. The neglected antisymmetric part is an error of the discretisation in points; it
/// tends to 0 with the length of the panels and does not change the kinetic energy. For the same reason X is
/// not always positive semidefinite: with a profile that is sampled at the points, a motion with a wavelength of two
/// panels can have a small negative mass. Natural frequencies can increase by at most the corresponding factor ([`least_share`](Self::least_share)).
///
/// **Units**: kg/m, per metre of dam.
#[derive(Clone, Debug, PartialEq)]
pub struct AddedMass {
    /// Nodes of the wet face, each of them once.
    nodes: Vec<usize>,
    /// X: x, then y of each node.
    matrix: DMatrix<f64>,
    /// `X (M + X)⁻¹`, with infinite mass at fixed nodes.
    share: DMatrix<f64>,
    least_share: f64,
}

impl AddedMass {
    /// The added mass of `rows` (points × points, Pa per m/s²) on the wet face, with the `inverse_mass`
    /// (m/kg) of all nodes.
    ///
    /// **Errors**: [`DamError::AddedMassShape`], [`DamError::AddedMassNegative`]; [`DamError::OutOfRange`] for values
    /// that are not finite.
    pub(crate) fn new(wet: Option<&Wet>, rows: &[Vec<f64>], inverse_mass: &[f64]) -> Result<Self, DamError> {
        let points = wet.map_or(0, Wet::len);
        let lengths = rows.iter().map(Vec::len).chain([rows.len()]);
        let Some(wet) = wet.filter(|_| lengths.clone().all(|length| length == points)) else {
            let found = lengths.clone().find(|&length| length != points).unwrap_or(rows.len());
            return Err(DamError::AddedMassShape { found, points });
        };
        for &value in rows.iter().flatten() {
            require(value.is_finite(), "added_mass", value, "finite")?;
        }
        let mut nodes = wet.nodes.clone();
        nodes.dedup();
        let place = |node: usize| 2 * nodes.iter().position(|&other| other == node).unwrap_or(0);
        let mut motion = DMatrix::<f64>::zeros(points, 2 * nodes.len());
        for (point, (&node, normal)) in wet.nodes.iter().zip(&wet.normals).enumerate() {
            (0..2).for_each(|d| motion[(point, place(node) + d)] = normal[d]);
        }
        let mut load = DMatrix::<f64>::zeros(2 * nodes.len(), points);
        for &(node, point, weight) in wet.load.entries() {
            (0..2).for_each(|d| load[(place(node) + d, point)] += weight[d]);
        }
        let pressure = DMatrix::from_fn(points, points, |i, j| rows[i][j]);
        let whole = load * pressure * motion;
        let matrix = (&whole + whole.transpose()) / 2.0;
        // X (M + X)⁻¹ = X D (1 + D X D)⁻¹ D with D = M^(−½)
        let root = DVector::from_fn(2 * nodes.len(), |i, _| inverse_mass[nodes[i / 2]].sqrt());
        let root = DMatrix::from_diagonal(&root);
        let scaled = SymmetricEigen::new(&root * &matrix * &root);
        let least = scaled.eigenvalues.min();
        if least < MOST_NEGATIVE {
            return Err(DamError::AddedMassNegative { share: -least, most: -MOST_NEGATIVE });
        }
        let inverse = scaled.eigenvalues.map(|value| 1.0 / (1.0 + value));
        let modes = &root * &scaled.eigenvectors;
        let share = &matrix * &modes * DMatrix::from_diagonal(&inverse) * modes.transpose();
        Ok(Self { nodes, matrix, share, least_share: 1.0 + least.min(0.0) })
    }

    /// The largest μ ≤ 1 with `M + X ≥ μ M`: 1 if X is positive semidefinite. The added mass increases no natural
    /// frequency by more than the factor `1/√μ`.
    pub fn least_share(&self) -> f64 {
        self.least_share
    }

    /// Entries of X: node and axis of the row, node and axis of the column, value (kg/m).
    pub fn entries(&self) -> impl Iterator<Item = ([usize; 2], [usize; 2], f64)> + '_ {
        let place = |i: usize| [self.nodes[i / 2], i % 2];
        let size = self.matrix.nrows();
        (0..size * size).map(move |k| (place(k / size), place(k % size), self.matrix[(k / size, k % size)]))
    }

    /// `X ι` at each wet node for a unit acceleration of the ground along `axis`, kg/m.
    pub fn ground_inertia(&self, axis: usize) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let sum =
            move |row: usize| (axis..self.matrix.ncols()).step_by(2).map(|j| self.matrix[(row, j)]).sum();
        self.nodes.iter().enumerate().map(move |(i, &node)| (node, [sum(2 * i), sum(2 * i + 1)]))
    }

    /// Subtracts the inertia `X ü` of the water from the `forces` (N/m) on the wet nodes; the remaining
    /// forces accelerate the concrete.
    ///
    /// `ü = (M + X)⁻¹ (F − α M v)`; mass damping α = `damping` (1/s) acts on the `mass` (kg/m) of the concrete only.
    pub(crate) fn take_share(
        &self,
        forces: &mut [[f64; 2]],
        velocity: &[[f64; 2]],
        mass: &[f64],
        damping: f64,
    ) {
        let driving = DVector::from_fn(self.matrix.nrows(), |i, _| {
            let (node, d) = (self.nodes[i / 2], i % 2);
            forces[node][d] - damping * mass[node] * velocity[node][d]
        });
        let share = &self.share * driving;
        for (i, share) in share.iter().enumerate() {
            forces[self.nodes[i / 2]][i % 2] -= share;
        }
    }

    /// Kinetic energy `½ vᵀ X v` of the water relative to the ground, J/m.
    pub(crate) fn kinetic_energy(&self, velocity: &[[f64; 2]]) -> f64 {
        let wet = DVector::from_fn(self.matrix.nrows(), |i, _| velocity[self.nodes[i / 2]][i % 2]);
        0.5 * wet.dot(&(&self.matrix * &wet))
    }
}

/// Smallest eigenvalue of `M^(−½) X M^(−½)` that is accepted as an error of the discretisation in points.
const MOST_NEGATIVE: f64 = -0.5;
