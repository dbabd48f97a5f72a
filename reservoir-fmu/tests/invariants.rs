//! Passivity, signs, and independence of the number of threads, of cracks, and of the mesh.

use crate::rectangular;

use cofferdam_reservoir::{Method, Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir::{INTERFACE_ACCELERATION, INTERFACE_PRESSURE};
use cofferdam_unit::{CoSimulation, WetFace};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, parameters};

const STEPS: usize = 160;
const PANELS: usize = 8;
const METHODS: [Method; 4] = [Method::Radau2, Method::Radau3, Method::Recursive, Method::FiniteElements];

fn get(unit: &Reservoir) -> Vec<f64> {
    let mut p = vec![0.0; unit.parameters().wet_face.len()];
    unit.get(INTERFACE_PRESSURE.value_reference, &mut p).unwrap();
    p
}

/// Smallest work done on the water up to any step, divided by `ρc ∫∫ v² ds dt`; p and v are linear within a step.
fn least_work(unit: &mut Reservoir, velocities: &[Vec<f64>]) -> f64 {
    let h = unit.parameters().communication_step;
    let face = unit.parameters().wet_face.clone();
    let weighed =
        |a: &[f64], b: &[f64]| -> f64 { face.nodal_forces(a).iter().zip(b).map(|(f, v)| f[0] * v).sum() };
    let (mut p0, mut v0) = (vec![0.0; face.len()], vec![0.0; face.len()]);
    let (mut work, mut least, mut scale) = (0.0, 0.0f64, 0.0);
    for (step, v1) in velocities.iter().enumerate() {
        let a: Vec<f64> = v1.iter().zip(&v0).map(|(b, a)| (b - a) / h).collect();
        unit.set(INTERFACE_ACCELERATION.value_reference, &a).unwrap();
        unit.step(step as f64 * h, h).unwrap();
        let p1 = get(unit);
        let linear = |a0: &[f64], a1: &[f64], b0: &[f64], b1: &[f64]| {
            h / 6.0 * (2.0 * weighed(a0, b0) + weighed(a0, b1) + weighed(a1, b0) + 2.0 * weighed(a1, b1))
        };
        work -= linear(&p0, &p1, &v0, v1);
        scale += DENSITY * SOUND_SPEED * linear(&v0, v1, &v0, v1);
        least = least.min(work);
        (p0, v0) = (p1, v1.clone());
    }
    if scale > 0.0 { least / scale } else { 0.0 }
}

/// The water cannot give back more energy than it received. Random velocities, rough and smooth in
/// time and space.
#[test]
fn passivity() -> Result<(), ReservoirError> {
    let mut worst: f64 = 0.0;
    for (method, alpha) in METHODS.iter().flat_map(|&method| [(method, 1.0), (method, 0.5)]) {
        let parameters = ReservoirParameters { method, ..parameters(alpha, PANELS, 0.0025, 0.4) };
        let mut unit = Reservoir::new(parameters, THREADS)?;
        unit.initialise(0.0)?;
        let start = unit.save_state();
        let noise = prop::collection::vec(-1.0..1.0f64, STEPS * (PANELS + 1));
        let mut runner = TestRunner::new_with_rng(
            Config { cases: 60, failure_persistence: None, ..Config::default() },
            proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
        );
        let mut worst_here: f64 = 0.0;
        let cell = std::cell::RefCell::new((&mut unit, &mut worst_here));
        let outcome = runner.run(&(noise, 0.0..0.99f64, 0.0..1.0f64), |(noise, memory, uniform)| {
            let (unit, worst) = &mut *cell.borrow_mut();
            unit.restore_state(&start).unwrap();
            let mut state = vec![0.0; PANELS + 1];
            let velocities: Vec<Vec<f64>> = noise
                .chunks(PANELS + 1)
                .map(|row| {
                    for (v, x) in state.iter_mut().zip(row) {
                        *v = memory * *v + (1.0 - memory) * (uniform * row[0] + (1.0 - uniform) * x);
                    }
                    state.clone()
                })
                .collect();
            let least = least_work(unit, &velocities);
            **worst = worst.min(least);
            prop_assert!(least > -1e-6, "the water gave {least} of ρc∫v²");
            Ok(())
        });
        println!("passivity, {method:?}, α = {alpha}: least work {worst_here:.2e} of ρc∫v²");
        worst = worst.min(worst_here);
        assert!(outcome.is_ok(), "{outcome:?}");
    }
    println!("passivity: least work {worst:.2e}");
    Ok(())
}

/// The sampled operator: `−Re v*MĜ(θ)v ≥ 0` for every v and θ is passivity for any history, with every method.
///
/// Checked at 201 θ; the contour is damped by 1e-3 over the 2 s of weights. Before a battered face also with elements that are
/// coarser than the panels: velocities that the elements do not represent must not give energy.
fn sampled_operator_is_passive(
    method: Method,
    panels: usize,
    alpha: f64,
    batter: f64,
) -> Result<(), ReservoirError> {
    use nalgebra::{Complex, DMatrix, SymmetricEigen};
    let (h, steps) = (0.005, 400);
    let size = panels + 1;
    let parameters = ReservoirParameters {
        method,
        wet_face: WetFace::straight([batter * DEPTH, DEPTH], panels).unwrap(),
        element_size: DEPTH / if batter > 0.0 { 6.0 } else { panels as f64 },
        ..parameters(alpha, panels, h, 2.0)
    };
    let mut unit = Reservoir::new(parameters, THREADS)?;
    unit.initialise(0.0)?;
    let (start, face) = (unit.save_state(), unit.parameters().wet_face.clone());
    let normal = face.normals()[0];
    // Columns of M W_n from unit pulses of velocity, with the face's consistent mass M.
    let mut pulses = vec![DMatrix::zeros(size, size); steps];
    for column in 0..size {
        unit.restore_state(&start)?;
        for (step, weights) in pulses.iter_mut().enumerate() {
            let mut a = vec![0.0; size];
            a[column] = [1.0, -1.0, 0.0][step.min(2)] / h;
            unit.set(INTERFACE_ACCELERATION.value_reference, &a)?;
            unit.step(step as f64 * h, h)?;
            let forces = face.nodal_forces(&get(&unit));
            let along = forces.iter().map(|f| f[0] * normal[0] + f[1] * normal[1]);
            weights.set_column(column, &nalgebra::DVector::from_iterator(size, along));
        }
    }
    let scale = DENSITY * SOUND_SPEED * DEPTH / panels as f64;
    let mut least = f64::INFINITY;
    for k in 0..=200 {
        let theta = std::f64::consts::PI * k as f64 / 200.0;
        let mut symbol = DMatrix::<Complex<f64>>::zeros(size, size);
        for (n, weights) in pulses.iter().enumerate() {
            let factor = Complex::from_polar(1e-3f64.powf(n as f64 / steps as f64), -theta * n as f64);
            symbol.iter_mut().zip(weights).for_each(|(sum, weight)| *sum -= factor * weight);
        }
        let hermitian = (&symbol + symbol.adjoint()) * Complex::from(0.5 / scale);
        least = least.min(SymmetricEigen::new(hermitian).eigenvalues.min());
    }
    println!(
        "sampled operator, {panels} panels, {method:?}, α = {alpha}, batter {batter}: least eigenvalue {least:.1e} of ρc"
    );
    // Velocities that the elements do not represent cause no pressure, to rounding.
    assert!(least > if batter > 0.0 { -1e-12 } else { 0.0 });
    Ok(())
}

#[test]
fn passivity_of_the_sampled_operator() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.5] {
        for method in [Method::Radau2, Method::Radau3] {
            sampled_operator_is_passive(method, 8, alpha, 0.0)?;
        }
        for method in [Method::Recursive, Method::FiniteElements] {
            sampled_operator_is_passive(method, 16, alpha, 0.0)?;
        }
    }
    sampled_operator_is_passive(Method::Radau2, 16, 0.5, 0.2)?;
    sampled_operator_is_passive(Method::Recursive, 16, 0.5, 0.2)
}

#[test]
#[ignore = "takes a minute of processor time: `cargo test --release -p cofferdam-reservoir -- --ignored`"]
fn passivity_of_the_sampled_convolutions_with_sixteen_panels() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.5] {
        for method in [Method::Radau2, Method::Radau3] {
            sampled_operator_is_passive(method, 16, alpha, 0.0)?;
        }
    }
    Ok(())
}

/// A face that moves into the water compresses it at once, by about ρcv.
#[test]
fn sign_of_the_first_pressure() -> Result<(), ReservoirError> {
    let mut unit = Reservoir::new(parameters(0.6, PANELS, 0.0025, 0.1), THREADS)?;
    unit.initialise(0.0)?;
    assert!(get(&unit).iter().all(|p| *p == 0.0));
    unit.set(INTERFACE_ACCELERATION.value_reference, &[-4.0; PANELS + 1])?;
    unit.step(0.0, 0.0025)?;
    let p = get(&unit);
    let middle = p[PANELS / 2] / (DENSITY * SOUND_SPEED * 0.01);
    println!("first pressure in the middle: {middle:.3} ρcv");
    assert!((middle - 1.0).abs() < 0.05 && p[..PANELS].iter().all(|p| *p > 0.0));
    // The pressure falls to zero over cH, a sixth of a panel, but its projection, linear along the panel, does not.
    assert!((0.0..p[0]).contains(&p[PANELS]));
    let mut sensitivity = vec![0.0; PANELS + 1];
    let (unknown, known) = (INTERFACE_PRESSURE.value_reference, INTERFACE_ACCELERATION.value_reference);
    unit.directional_derivative(unknown, known, &[-4.0; PANELS + 1], &mut sensitivity)?;
    for (s, p) in sensitivity.iter().zip(&p) {
        assert!((s - p).abs() < 1e-12 * p.abs().max(1.0));
    }
    Ok(())
}

/// Results do not depend on the number of threads.
#[test]
fn threads_change_no_bit() -> Result<(), ReservoirError> {
    let mut pressures = Vec::new();
    for threads in [1, 2, 5] {
        let threads = std::num::NonZeroUsize::new(threads).unwrap();
        let mut unit = Reservoir::new(parameters(0.8, 6, 0.005, 0.5), threads)?;
        unit.initialise(0.0)?;
        for step in 0..100 {
            unit.set(INTERFACE_ACCELERATION.value_reference, &[(step as f64).sin(); 7])?;
            unit.step(step as f64 * 0.005, 0.005)?;
        }
        pressures.push(get(&unit));
    }
    assert!(pressures[0] == pressures[1] && pressures[0] == pressures[2]);
    Ok(())
}

/// A crack in the face: each side has the pressure of its own panels; uniform motion gives the same force.
#[test]
fn coinciding_points_carry_the_pressure_of_their_own_panels() -> Result<(), ReservoirError> {
    let y = [0.0, 40.0, 80.0, 116.0, 116.0, 150.0, DEPTH];
    let cracked = WetFace::new(y.iter().map(|y| [0.0, *y]).collect()).unwrap();
    let whole =
        WetFace::new([0.0, 40.0, 80.0, 116.0, 150.0, DEPTH].iter().map(|y| [0.0, *y]).collect()).unwrap();
    let s = cofferdam_reservoir::Complex64::new(1.0, 15.0);
    let response = |face: &WetFace| {
        let parameters = ReservoirParameters { wet_face: face.clone(), ..parameters(1.0, 24, 0.0025, 1.0) };
        let k = cofferdam_reservoir::frequency_response(&parameters, &[s], THREADS)?.remove(0);
        let pressure = rectangular::of_uniform_motion(&k, s);
        let force: cofferdam_reservoir::Complex64 =
            rectangular::consistent_mass(face).row_iter().zip(&pressure).map(|(row, p)| p * row.sum()).sum();
        Ok::<_, ReservoirError>((pressure, force))
    };
    let ((sides, with), (_, without)) = (response(&cracked)?, response(&whole)?);
    let jump = (sides[3] - sides[4]).norm() / sides[0].norm();
    let off = (with / without - 1.0).norm();
    println!(
        "uniform motion of a cracked face: sides of the crack differ by {jump:.1e} of the base, force by {off:.1e}"
    );
    // Error p″/12 times the panel length squared, 36 m against 180 m; the meshes differ.
    assert!(jump < 0.02 && off < 1e-4);
    Ok(())
}
