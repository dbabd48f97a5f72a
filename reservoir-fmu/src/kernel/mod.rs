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

/// A point source and its strength relative to the source that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Position, m.
    pub point: [f64; 2],
    /// Strength; 1 for the source itself, −1 for an image about a free surface.
    pub strength: f64,
}

/// A solution of `∇²G − k²G = −δ`, written as free-space sources.
///
/// `G(x, y) = Σ_i a_i K₀(k|y − x_i|)/2π` with the sources `(x_i, a_i)` of `x`. A kernel that
/// satisfies a boundary condition by images spares the mesh of that boundary. At k = 0 it is the solution
/// `G = −Σ_i a_i ln(|y − x_i|/R)/2π` of Laplace's equation. Where the strengths do not sum to zero the length R
/// matters: it is taken as the extent of the mesh, far above the one at which the single layer has a null space,
/// the logarithmic capacity of the boundary. The sources do not depend on `k`, so [`sources`](Self::sources) is called once for every collocation
/// point when a system is made, never for a frequency.
pub trait HelmholtzKernel: Sync {
    /// The sources of the collocation point `point` (m), itself first.
    fn sources(&self, point: [f64; 2]) -> Vec<Source>;
}
