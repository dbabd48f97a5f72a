//! The time integrator against the exact motion for the dam's `SystemMatrices`.

use crate::support;

use cofferdam_dam::{Dam, DamError, DamParameters, Kinematics};
use cofferdam_unit::{CoSimulation, variables::dam as variable};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

const STEP: f64 = 0.01;
const STEPS: usize = 10;

fn pressure(time: f64, y: f64) -> f64 {
    2e5 * (30.0 * time).sin() * (1.0 - y / 120.0)
}

fn ground(time: f64) -> [f64; 2] {
    [3.0 * (20.0 * time).sin(), 1.0 - (15.0 * time).cos()]
}

/// Interface displacement and crest displacement of the dam after the steps.
fn by_dam(safety: f64) -> Result<(Dam, Vec<f64>, Vec<f64>), DamError> {
    let mut dam = Dam::new(DamParameters {
        cracks: Vec::new(),
        kinematics: Kinematics::Small,
        gravity: 0.0,
        time_step_safety: safety,
        ..support::koyna(12.0)
    })?;
    let heights: Vec<f64> = dam.wet_face().map_or(Vec::new(), |f| f.points().iter().map(|p| p[1]).collect());
    dam.initialise(0.0)?;
    for n in 0..STEPS {
        let end = (n + 1) as f64 * STEP;
        let values: Vec<f64> = heights.iter().map(|&y| pressure(end, y)).collect();
        dam.set(variable::INTERFACE_PRESSURE.value_reference, &values)?;
        dam.set(variable::GROUND_ACCELERATION.value_reference, &ground(end))?;
        dam.step(dam.state().time(), STEP)?;
    }
    let face = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    let crest = support::get(&dam, &variable::CREST_DISPLACEMENT);
    Ok((dam, face, crest))
}

/// The same by modal superposition of `SystemMatrices`. Each mode is integrated by the classical Runge–Kutta
/// method with an error below 1e-9.
fn by_modes(dam: &Dam) -> (Vec<f64>, Vec<f64>) {
    let m = dam.system_matrices();
    let n = m.mass.len();
    let root: Vec<f64> = m.mass.iter().map(|mass| mass.sqrt()).collect();
    let mut scaled = DMatrix::zeros(n, n);
    for &(i, j, k) in &m.stiffness {
        scaled[(i, j)] = k / (root[i] * root[j]);
    }
    let eigen = SymmetricEigen::new(scaled);
    let heights: Vec<f64> = dam.wet_face().map_or(Vec::new(), |f| f.points().iter().map(|p| p[1]).collect());
    let loads: Vec<DVector<f64>> = (0..=STEPS)
        .map(|step| {
            let time = step as f64 * STEP;
            let a = ground(time);
            let mut force = DVector::from_fn(n, |i, _| {
                -m.mass[i] * (m.ground_influence[0][i] * a[0] + m.ground_influence[1][i] * a[1])
            });
            for &(dof, point, weight) in &m.pressure_forces {
                force[dof] += weight * pressure(time, heights[point]);
            }
            eigen.eigenvectors.transpose() * DVector::from_fn(n, |i, _| force[i] / root[i])
        })
        .collect();
    let modal = DVector::from_fn(n, |mode, _| {
        let square = eigen.eigenvalues[mode];
        let damping = m.damping.mass + m.damping.stiffness * square;
        let substeps = 40 + (STEP * damping.max(square.sqrt()) * 4.0) as usize;
        let h = STEP / substeps as f64;
        let [mut q, mut w] = [0.0, 0.0];
        for pair in loads.windows(2) {
            for k in 0..substeps {
                let force = |share: f64| {
                    let s = (k as f64 + share) / substeps as f64;
                    pair[0][mode] * (1.0 - s) + pair[1][mode] * s
                };
                let slope = |q: f64, w: f64, share: f64| [w, force(share) - damping * w - square * q];
                let a = slope(q, w, 0.0);
                let b = slope(q + h / 2.0 * a[0], w + h / 2.0 * a[1], 0.5);
                let c = slope(q + h / 2.0 * b[0], w + h / 2.0 * b[1], 0.5);
                let d = slope(q + h * c[0], w + h * c[1], 1.0);
                q += h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0]);
                w += h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1]);
            }
        }
        q
    });
    let u = &eigen.eigenvectors * modal;
    let u: Vec<f64> = (0..n).map(|i| u[i] / root[i]).collect();
    let mut face = vec![0.0; heights.len()];
    for &(point, dof, weight) in &m.interface_motion {
        face[point] += weight * u[dof];
    }
    (face, m.crest.iter().map(|&dof| u[dof]).collect())
}

/// Damping lags by half a time step, so that the error is of first order in the time step: with steps ten
/// times shorter the error must be about ten times smaller, and below 1e-4.
#[test]
fn the_integrator_follows_its_matrices() -> Result<(), DamError> {
    let mut errors = Vec::new();
    for safety in [0.9, 0.09] {
        let (dam, face, crest) = by_dam(safety)?;
        let (face_exact, crest_exact) = by_modes(&dam);
        let largest = face_exact.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let pairs = || face.iter().zip(&face_exact).chain(crest.iter().zip(&crest_exact));
        let error = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        println!("safety {safety}: {} steps, error {error:.2e}", dam.time_steps_per(STEP));
        errors.push(error);
    }
    assert!(errors[1] < 1e-4 && errors[0] < 2e-3 && errors[1] < 0.2 * errors[0]);
    Ok(())
}

/// For a record that is linear in time the motion does not depend on the communication steps: steps of 10 ms,
/// or three unequal ones. Tolerance: the time steps differ, with an error of first order (see above).
#[test]
fn communication_steps_of_varying_length_agree() -> Result<(), DamError> {
    let crest = |steps: &[f64]| -> Result<f64, DamError> {
        let mut dam = support::at_rest(support::koyna(7.0))?;
        for &step in steps.iter().cycle().take(10 * steps.len()) {
            let time = dam.state().time();
            dam.set(variable::GROUND_ACCELERATION.value_reference, &[20.0 * (time + step), 0.0])?;
            dam.step(time, step)?;
        }
        Ok(support::get(&dam, &variable::CREST_DISPLACEMENT)[0])
    };
    let (even, uneven) = (crest(&[0.01])?, crest(&[0.003, 0.0021, 0.0049])?);
    println!("crest after 0.1 s: {even:.6e} m, with uneven steps {uneven:.6e} m");
    assert!((uneven / even - 1.0).abs() < 1e-3);
    Ok(())
}
