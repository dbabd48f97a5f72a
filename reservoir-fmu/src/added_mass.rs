//! Water without memory: its added mass, and pressure at the ends of steps of any length.
//!
//! Depends on `fidelity`, `frequency_response` and `system`.

use crate::frequency_response::boundary_system;
use crate::{Fidelity, ReservoirError, ReservoirParameters};
use interface::WetFace;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// The added mass A of water without memory: pressure `p = −A a` for the acceleration a of the wet face
/// along n.
///
/// **Shapes and units**: points × points, kg/m² (Pa per m/s²); `a` in m/s², `p` in Pa.
/// Westergaard's is the diagonal `⅞ ρ √(h(h − y))`, on a sloped face for the local normal acceleration.
/// That of incompressible water is full: Laplace's equation with ∂p/∂n = −ρ a on the face, p = 0 at the
/// surface, a rigid bed, and what decays upstream, by boundary elements. Pressure at points, as everywhere,
/// so that `M_Γ A`, with the face's consistent mass M_Γ, is symmetric to the accuracy of the mesh only.
///
/// **Errors**: parameters out of range, [`ReservoirError::Memory`] for compressible water,
/// [`ReservoirError::FarEnd`].
///
/// **Source**: Westergaard (1933), and his series for incompressible water
/// ([`chopra_1967`](crate::analytical::chopra_1967), s → 0).
pub fn added_mass(parameters: &ReservoirParameters) -> Result<DMatrix<f64>, ReservoirError> {
    parameters.validate()?;
    match parameters.fidelity {
        Fidelity::Westergaard => Ok(westergaard(&parameters.wet_face, parameters.density)),
        Fidelity::Incompressible => boundary_system(parameters)?.added_mass(),
        Fidelity::Compressible => Err(ReservoirError::Memory),
    }
}

/// Westergaard's: `⅞ ρ √(h(h − y))` on the diagonal.
fn westergaard(face: &WetFace, density: f64) -> DMatrix<f64> {
    let depth = face.depth();
    let mass = |point: &[f64; 2]| 0.875 * density * (depth * (depth - point[1])).sqrt();
    DMatrix::from_diagonal(&DVector::from_iterator(face.len(), face.points().iter().map(mass)))
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
