//! A reservoir of rectangular section, and a run of it under a given base motion.

use cofferdam_reservoir::analytical::{chopra_1967, nodal_forces};
use cofferdam_reservoir::{Complex64, Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir::{BASE_PRESSURE, INTERFACE_ACCELERATION, TOTAL_FORCE};
use cofferdam_unit::{CoSimulation, WetFace};
use nalgebra::{DMatrix, DVector};
use std::num::NonZeroUsize;

pub const DEPTH: f64 = 180.0;
pub const SOUND_SPEED: f64 = 1440.0;
pub const DENSITY: f64 = 1000.0;
pub const THREADS: NonZeroUsize = NonZeroUsize::new(2).unwrap();

/// h = 180 m, c = 1440 m/s, `elements` per depth, as many panels; the far end at h/2, as by default.
pub fn parameters(alpha: f64, elements: usize, communication_step: f64, horizon: f64) -> ReservoirParameters {
    ReservoirParameters {
        density: DENSITY,
        sound_speed: SOUND_SPEED,
        wave_reflection_coefficient: alpha,
        element_size: DEPTH / elements as f64,
        communication_step,
        horizon,
        ..ReservoirParameters::before(WetFace::straight([0.0, DEPTH], elements).unwrap())
    }
}

/// Pressures divided by ρa (m) for a uniform acceleration along n out of the dam, into the water, from K(s).
pub fn of_uniform_motion(k: &DMatrix<Complex64>, s: Complex64) -> Vec<Complex64> {
    k.columns(0, k.nrows()).row_iter().map(|row| -row.sum() / (s * DENSITY)).collect()
}

/// `∫ N_i N_j ds`: the face's consistent mass.
pub fn consistent_mass(face: &WetFace) -> DMatrix<f64> {
    let mut mass = DMatrix::zeros(face.len(), face.len());
    for panel in face.panels() {
        for (i, j, share) in [(0, 0, 3.0), (0, 1, 6.0), (1, 0, 6.0), (1, 1, 3.0)] {
            mass[(panel.start + i, panel.start + j)] += panel.length / share;
        }
    }
    mass
}

/// The function linear along the panels that is nearest in mean square to `field`, a function of elevations (m). The
/// pressure at the points is related in this way to the pressure on the face.
pub fn projected(face: &WetFace, field: impl FnOnce(&[f64]) -> Vec<Complex64>) -> Vec<Complex64> {
    let loads = DVector::from_vec(nodal_forces(face, field));
    let solution = consistent_mass(face).map(Complex64::from).lu().solve(&loads).unwrap();
    solution.iter().copied().collect()
}

/// Norm of the difference, divided by the norm of the exact vector.
pub fn relative(found: &DVector<Complex64>, exact: &DVector<Complex64>) -> f64 {
    (found - exact).norm() / exact.norm()
}

/// Relative L² difference of two fields linear along the panels.
pub fn difference(face: &WetFace, field: &[Complex64], exact: &[Complex64]) -> f64 {
    let mass = consistent_mass(face).map(Complex64::from);
    let square = |v: DVector<Complex64>| (v.adjoint() * &mass * v)[(0, 0)].re;
    let exact = DVector::from_column_slice(exact);
    (square(DVector::from_column_slice(field) - &exact) / square(exact)).sqrt()
}

/// Base pressures (Pa) at the steps' ends when the whole face moves towards the water with
/// the given velocity (m/s) at the steps' ends.
pub fn base_pressures(
    parameters: ReservoirParameters,
    velocity: impl Fn(f64) -> f64,
) -> Result<Vec<(f64, f64)>, ReservoirError> {
    Ok(stepped(parameters, velocity)?.into_iter().map(|(time, [base, _])| (time, base)).collect())
}

/// The same, with the force (N/m).
pub fn stepped(
    parameters: ReservoirParameters,
    velocity: impl Fn(f64) -> f64,
) -> Result<Vec<(f64, [f64; 2])>, ReservoirError> {
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
        let number = |variable: cofferdam_unit::Variable| {
            let mut value = [0.0];
            unit.get(variable.value_reference, &mut value).map(|()| value[0])
        };
        result.push((end, [number(BASE_PRESSURE)?, number(TOTAL_FORCE)?]));
    }
    Ok(result)
}

/// An acceleration towards the water that rises to 1 m/s² in 0.1 s and then stays constant.
pub mod ramp_and_hold {
    use super::{DENSITY, DEPTH, SOUND_SPEED, chopra_1967};

    const RISE: f64 = 0.1;

    /// m/s.
    pub fn velocity(time: f64) -> f64 {
        if time < RISE { 0.5 * time * time / RISE } else { time - 0.5 * RISE }
    }

    /// Pressure at the base, Pa.
    pub fn base_pressure(time: f64) -> f64 {
        let record = [(0.0, 0.0), (RISE, 1.0)];
        DENSITY * SOUND_SPEED * chopra_1967::base_pressure(&record, DEPTH, SOUND_SPEED, time)
    }
}

/// Ground and dam that reach an upward velocity of 1 m/s within 0.1 s.
pub mod rising_ground {
    use super::{DENSITY, DEPTH, SOUND_SPEED};
    use std::f64::consts::PI;

    const RISE: f64 = 0.1;

    /// m/s².
    pub fn acceleration(time: f64) -> f64 {
        if time < RISE { 0.5 * PI / RISE * (PI * time / RISE).sin() } else { 0.0 }
    }

    fn velocity(time: f64) -> f64 {
        if time < RISE { (0.5 * PI * time / RISE).sin().powi(2) } else { 1.0 }
    }

    /// Pressure at the base (Pa) over a bed of wave reflection coefficient α. The bed's
    /// motion gives (1 + α)/2 of ρcv; the n-th echo, 2nh/c later, has the factor −(1 + α)(−α)^{n−1}.
    pub fn base_pressure(alpha: f64, time: f64) -> f64 {
        let crossing = 2.0 * DEPTH / SOUND_SPEED;
        let echo = |n: i32| if n == 0 { 1.0 } else { -(1.0 + alpha) * (-alpha).powi(n - 1) };
        let arrived = (0..).take_while(|&n| f64::from(n) * crossing < time);
        let sum: f64 = arrived.map(|n| echo(n) * velocity(time - f64::from(n) * crossing)).sum();
        0.5 * (1.0 + alpha) * DENSITY * SOUND_SPEED * sum
    }
}
