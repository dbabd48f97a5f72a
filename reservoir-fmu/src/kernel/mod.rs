//! Fundamental solutions of the Laplace-domain wave equation as sums of point sources.
//!
//! Depends on nothing else in the crate.

mod free_space;
mod free_surface;
mod ray;
mod table;

pub use free_space::FreeSpace;
pub use free_surface::FreeSurface;
pub(crate) use ray::Ray;
pub(crate) use table::Table;

/// A point source and its strength relative to the original source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Position, m.
    pub point: [f64; 2],
    /// Strength; 1 for the source itself, −1 for an image about a free surface.
    pub strength: f64,
}

/// A solution of `∇²G − k²G = −δ`, written as free-space sources.
///
/// `G(x, y) = Σ_i a_i K₀(k|y − x_i|)/2π` with the sources `(x_i, a_i)` of `x`. On a boundary whose
/// condition the kernel satisfies by images, no mesh is needed. At k = 0 it is the solution
/// `G = −Σ_i a_i ln(|y − x_i|/R)/2π` of Laplace's equation. Where the strengths do not sum to zero, the length R
/// matters: it is the extent of the mesh, far above the logarithmic capacity of the boundary, at which the single layer
/// would have a null space. The sources do not depend on `k`, so [`sources`](Self::sources) is called once for every
/// collocation point when a system is made, and not for each frequency.
pub trait HelmholtzKernel: Sync {
    /// The sources of the collocation point `point` (m); the point itself comes first.
    fn sources(&self, point: [f64; 2]) -> Vec<Source>;
}
