//! The far end: waves leave upstream through a modal Dirichlet-to-Neumann map.
//!
//! Upstream of the far end the water is a channel of constant depth, where `∂²p/∂x² = B p` with
//! `B = −∂²/∂y² + (s/c)²`, `∂p/∂y = q s p` at the bed and at the surface `p = 0` or, with gravity waves,
//! `∂p/∂y = −(s²/g) p`. The outgoing solution obeys `∂p/∂n = −√B p`, the root with a positive real part and,
//! where that is zero and Im s > 0, a positive imaginary part. In an orthonormal basis of continuous piecewise
//! polynomials (Galerkin)
//!
//! ```text
//! B = Λ + q s b bᵀ + (s²/g) t tᵀ + (s/c)² I,   Λ = diag(λ_m²),   b_m = φ_m(bed), t_m = φ_m(surface)
//! ```
//!
//! The remainder, waves shorter than the mesh resolves, radiates with one value, that of the next mode under p = 0,
//! `κ_r = √(λ_r² + (s/c)²)`; for short waves this is the plane-wave impedance. Near its ends the n-th polynomial of a
//! panel varies over a length of about (panel length)/n². With `n² = 14 × elements` the elements resolve the basis, with
//! 4 × for constant elements (at α = 0 and ten elements per wavelength the error of the profile is 4.3e-3, 1.6e-3,
//! 0.9e-3 with the factors 3, 6, 14). Panels of at most 16 elements of similar length suit meshes of any size, also
//! graded ones. The projection onto the modes is biorthogonal to their values at the nodes.
//!
//! For a rigid bed without gravity waves B is diagonal and φ_m are the cosines; otherwise the root is
//! computed from the Schur form, which stays accurate where modes coalesce. For Im s ≥ 0, Re s ≥ 0
//! the eigenvalues of B lie in the closed upper half plane: with a unit vector x,
//! `Im x*Bx = q Im s |bᵀx|² + Im s² (|tᵀx|²/g + 1/c²) ≥ 0`. For Im s < 0 everything is conjugate.

mod channel;
mod root;

use crate::ElementOrder;
use crate::ReservoirError;
use crate::boundary::BoundaryMesh;
use crate::condition::BoundaryCondition;
use crate::quadrature::gauss_legendre;
use crate::water::Water;
use channel::Channel;
use faer::{Mat, linalg::solvers::Solve};
use nalgebra::DMatrix;
use num_complex::Complex64;
use root::{matrix_root, outgoing_root};
use std::f64::consts::PI;

/// The Dirichlet-to-Neumann map of the far end.
pub(crate) struct Radiation {
    /// λ_m², 1/m².
    squared_eigenvalues: Vec<f64>,
    /// b_m = φ_m(bed), m^{-1/2}.
    at_bed: Vec<f64>,
    /// t_m = φ_m(surface), m^{-1/2}.
    at_surface: Vec<f64>,
    /// φ_m at the far end's nodes: nodes × modes.
    modes: Mat<Complex64>,
    /// Projection of nodal values: modes × nodes, `∫ φ_m N_j dy`.
    projection: Mat<Complex64>,
    /// λ_r² of the remainder, 1/m².
    remainder: f64,
    water: Water,
}

impl Radiation {
    /// The map for the far end of `mesh` in `water`.
    pub fn new(mesh: &BoundaryMesh, water: Water) -> Result<Self, ReservoirError> {
        let elements = &mesh.elements()[mesh.elements_of(BoundaryCondition::Radiation)];
        let order = mesh.order();
        let resolved = match order {
            ElementOrder::Constant => 4,
            ElementOrder::Linear => 14,
        };
        let nodes_per_element = order.nodes().len();
        let channel = Channel::new(elements, water.gravity.is_some(), resolved, nodes_per_element)?;
        let size = channel.size();
        let mut modes = Mat::zeros(nodes_per_element * elements.len(), size);
        let mut projection = Mat::zeros(size, modes.nrows());
        for (index, element) in elements.iter().enumerate() {
            for (local, &position) in order.nodes().iter().enumerate() {
                for (m, value) in channel.values(element.at(position)[1]).into_iter().enumerate() {
                    modes[(nodes_per_element * index + local, m)] = value.into();
                }
            }
            for q in gauss_legendre(channel.degree() / 2 + 2).iter() {
                let (shape, weight) = (order.shape(q.position), 0.5 * q.weight * element.length());
                for (m, value) in channel.values(element.at(q.position)[1]).into_iter().enumerate() {
                    for local in 0..nodes_per_element {
                        projection[(m, nodes_per_element * index + local)] +=
                            Complex64::from(weight * shape[local] * value);
                    }
                }
            }
        }
        // Biorthogonal to the nodal values of the modes. Otherwise the part of a mode that the mesh does not represent,
        // about 1e-4, would radiate with κ_r, which near the mode's cut-off frequency is a hundred times its κ.
        let gram = &projection * &modes;
        let projection = gram.partial_piv_lu().solve(projection);
        let [surface, bed] = [elements[0].start[1], elements[elements.len() - 1].end[1]];
        Ok(Self {
            at_bed: channel.values(bed),
            at_surface: channel.values(surface),
            modes,
            projection,
            remainder: ((2 * size + 1) as f64 * PI / (2.0 * (surface - bed))).powi(2),
            squared_eigenvalues: channel.squared_eigenvalues,
            water,
        })
    }

    /// T at the nodes, 1/m: `∂p/∂n = −T p`, nodes × nodes, at the complex frequency `s` (1/s), Re s ≥ 0.
    pub fn dirichlet_to_neumann(&self, s: Complex64) -> Result<Mat<Complex64>, ReservoirError> {
        // For Im s < 0 the conjugate of the map in the upper half plane, where the outgoing root is the principal one.
        let upper = if s.im < 0.0 { s.conj() } else { s };
        let mut map = self.map(upper).ok_or(ReservoirError::FarEnd { frequency: s })?;
        if s.im < 0.0 {
            for column in 0..map.ncols() {
                for row in 0..map.nrows() {
                    map[(row, column)] = map[(row, column)].conj();
                }
            }
        }
        Ok(map)
    }

    /// T for Im s ≥ 0.
    fn map(&self, s: Complex64) -> Option<Mat<Complex64>> {
        let wavenumber_squared = (s / self.water.sound_speed).powi(2);
        let remainder = outgoing_root(wavenumber_squared + self.remainder);
        let projection = &self.projection;
        let size = self.squared_eigenvalues.len();
        let bed = self.water.bed_admittance * s;
        let surface = self.water.gravity.map(|g| s * s / g);
        let modal = if bed == Complex64::ZERO && surface.is_none() {
            Mat::from_fn(size, projection.ncols(), |m, j| {
                (outgoing_root(wavenumber_squared + self.squared_eigenvalues[m]) - remainder)
                    * projection[(m, j)]
            })
        } else {
            let surface = surface.unwrap_or_default();
            let unshifted = DMatrix::from_fn(size, size, |i, j| {
                let coupled =
                    bed * self.at_bed[i] * self.at_bed[j] + surface * self.at_surface[i] * self.at_surface[j];
                if i == j { coupled + self.squared_eigenvalues[i] } else { coupled }
            });
            let root = matrix_root(unshifted, wavenumber_squared)?;
            let less = |i: usize, j: usize| if i == j { root[(i, j)] - remainder } else { root[(i, j)] };
            Mat::from_fn(size, size, less) * projection
        };
        let mut map = &self.modes * modal;
        for node in 0..map.nrows() {
            map[(node, node)] += remainder;
        }
        Some(map)
    }
}
