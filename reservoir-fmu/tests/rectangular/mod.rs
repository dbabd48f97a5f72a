//! A reservoir of rectangular section, and a run of it under a given base motion.
#![allow(dead_code)] // every test file uses its part

use interface::variables::reservoir::{BASE_PRESSURE, INTERFACE_ACCELERATION};
use interface::{CoSimulation, WetFace};
use reservoir::{Fidelity, Reservoir, ReservoirError, ReservoirParameters};
use std::num::NonZeroUsize;

pub const DEPTH: f64 = 180.0;
pub const SOUND_SPEED: f64 = 1440.0;
pub const DENSITY: f64 = 1000.0;
pub const THREADS: NonZeroUsize = NonZeroUsize::new(2).unwrap();

/// h = 180 m, c = 1440 m/s, `elements` a depth, as many panels, far end at h/2.
pub fn parameters(alpha: f64, elements: usize, communication_step: f64, horizon: f64) -> ReservoirParameters {
    ReservoirParameters {
        wet_face: WetFace::straight([0.0, DEPTH], elements).unwrap(),
        density: DENSITY,
        sound_speed: SOUND_SPEED,
        wave_reflection_coefficient: alpha,
        gravity: 9.81,
        fidelity: Fidelity::Compressible,
        element_size: DEPTH / elements as f64,
        far_end_distance: DEPTH / 2.0,
        communication_step,
        horizon,
    }
}

/// Base pressures (Pa) at the steps' ends when the whole face moves towards the water with
/// the given velocity (m/s) at the steps' ends.
pub fn base_pressures(
    parameters: ReservoirParameters,
    velocity: impl Fn(f64) -> f64,
) -> Result<Vec<(f64, f64)>, ReservoirError> {
    let (h, steps) =
        (parameters.communication_step, (parameters.horizon / parameters.communication_step).round());
    let points = parameters.wet_face.len();
    let mut unit = Reservoir::new(parameters, THREADS)?;
    unit.initialise(0.0)?;
    let mut result = Vec::new();
    for step in 0..steps as usize {
        let (start, end) = (step as f64 * h, (step + 1) as f64 * h);
        let acceleration = -(velocity(end) - velocity(start)) / h;
        unit.set(INTERFACE_ACCELERATION.value_reference, &vec![acceleration; points])?;
        unit.step(start, h)?;
        let mut pressure = [0.0];
        unit.get(BASE_PRESSURE.value_reference, &mut pressure)?;
        result.push((end, pressure[0]));
    }
    Ok(result)
}
