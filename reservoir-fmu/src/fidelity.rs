use crate::convolution::Weights;
use interface::WetFace;
use serde::{Deserialize, Serialize};

/// Model of the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// Added mass `p = −⅞ ρ √(h(h − y)) a_n` at every point (Westergaard 1933): no waves, no memory.
    Westergaard,
    /// Compressible water by boundary elements, with radiation upstream and an absorbing bed.
    Compressible,
}

impl Fidelity {
    /// The value of the variable `fidelity`.
    pub fn code(self) -> f64 {
        match self {
            Self::Westergaard => 1.0,
            Self::Compressible => 3.0,
        }
    }
}

/// Westergaard's added mass at the interface points, kg/m²: `⅞ ρ √(h(h − y))`.
///
/// On a face that is not vertical it acts on the local normal acceleration.
pub(crate) fn added_mass(face: &WetFace, density: f64) -> Vec<f64> {
    let depth = face.depth();
    face.points().iter().map(|p| 0.875 * density * (depth * (depth - p[1])).sqrt()).collect()
}

/// The added mass as convolution weights: `p = −m a` with a at the step's end by BDF2,
/// `a = (1.5 v_n − 2 v_{n−1} + 0.5 v_{n−2})/H`, i.e. 1.5 of this step's mean less 0.5 of the last's.
pub(crate) fn added_mass_weights(mass: &[f64], communication_step: f64) -> Weights {
    let size = mass.len();
    let entry = |index: usize| {
        let (i, j) = (index / size, index % size);
        let scale = if i == j { -mass[i] / communication_step } else { 0.0 };
        vec![1.5 * scale, -2.0 * scale, 0.5 * scale]
    };
    Weights { size, entries: (0..size * size).map(entry).collect() }
}
