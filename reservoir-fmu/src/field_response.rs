//! Pressure inside the water.
//!
//! Depends on `operator`, `outline`, `system` and `water`.

use crate::operator::LayerOperators;
use crate::outline::Outline;
use crate::system::{boundary_system, kernel};
use crate::water::Water;
use crate::{ReservoirError, ReservoirParameters};
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::num::NonZeroUsize;

/// Largest number of values, points × inputs: 1.6 GB.
const MOST_VALUES: f64 = 1e8;
/// Number of entries of a layer operator that are held at once.
const HELD: usize = 4_000_000;

/// Pressure (Pa) at points inside the water for a unit velocity (m/s) of the interface points and of the ground.
///
/// The representation formula, with pressure P and slope on the boundary:
///
/// ```text
/// p(x) = ∫ G (∂P/∂n) ds − ∫ (∂G/∂n) P ds
/// ```
///
/// **Shapes and units**: `s` in 1/s as in [`frequency_response`](crate::frequency_response()); `points` (x, y) in
/// m, between dam and far end; rows: `points`, columns: as in
/// [`frequency_response`](crate::frequency_response()).
///
/// **Errors**: those of [`frequency_response`](crate::frequency_response()), [`ReservoirError::FieldPoint`],
/// [`ReservoirError::TooMuch`], and [`ReservoirError::NoField`] for Westergaard's water.
pub fn field_response(
    parameters: &ReservoirParameters,
    s: Complex64,
    points: &[[f64; 2]],
    threads: NonZeroUsize,
) -> Result<DMatrix<Complex64>, ReservoirError> {
    parameters.validate()?;
    if !parameters.fidelity.is_solved() {
        return Err(ReservoirError::NoField);
    }
    if !(s.re >= 0.0 && s.is_finite() && s != Complex64::ZERO) {
        return Err(ReservoirError::Frequency { frequency: s });
    }
    let inputs = parameters.wet_face.len() + 2;
    let value = points.len() as f64 * inputs as f64;
    if value > MOST_VALUES {
        let (what, remedy) = ("values of the field", "ask for fewer points");
        return Err(ReservoirError::TooMuch { what, value, most: MOST_VALUES, remedy });
    }
    let outline = Outline::new(parameters)?;
    for (index, &[x, y]) in points.iter().enumerate() {
        if !outline.contains([x, y]) {
            let far_end = outline.pieces()[0].start[0];
            return Err(ReservoirError::FieldPoint { index, x, y, far_end });
        }
    }
    let (water, system) = (Water::of(parameters), boundary_system(parameters)?);
    // Incompressible water without gravity waves does not depend on the frequency.
    let waveless = !water.sound_speed.is_finite() && water.gravity.is_none();
    let frequency = if waveless { Complex64::ZERO } else { s };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
    pool.install(|| {
        let values = system.boundary_values(frequency)?;
        let mut response = DMatrix::zeros(points.len(), inputs);
        let share = (HELD / values.pressure.nrows()).max(1);
        for (part, at) in points.chunks(share).enumerate() {
            let layers = LayerOperators::new(system.mesh(), &*kernel(parameters), at)
                .assemble(frequency / water.sound_speed)
                .map_err(|source| ReservoirError::Kernel { frequency: s, source })?;
            let field = layers.single * &values.slope - layers.double * &values.pressure;
            for (i, j) in (0..at.len()).flat_map(|i| (0..inputs).map(move |j| (i, j))) {
                response[(share * part + i, j)] = water.density * s * field[(i, j)];
            }
        }
        Ok(response)
    })
}
