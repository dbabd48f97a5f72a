//! A reservoir of rectangular section, and a run of it under a given base motion.
#![allow(dead_code)] // every test file uses its part

use interface::variables::reservoir::{BASE_PRESSURE, INTERFACE_ACCELERATION, TOTAL_FORCE};
use interface::{CoSimulation, WetFace};
use nalgebra::{DMatrix, DVector};
use reservoir::{Complex64, Reservoir, ReservoirError, ReservoirParameters};
use std::num::NonZeroUsize;

pub const DEPTH: f64 = 180.0;
pub const SOUND_SPEED: f64 = 1440.0;
pub const DENSITY: f64 = 1000.0;
pub const THREADS: NonZeroUsize = NonZeroUsize::new(2).unwrap();

/// h = 180 m, c = 1440 m/s, `elements` a depth, as many panels, far end at h/2.
pub fn parameters(alpha: f64, elements: usize, communication_step: f64, horizon: f64) -> ReservoirParameters {
    ReservoirParameters {
        density: DENSITY,
        sound_speed: SOUND_SPEED,
        wave_reflection_coefficient: alpha,
        element_size: DEPTH / elements as f64,
        far_end_distance: DEPTH / 2.0,
        communication_step,
        horizon,
        ..ReservoirParameters::before(WetFace::straight([0.0, DEPTH], elements).unwrap())
    }
}

/// Pressures over ρa (m) for a uniform acceleration along n out of the dam, into the water, from K(s).
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

/// What is linear along the panels and nearest in the mean square to `field`, a function of elevations (m): what
/// the pressure at the points is of the pressure on the face. Gauss' rule of six points a panel.
pub fn projected(face: &WetFace, field: impl FnOnce(&[f64]) -> Vec<Complex64>) -> Vec<Complex64> {
    let rule = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_4),
    ];
    let mut at = Vec::new();
    for panel in face.panels() {
        let (low, high) = (face.points()[panel.start][1], face.points()[panel.start + 1][1]);
        for (position, weight) in rule.iter().flat_map(|&(x, w)| [(-x, w), (x, w)]) {
            // Graded upwards: at the surface p ~ r ln r.
            let u = 0.5 * (1.0 - position);
            let t = 1.0 - u * u;
            at.push((panel.start, t, low + t * (high - low), u * weight * panel.length));
        }
    }
    let values = field(&at.iter().map(|point| point.2).collect::<Vec<_>>());
    let mut loads = DVector::from_element(face.len(), Complex64::ZERO);
    for (&(start, t, _, weight), value) in at.iter().zip(values) {
        loads[start] += weight * (1.0 - t) * value;
        loads[start + 1] += weight * t * value;
    }
    let solution = consistent_mass(face).map(Complex64::from).lu().solve(&loads).unwrap();
    solution.iter().copied().collect()
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

/// The same, and the force (N/m) beside it.
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
        let number = |variable: interface::Variable| {
            let mut value = [0.0];
            unit.get(variable.value_reference, &mut value).map(|()| value[0])
        };
        result.push((end, [number(BASE_PRESSURE)?, number(TOTAL_FORCE)?]));
    }
    Ok(result)
}
