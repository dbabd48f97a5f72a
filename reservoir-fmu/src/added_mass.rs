//! Water without memory: its added mass.
//!
//! Depends on `analytical`, `fidelity`, `projection`, `quadrature` and `system`.

use crate::analytical::westergaard_1933;
use crate::projection::consistent_mass;
use crate::quadrature::gauss_legendre;
use crate::system::boundary_system;
use crate::{Fidelity, ReservoirError, ReservoirParameters};
use nalgebra::DMatrix;

/// The added mass A of water without memory: pressure `p = −A a` for the acceleration a of the wet face
/// along n.
///
/// **Shapes and units**: points × points, kg/m² (Pa per m/s²); `a` in m/s², `p` in Pa.
/// Westergaard's profile w, `⅞ √(h(h − y))` or his series (m), multiplies the local normal acceleration. It is integrated
/// with the hat functions N of the points, `M_Γ A = ρ ∫ w N Nᵀ ds`, so that force and moment of a motion that is linear
/// along the face, and the water's kinetic energy, are exact on any panels; sampled at the points, √(h − y) would lose mass
/// beside the surface.
/// A of incompressible water is a full matrix. It follows by boundary elements from Laplace's equation with
/// ∂p/∂n = −ρ a on the face, p = 0 at the surface, a rigid bed, and a pressure that decays upstream. `M_Γ A`, with the
/// face's consistent mass M_Γ, is symmetric, positive definite for Westergaard's.
///
/// **Errors**: parameters out of range, [`ReservoirError::Memory`] for compressible water,
/// [`ReservoirError::GravityWaves`], [`ReservoirError::FarEnd`].
///
/// **Source**: Westergaard (1933), and his series for incompressible water
/// ([`chopra_1967`](crate::analytical::chopra_1967), s → 0).
pub fn added_mass(parameters: &ReservoirParameters) -> Result<DMatrix<f64>, ReservoirError> {
    let points = parameters.wet_face.len();
    Ok(whole_added_mass(parameters)?.columns(0, points).into_owned())
}

/// The added mass of the ground, `p = −A_g a_g` for its acceleration along x and y, the face at rest.
///
/// **Shapes and units**: points × 2, kg/m². Motion of a level bed along x gives no pressure; upward motion lifts the
/// water, `A_g[·, 1] = −ρ (h − y)` far from the face. A_g of Westergaard's water is zero: it does not model the ground.
///
/// **Errors**: those of [`added_mass`].
pub fn ground_added_mass(parameters: &ReservoirParameters) -> Result<DMatrix<f64>, ReservoirError> {
    let points = parameters.wet_face.len();
    Ok(whole_added_mass(parameters)?.columns(points, 2).into_owned())
}

/// A followed by A_g: points × (points + 2).
pub(crate) fn whole_added_mass(parameters: &ReservoirParameters) -> Result<DMatrix<f64>, ReservoirError> {
    parameters.validate()?;
    if parameters.surface_waves {
        let remedy = "unset `surface_waves`, or take the frequency response";
        return Err(ReservoirError::GravityWaves { what: "an added mass", remedy });
    }
    match parameters.fidelity {
        Fidelity::Westergaard => Ok(profile(parameters, westergaard_1933::pressure)),
        Fidelity::WestergaardExact => Ok(profile(parameters, westergaard_1933::series_pressure)),
        Fidelity::Incompressible => boundary_system(parameters)?.added_mass(),
        Fidelity::Compressible => Err(ReservoirError::Memory),
    }
}

/// Points of the quadrature along a panel in u = √(h − y). √(h − y) and hats are polynomials in u, so that four would be
/// exact for the parabola; the series has u² ln u in it.
const ALONG_PANEL: usize = 8;

/// `A = M_Γ⁻¹ ρ ∫ w N Nᵀ ds` of the profile w = `pressure(depth, elevation)`, `p/(ρa)` (m), and two columns of zeros.
fn profile(parameters: &ReservoirParameters, pressure: fn(f64, f64) -> f64) -> DMatrix<f64> {
    let ReservoirParameters { wet_face, density, .. } = parameters;
    let (depth, points) = (wet_face.depth(), wet_face.len());
    let below_surface = |point: usize| depth - wet_face.points()[point][1];
    let mut moved = DMatrix::<f64>::zeros(points, points);
    for panel in wet_face.panels() {
        let [lower, upper] = [panel.start, panel.start + 1].map(below_surface);
        let (middle, half) = ((lower.sqrt() + upper.sqrt()) / 2.0, (lower.sqrt() - upper.sqrt()) / 2.0);
        for q in gauss_legendre(ALONG_PANEL).iter() {
            let u = middle + half * q.position;
            // h − y = u², ds = 2u du ℓ/(y₁ − y₀)
            let along = (lower - u * u) / (lower - upper);
            let ds = 2.0 * u * half * q.weight * panel.length / (lower - upper);
            let mass = density * pressure(depth, depth - u * u) * ds;
            let hats = [1.0 - along, along];
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                moved[(panel.start + i, panel.start + j)] += hats[i] * hats[j] * mass;
            }
        }
    }
    // Every point belongs to a panel, so the mass is positive definite.
    if let Some(mass) = consistent_mass(wet_face).cholesky() {
        mass.solve_mut(&mut moved);
    }
    moved.resize_horizontally(points + 2, 0.0)
}
