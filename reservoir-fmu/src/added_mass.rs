//! Water without memory: its added mass, and pressure at the ends of steps of any length.
//!
//! Depends on `analytical`, `fidelity`, `frequency_response` and `system`.

use crate::analytical::westergaard_1933;
use crate::frequency_response::boundary_system;
use crate::{Fidelity, ReservoirError, ReservoirParameters};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// The added mass A of water without memory: pressure `p = −A a` for the acceleration a of the wet face
/// along n.
///
/// **Shapes and units**: points × points, kg/m² (Pa per m/s²); `a` in m/s², `p` in Pa.
/// Westergaard's is the diagonal `⅞ ρ √(h(h − y))`, or ρ times his series, on a sloped face for the local normal
/// acceleration.
/// That of incompressible water is full: Laplace's equation with ∂p/∂n = −ρ a on the face, p = 0 at the
/// surface, a rigid bed, and what decays upstream, by boundary elements; `M_Γ A`, with the face's consistent mass
/// M_Γ, is symmetric.
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
/// **Shapes and units**: points × 2, kg/m². A level bed pushes no water along x; upwards it lifts all of it,
/// `A_g[·, 1] = −ρ (h − y)` far from the face. Zero for Westergaard's water, which does not know the ground.
///
/// **Errors**: those of [`added_mass`].
pub fn ground_added_mass(parameters: &ReservoirParameters) -> Result<DMatrix<f64>, ReservoirError> {
    let points = parameters.wet_face.len();
    Ok(whole_added_mass(parameters)?.columns(points, 2).into_owned())
}

/// A and beside it A_g: points × (points + 2).
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

/// ρ times a profile `p/(ρa)` (m) of depth and elevation (m) on the diagonal, and two columns of zeros.
fn profile(parameters: &ReservoirParameters, pressure: fn(f64, f64) -> f64) -> DMatrix<f64> {
    let ReservoirParameters { wet_face, density, .. } = parameters;
    let mass = |point: &[f64; 2]| density * pressure(wet_face.depth(), point[1]);
    DMatrix::from_diagonal(&DVector::from_iterator(wet_face.len(), wet_face.points().iter().map(mass)))
        .resize_horizontally(wet_face.len() + 2, 0.0)
}

/// The step before: all that water without memory needs to know.
///
/// Pressure at the end of step n follows from the acceleration there, and that from the means over this
/// step and the last, linear in time:
///
/// ```text
/// a_end = ā_n + (ā_n − ā_{n−1}) H_n / (H_n + H_{n−1})
/// ```
///
/// exact where acceleration is linear, else of second order; with equal steps `1.5 ā_n − 0.5 ā_{n−1}`,
/// BDF2 of the velocity. Before the first step the face is at rest, for as long as that step takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LastStep {
    /// ā, m/s².
    pub acceleration: Vec<f64>,
    /// H, s; 0 before the first step.
    pub length: f64,
    /// `H_n / (H_n + H_{n−1})` of that step.
    pub share: f64,
}

impl LastStep {
    /// That of a face at rest.
    pub fn at_rest(points: usize) -> Self {
        Self { acceleration: vec![0.0; points], length: 0.0, share: 0.5 }
    }

    /// The step of `length` (s) with the mean `acceleration` that follows on this one, and the acceleration
    /// at its end.
    pub fn followed_by(&self, acceleration: &[f64], length: f64) -> (Self, DVector<f64>) {
        let before = if self.length > 0.0 { self.length } else { length };
        let share = length / (length + before);
        let means = acceleration.iter().zip(&self.acceleration);
        let end = means.map(|(mean, last)| mean + (mean - last) * share);
        let end = DVector::from_iterator(acceleration.len(), end);
        (Self { acceleration: acceleration.to_vec(), length, share }, end)
    }
}
