//! Incompressible water: Westergaard's series, the compressible model's limit, and energy.

use crate::rectangular;

use cofferdam_reservoir::analytical::chopra_1967::{self, STATIC_BASE_PRESSURE, STATIC_FORCE};
use cofferdam_reservoir::{
    Complex64, Fidelity, Reservoir, ReservoirError, ReservoirParameters, added_mass, frequency_response,
};
use cofferdam_unit::variables::reservoir::{FIDELITY, INTERFACE_ACCELERATION, INTERFACE_PRESSURE};
use cofferdam_unit::{CoSimulation, WetFace};
use nalgebra::{DVector, SymmetricEigen};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, consistent_mass, projected};
use std::f64::consts::PI;

fn parameters(elements: usize) -> ReservoirParameters {
    ReservoirParameters {
        fidelity: Fidelity::Incompressible,
        ..rectangular::parameters(1.0, elements, 0.01, 1.0)
    }
}

/// Pressure divided by ρa at the points of a face that moves uniformly into the water, m.
fn uniform(parameters: &ReservoirParameters) -> Result<Vec<f64>, ReservoirError> {
    Ok(added_mass(parameters)?.row_iter().map(|row| row.sum() / DENSITY).collect())
}

/// Force divided by ρa of a pressure that is linear along panels, m².
fn force(face: &WetFace, pressure: &[f64]) -> f64 {
    face.nodal_forces(pressure).iter().map(|f| f[0]).sum()
}

/// Westergaard's exact series, projected onto functions that are linear along the panels, m.
fn series(face: &WetFace) -> Vec<f64> {
    let s = Complex64::new(1e-9, 0.0);
    let at = |y: &f64| chopra_1967::pressure(s, DEPTH, SOUND_SPEED, *y);
    projected(face, |elevations| elevations.iter().map(at).collect()).iter().map(|p| p.re).collect()
}

/// Eight panels in all cases, so that only the elements change. Linear elements give second order, also for the force, an
/// integral. The corner at the surface, where p ~ r ln r, prevents a higher order.
#[test]
fn base_pressure_and_force_converge() -> Result<(), ReservoirError> {
    let face = WetFace::straight([0.0, DEPTH], 8).unwrap();
    let exact = series(&face);
    let mut errors = Vec::new();
    for elements in [4, 8, 16, 32, 64] {
        let p = uniform(&ReservoirParameters { wet_face: face.clone(), ..parameters(elements) })?;
        let error = [p[0] / exact[0] - 1.0, force(&face, &p) / (DEPTH * DEPTH * STATIC_FORCE) - 1.0];
        println!("{elements} elements: base pressure off by {:+.2e}, force by {:+.2e}", error[0], error[1]);
        errors.push(error.map(f64::abs));
    }
    for (what, index) in [("base pressure", 0), ("force", 1)] {
        let order = (errors[0][index] / errors[3][index]).log2() / 3.0;
        println!("{what}: order {order:.2} from 4 to 32 elements");
        assert!(order > 1.9 && errors[4][index] < 1e-5);
    }
    Ok(())
}

/// Against the closed forms without projection: with 64 panels the force is that of the elements. The base pressure of the
/// profile's projection onto functions that are linear along panels has an error of ℓ²p″/12, 1.2e-4 of it. Where elements
/// are as long as panels, their two nodes have an error of the same size in the pressure ~ r² ln r from half a hat of
/// velocity at the heel, and reciprocity passes it on. The profile is compared in mean square, as it is projected.
#[test]
fn closed_forms() -> Result<(), ReservoirError> {
    let parameters = parameters(64);
    let p = uniform(&parameters)?;
    let force = force(&parameters.wet_face, &p) / (DEPTH * DEPTH);
    let exact = series(&parameters.wet_face);
    let complex = |p: &[f64]| p.iter().map(|&p| p.into()).collect::<Vec<Complex64>>();
    let off = rectangular::difference(&parameters.wet_face, &complex(&p), &complex(&exact));
    let worst = p.iter().zip(&exact).map(|(p, q)| (p - q).abs() / DEPTH).fold(0.0, f64::max);
    println!(
        "64 elements: base {:.6} ρah against {STATIC_BASE_PRESSURE:.6}, force {force:.6} ρah² against \
         {STATIC_FORCE:.6}, profile off by {off:.1e}, beside the surface by {worst:.2e} ρah, at the base by {:.1e} of it",
        p[0] / DEPTH,
        p[0] / exact[0] - 1.0
    );
    let base = STATIC_BASE_PRESSURE;
    assert!((p[0] / DEPTH - base).abs() < 2e-4 * base && (p[0] / exact[0] - 1.0).abs() < 2e-4);
    assert!((force / STATIC_FORCE - 1.0).abs() < 1e-5 && off < 1e-4);
    Ok(())
}

/// `−K(s)/s → A`, and the difference falls like (s/c)², on a cracked battered face and for every motion, not
/// only the uniform one. Relative to a norm of A; rounding of K(s) limits the difference to about 1e-9.
#[test]
fn limit_of_the_compressible_model() -> Result<(), ReservoirError> {
    let points = [[0.0, 0.0], [2.0, 40.0], [4.0, 80.0], [4.0, 80.0], [6.0, 120.0], [9.0, DEPTH]];
    let incompressible =
        ReservoirParameters { wet_face: WetFace::new(points.to_vec()).unwrap(), ..parameters(16) };
    let compressible = ReservoirParameters { fidelity: Fidelity::Compressible, ..incompressible.clone() };
    let mass = added_mass(&incompressible)?;
    let mut differences = Vec::new();
    for ratio in [1e-1, 1e-2, 1e-3] {
        let s = Complex64::new(ratio * PI * SOUND_SPEED / (2.0 * DEPTH), 0.0);
        let limit =
            frequency_response(&compressible, &[s], THREADS)?.remove(0).columns(0, 6).map(|k| (-k / s).re);
        differences.push((limit - &mass).norm() / mass.norm());
        println!("s = {ratio} ω₁: −K(s)/s differs from A by {:.2e}", differences[differences.len() - 1]);
    }
    assert!(differences.windows(2).all(|d| d[1] < 0.02 * d[0]) && differences[2] < 1e-6);
    let s = [Complex64::new(0.3, 2.0)];
    let response = frequency_response(&incompressible, &s, THREADS)?.remove(0);
    assert!((response.columns(0, 6) + mass.map(|m| s[0] * m)).norm() == 0.0, "K(s) = −s A");
    Ok(())
}

/// κ_m = λ_m is exact for every mode; only waves as short as the elements depend on a far end at h/4.
#[test]
fn far_end_may_stand_anywhere_and_sound_and_bed_have_no_effect() -> Result<(), ReservoirError> {
    let at = |distance: f64| uniform(&ReservoirParameters { far_end_distance: distance, ..parameters(16) });
    let [near, middle, far] = [at(DEPTH / 4.0)?, at(DEPTH / 2.0)?, at(DEPTH)?];
    let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let spread = difference(&near, &middle).max(difference(&far, &middle)) / middle[0];
    println!("far end at h/4, h/2, h: pressures differ by {spread:.1e} of the base pressure");
    assert!(spread < 1e-4);
    let other =
        ReservoirParameters { sound_speed: 700.0, wave_reflection_coefficient: 0.3, ..parameters(16) };
    assert!(added_mass(&other)? == added_mass(&parameters(16))?);
    let refused = added_mass(&ReservoirParameters { fidelity: Fidelity::Compressible, ..parameters(4) });
    assert!(matches!(refused, Err(ReservoirError::Memory)));
    Ok(())
}

/// `aᵀ M_Γ A a` is twice the water's kinetic energy divided by a²: symmetric by reciprocity, to rounding, and positive for
/// every motion of the panels.
#[test]
fn energy_is_symmetric_and_positive() -> Result<(), ReservoirError> {
    for panels in [8, 16, 32] {
        let parameters = parameters(panels);
        let energy = consistent_mass(&parameters.wet_face) * added_mass(&parameters)?;
        let asymmetry = (&energy - energy.transpose()).norm() / energy.norm();
        let eigen = SymmetricEigen::new((&energy + energy.transpose()) / 2.0).eigenvalues;
        let [least, largest] = [eigen.min(), eigen.max()];
        // The water's mass on a panel that moves alone, divided by its length squared.
        let panel = DENSITY * (DEPTH / panels as f64).powi(2);
        println!(
            "{panels} panels: asymmetry {asymmetry:.1e}, eigenvalues from {:.1e} to 1, the least {:.1e} of ρℓ²",
            least / largest,
            least / panel
        );
        assert!(least > 0.0 && asymmetry < 1e-13);
    }
    Ok(())
}

/// Pressure is linear in the step's mean acceleration: to rounding, the derivative is the difference between a step and its
/// repetition with another mean.
#[test]
fn derivative_after_an_unequal_step() -> Result<(), ReservoirError> {
    let (known, unknown) = (INTERFACE_ACCELERATION.value_reference, INTERFACE_PRESSURE.value_reference);
    for fidelity in [Fidelity::Incompressible, Fidelity::Westergaard] {
        let mut unit = Reservoir::new(ReservoirParameters { fidelity, ..parameters(8) }, THREADS)?;
        unit.initialise(0.0)?;
        let [a, seed] = [1.0, 3.0].map(|k| [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| (k * f64::from(i)).cos()));
        unit.set(known, &a)?;
        unit.step(0.0, 0.01)?;
        let saved = unit.save_state();
        let mut pressure = |shift: f64| -> Result<_, ReservoirError> {
            unit.restore_state(&saved)?;
            let moved: Vec<f64> = a.iter().zip(seed).map(|(a, s)| a - 2.0 + shift * s).collect();
            unit.set(known, &moved)?;
            unit.step(0.01, 0.003)?;
            let (mut p, mut sensitivity) = ([0.0; 9], [0.0; 9]);
            unit.get(unknown, &mut p)?;
            unit.directional_derivative(unknown, known, &seed, &mut sensitivity)?;
            Ok((p, sensitivity))
        };
        let ((before, _), (after, sensitivity)) = (pressure(0.0)?, pressure(1.0)?);
        let size = sensitivity.iter().fold(0.0f64, |size, s| size.max(s.abs()));
        for ((before, after), s) in before.iter().zip(after).zip(sensitivity) {
            assert!((after - before - s).abs() < 1e-13 * size, "{fidelity:?}: {} {s}", after - before);
        }
    }
    Ok(())
}

/// The unit gives `−A a` with the acceleration a at the step's end.
#[test]
fn the_unit_gives_the_added_masses_pressure() -> Result<(), ReservoirError> {
    let parameters = parameters(8);
    let mass = added_mass(&parameters)?;
    let mut unit = Reservoir::new(parameters, THREADS)?;
    unit.initialise(0.0)?;
    let a: Vec<f64> = (0..9).map(|i| (i as f64).sin()).collect();
    let expected = mass * DVector::from_column_slice(&a);
    let mut time = 0.0;
    for length in [0.01, 0.003, 0.02] {
        unit.set(INTERFACE_ACCELERATION.value_reference, &a)?;
        unit.step(time, length)?;
        time += length;
        let mut p = [0.0; 9];
        unit.get(INTERFACE_PRESSURE.value_reference, &mut p)?;
        let factor = if time == 0.01 { 1.5 } else { 1.0 };
        for (p, e) in p.iter().zip(&expected) {
            assert!((p + factor * e).abs() < 1e-12 * expected.norm(), "{p} {e}");
        }
    }
    let mut code = [0.0];
    unit.get(FIDELITY.value_reference, &mut code)?;
    assert_eq!(code, [2.0]);
    assert!(unit.capabilities().variable_communication_step);
    Ok(())
}
