//! The far end: waves leave upstream through a modal Dirichlet-to-Neumann map.
//!
//! Upstream of the far end the water is a channel of constant depth h, where
//! `∂²p/∂x² = B p` with `B = −∂²/∂y² + (s/c)²`, `p(h) = 0` and `∂p/∂y = q s p` at the bed.
//! The outgoing solution obeys `∂p/∂n = −√B p`, the root with a positive real part. In an
//! orthonormal polynomial basis (Galerkin)
//!
//! ```text
//! B = Λ + q s b bᵀ + (s/c)² I,   Λ = diag(λ_m²),   b_m = φ_m(0)
//! ```
//!
//! What the basis leaves over, waves shorter than the mesh resolves, radiates with the single
//! value of the next mode, `κ_r = √(λ_r² + (s/c)²)`: for short waves this is the plane-wave
//! impedance. The n-th polynomial varies over h/n² at the ends, so `n² = 6 × elements` keeps the
//! basis resolved; larger ones only add the mesh's error (measured on the static base pressure:
//! 1e-4 at n² = 20 × elements, 1e-7 at 6).
//!
//! For a rigid bed B is diagonal and φ_m are the cosines; for an absorbing one the root is
//! taken from the Schur form (Björck and Hammarling 1983), which has no weak spot where
//! modes coalesce. For Re s > 0 no eigenvalue of B is real and negative: with a unit vector
//! x, `x*Bx = K + q s β + (s/c)²`, K, β ≥ 0, is real only for real s and then positive.

use crate::ReservoirError;
use crate::boundary::{BoundaryMesh, shape};
use crate::condition::BoundaryCondition;
use crate::quadrature::{gauss_legendre, legendre};
use faer::Mat;
use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Most polynomials in the basis.
const LARGEST_BASIS: usize = 24;

/// The Dirichlet-to-Neumann map of the far end.
pub(crate) struct Radiation {
    /// λ_m², 1/m².
    squared_eigenvalues: Vec<f64>,
    /// b_m = φ_m(0), m^{-1/2}.
    at_bed: Vec<f64>,
    /// φ_m at the far end's nodes: nodes × modes.
    modes: Mat<Complex64>,
    /// Projection of nodal values: modes × nodes, `∫ φ_m N_j dy`.
    projection: Mat<Complex64>,
    /// λ_r² of the remainder, 1/m².
    remainder: f64,
    sound_speed: f64,
    admittance: f64,
}

impl Radiation {
    /// The map for the far end of `mesh` in water of `depth` (m) with the bed's admittance q (s/m).
    pub fn new(
        mesh: &BoundaryMesh,
        depth: f64,
        sound_speed: f64,
        admittance: f64,
    ) -> Result<Self, ReservoirError> {
        let nodes = mesh.part(BoundaryCondition::Radiation);
        let size = ((3 * nodes.len()).isqrt()).clamp(2, LARGEST_BASIS);
        let (squared_eigenvalues, vectors) = channel_modes(size, depth)?;
        let value = |mode: usize, y: f64| -> f64 {
            (0..size).map(|i| vectors[(i, mode)] * basis(i, 2.0 * y / depth - 1.0).0).sum()
        };
        let mesh_nodes = mesh.nodes();
        let modes = Mat::from_fn(nodes.len(), size, |j, m| value(m, mesh_nodes[nodes.start + j][1]).into());
        let rule = gauss_legendre(size / 2 + 3);
        let projection = Mat::from_fn(size, nodes.len(), |m, j| {
            let element = mesh.elements()[nodes.start / 2 + j / 2];
            let half = 0.5 * element.length();
            let integral: f64 = rule
                .iter()
                .map(|q| q.weight * half * shape(q.position)[j % 2] * value(m, element.at(q.position)[1]))
                .sum();
            integral.into()
        });
        let at_bed = (0..size).map(|m| value(m, 0.0)).collect();
        let remainder = ((2 * size + 1) as f64 * PI / (2.0 * depth)).powi(2);
        Ok(Self { squared_eigenvalues, at_bed, modes, projection, remainder, sound_speed, admittance })
    }

    /// T at the nodes, 1/m: `∂p/∂n = −T p`, nodes × nodes, at the complex frequency `s` (1/s).
    pub fn dirichlet_to_neumann(&self, s: Complex64) -> Result<Mat<Complex64>, ReservoirError> {
        let wavenumber_squared = (s / self.sound_speed).powi(2);
        let remainder = (wavenumber_squared + self.remainder).sqrt();
        let mut map = &self.modes * (self.modal(s, wavenumber_squared, remainder)? * &self.projection);
        for node in 0..map.nrows() {
            map[(node, node)] += remainder;
        }
        Ok(map)
    }

    /// `√B − κ_r I` in the modal basis.
    fn modal(
        &self,
        s: Complex64,
        wavenumber_squared: Complex64,
        remainder: Complex64,
    ) -> Result<Mat<Complex64>, ReservoirError> {
        let size = self.squared_eigenvalues.len();
        let diagonal = |m: usize| wavenumber_squared + self.squared_eigenvalues[m];
        let only = |i: usize, j: usize, value: Complex64| if i == j { value } else { Complex64::ZERO };
        if self.admittance == 0.0 {
            return Ok(Mat::from_fn(size, size, |i, j| only(i, j, diagonal(i).sqrt() - remainder)));
        }
        let b = DMatrix::from_fn(size, size, |i, j| {
            only(i, j, diagonal(i)) + self.admittance * s * self.at_bed[i] * self.at_bed[j]
        });
        let root = principal_root(b).ok_or(ReservoirError::FarEnd { frequency: s })?;
        Ok(Mat::from_fn(size, size, |i, j| root[(i, j)] - only(i, j, remainder)))
    }
}

/// `P_i(t) − P_{i+1}(t)`, zero at the surface t = 1, and its derivative.
fn basis(i: usize, t: f64) -> (f64, f64) {
    let ((p, dp), (q, dq)) = (legendre(i, t), legendre(i + 1, t));
    (p - q, dp - dq)
}

/// λ_m² (ascending) and the coefficients of φ_m, orthonormal over the depth, for a rigid bed.
fn channel_modes(size: usize, depth: f64) -> Result<(Vec<f64>, DMatrix<f64>), ReservoirError> {
    let (mut mass, mut stiffness) = (DMatrix::<f64>::zeros(size, size), DMatrix::<f64>::zeros(size, size));
    for q in gauss_legendre(size + 2) {
        let values: Vec<_> = (0..size).map(|i| basis(i, q.position)).collect();
        for i in 0..size {
            for j in 0..size {
                mass[(i, j)] += q.weight * 0.5 * depth * values[i].0 * values[j].0;
                stiffness[(i, j)] += q.weight * 2.0 / depth * values[i].1 * values[j].1;
            }
        }
    }
    let singular = ReservoirError::FarEnd { frequency: Complex64::ZERO };
    let inverse = mass.cholesky().and_then(|c| c.l().try_inverse()).ok_or(singular)?;
    let eigen = SymmetricEigen::new(&inverse * stiffness * inverse.transpose());
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let vectors = inverse.transpose() * eigen.eigenvectors;
    Ok((order.iter().map(|&m| eigen.eigenvalues[m]).collect(), vectors.select_columns(&order)))
}

/// The square root with eigenvalues in the right half plane, from the complex Schur form.
fn principal_root(matrix: DMatrix<Complex64>) -> Option<DMatrix<Complex64>> {
    let size = matrix.nrows();
    let (q, t) = nalgebra::linalg::Schur::try_new(matrix, f64::EPSILON, 100 * size)?.unpack();
    let mut root: DMatrix<Complex64> = DMatrix::zeros(size, size);
    for j in 0..size {
        root[(j, j)] = t[(j, j)].sqrt();
        for i in (0..j).rev() {
            let inner: Complex64 = (i + 1..j).map(|k| root[(i, k)] * root[(k, j)]).sum();
            root[(i, j)] = (t[(i, j)] - inner) / (root[(i, i)] + root[(j, j)]);
        }
    }
    Some(&q * root * q.adjoint())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial Galerkin basis converges exponentially for modes with π points a wave.
    #[test]
    fn modes_over_a_rigid_bed_are_the_cosines() -> Result<(), ReservoirError> {
        let depth = 103.0;
        let (squared, _) = channel_modes(LARGEST_BASIS, depth)?;
        for (m, squared) in squared.iter().take(9).enumerate() {
            let exact = (2 * m + 1) as f64 * PI / (2.0 * depth);
            assert!((squared.sqrt() / exact - 1.0).abs() < 1e-8, "mode {m}: {} {exact}", squared.sqrt());
        }
        Ok(())
    }

    #[test]
    fn root_squares_to_the_matrix() {
        let matrix = DMatrix::from_fn(12, 12, |i, j| {
            let diagonal = if i == j { (i * i) as f64 } else { 0.0 };
            Complex64::new(diagonal - 3.0, 0.7 * ((i + j) as f64).cos())
        });
        let root = principal_root(matrix.clone()).unwrap();
        assert!((&root * &root - &matrix).norm() < 1e-11 * matrix.norm());
    }
}
