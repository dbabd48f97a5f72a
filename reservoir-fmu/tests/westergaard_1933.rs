//! The added mass: Westergaard's parabola, its derivative, and the difference from the compressible model.

use crate::rectangular;

use cofferdam_reservoir::analytical::{chopra_1967, westergaard_1933};
use cofferdam_reservoir::{
    Complex64, Fidelity, Reservoir, ReservoirError, ReservoirParameters, added_mass, frequency_response,
};
use cofferdam_unit::variables::reservoir::{INTERFACE_ACCELERATION, OVERTURNING_MOMENT, TOTAL_FORCE};
use cofferdam_unit::{CoSimulation, WetFace};
use nalgebra::{DVector, SymmetricEigen};
use rectangular::{DENSITY, DEPTH, THREADS, consistent_mass, parameters, projected};

fn unit(elements: usize) -> Result<Reservoir, ReservoirError> {
    let parameters =
        ReservoirParameters { fidelity: Fidelity::Westergaard, ..parameters(1.0, elements, 0.01, 1.0) };
    let mut unit = Reservoir::new(parameters, THREADS)?;
    unit.initialise(0.0)?;
    Ok(unit)
}

fn value(unit: &Reservoir, variable: cofferdam_unit::Variable) -> Result<f64, ReservoirError> {
    let mut value = [0.0];
    unit.get(variable.value_reference, &mut value)?;
    Ok(value[0])
}

/// A constant acceleration, the same pressure from the second step on, no horizon. Force and moment are integrals with
/// functions that the hats contain, so they are exact on any panels.
#[test]
fn parabola() -> Result<(), ReservoirError> {
    let mut unit = unit(3)?;
    let scale = DENSITY * 2.0 * DEPTH * DEPTH;
    for step in 0..300 {
        unit.set(INTERFACE_ACCELERATION.value_reference, &[-2.0; 4])?;
        unit.step(step as f64 * 0.01, 0.01)?;
        if step == 0 {
            continue;
        }
        let force = value(&unit, TOTAL_FORCE)? / scale;
        // ∫ √(1 − η) η dη = 4/15
        let moment = value(&unit, OVERTURNING_MOMENT)? / (scale * DEPTH);
        let off = [force / westergaard_1933::FORCE - 1.0, moment / (0.875 * 4.0 / 15.0) - 1.0];
        assert!(off.iter().all(|off| off.abs() < 1e-12), "step {step}: {off:?}");
    }
    Ok(())
}

/// `ρ ∫ w yᵏ ds`, k = 0, 1, 2, from the matrix on irregular panels of a battered face with a crack, against the closed
/// forms; that of the series, whose u² ln u is no polynomial, against the force 14ζ(3)/π³. Half a hat more or less, or
/// a matrix that is not symmetric, would show in none but these.
#[test]
fn moments_of_the_profile_are_exact_on_any_panels() -> Result<(), ReservoirError> {
    let height = 90.0;
    let at = |y: f64| [0.2 * y, y];
    let face = WetFace::new([0.0, 7.0, 33.0, 60.0, 60.0, 82.0, height].map(at).to_vec()).unwrap();
    let batter = 0.2f64.hypot(1.0);
    let moved = |fidelity| {
        let water = ReservoirParameters { fidelity, ..ReservoirParameters::before(face.clone()) };
        added_mass(&water).map(|mass| consistent_mass(&face) * mass)
    };
    let parabola = moved(Fidelity::Westergaard)?;
    let [constant, linear] =
        [0, 1].map(|power| DVector::from_fn(face.len(), |i, _| (face.points()[i][1] / height).powi(power)));
    // ∫ √(1 − η) ηᵏ dη = 2/3, 4/15, 16/105
    let moments = [
        (&constant, &constant, 2.0 / 3.0),
        (&constant, &linear, 4.0 / 15.0),
        (&linear, &linear, 16.0 / 105.0),
    ];
    for (k, (a, b, exact)) in moments.into_iter().enumerate() {
        let found = a.dot(&(&parabola * b)) / (DENSITY * batter * height * height);
        let off = found / (0.875 * exact) - 1.0;
        println!("parabola, moment {k}: off by {off:.1e}");
        assert!(off.abs() < 1e-13);
    }
    assert!((&parabola - parabola.transpose()).norm() < 1e-14 * parabola.norm());
    assert!(SymmetricEigen::new(parabola).eigenvalues.min() > 0.0);
    let force = constant.dot(&(moved(Fidelity::WestergaardExact)? * &constant))
        / (DENSITY * batter * height * height);
    let off = force / chopra_1967::STATIC_FORCE - 1.0;
    println!("series: force off by {off:.1e}");
    assert!(off.abs() < 1e-7);
    Ok(())
}

/// A smooth pulse in steps of lengths in the ratios 1 : 2 : 1/2 : 3/2: extrapolation of the means to the step's
/// end is of second order, as with equal ones.
#[test]
fn second_order_in_steps_of_varying_length() -> Result<(), ReservoirError> {
    let mass = DENSITY * westergaard_1933::FORCE * DEPTH * DEPTH;
    // a = sin⁴(πt/T), v = ∫a
    let pulse = 0.4;
    let acceleration = |t: f64| (std::f64::consts::PI * t / pulse).sin().powi(4);
    let velocity = |t: f64| {
        let x = 2.0 * std::f64::consts::PI * t / pulse;
        0.375 * t - pulse / (4.0 * std::f64::consts::PI) * (x.sin() - (2.0 * x).sin() / 8.0)
    };
    let mut errors = Vec::new();
    for scale in [0.008, 0.004, 0.002, 0.001] {
        let mut unit = unit(4)?;
        let (mut time, mut worst) = (0.0, 0.0f64);
        for ratio in [1.0, 2.0, 0.5, 1.5].into_iter().cycle() {
            let (length, end) = (ratio * scale, time + ratio * scale);
            if end > pulse {
                break;
            }
            let mean = (velocity(end) - velocity(time)) / length;
            unit.set(INTERFACE_ACCELERATION.value_reference, &[mean; 5])?;
            unit.step(time, length)?;
            worst = worst.max((value(&unit, TOTAL_FORCE)? / -mass - acceleration(end)).abs());
            time = end;
        }
        println!("sin⁴ pulse, steps of {scale} s times 1, 2, ½, 1½: largest error {worst:.2e} of the peak");
        errors.push(worst);
    }
    let order = (errors[0] / errors[3]).log2() / 3.0;
    println!("Westergaard, steps of varying length: order {order:.2}");
    assert!(order > 1.9);
    Ok(())
}

/// BDF2 on exact end velocities: 1.5 times this step's mean minus 0.5 times the last one.
#[test]
fn acceleration_at_the_end_of_the_step() -> Result<(), ReservoirError> {
    let mut unit = unit(4)?;
    let mass = DENSITY * westergaard_1933::FORCE * DEPTH * DEPTH;
    for (step, (mean, end)) in [(1.0, 1.5), (3.0, 4.0), (-1.0, -3.0)].into_iter().enumerate() {
        unit.set(INTERFACE_ACCELERATION.value_reference, &[mean; 5])?;
        unit.step(step as f64 * 0.01, 0.01)?;
        let force = value(&unit, TOTAL_FORCE)?;
        assert!((force / (-mass * end) - 1.0).abs() < 1e-12);
    }
    let mut sensitivity = [0.0];
    let (force, a) = (TOTAL_FORCE.value_reference, INTERFACE_ACCELERATION.value_reference);
    unit.directional_derivative(force, a, &[1.0; 5], &mut sensitivity)?;
    assert!((sensitivity[0] / (-1.5 * mass) - 1.0).abs() < 1e-12);
    let s = Complex64::new(0.1, 2.0);
    let k = frequency_response(unit.parameters(), &[s], THREADS)?.remove(0);
    let whole = consistent_mass(&unit.parameters().wet_face).map(Complex64::from) * k.columns(0, 5);
    assert!((whole.sum() + s * mass).norm() < 1e-12 * mass);
    Ok(())
}

/// The closed sum against the constants of the series, against the series itself summed to N = 10⁶ terms, which leaves
/// at most 8/π² / (4N² sin θ) by Abel's summation, and against the force by Simpson's rule in η = 1 − x⁴, which removes
/// the logarithm at the surface.
#[test]
fn series() -> Result<(), ReservoirError> {
    let exact = |eta: f64| westergaard_1933::series_pressure(1.0, eta);
    let base = exact(0.0) - chopra_1967::STATIC_BASE_PRESSURE;
    let slow = |eta: f64| -> f64 {
        let odd = |m: i32| f64::from(2 * m + 1);
        let term = |m: i32| (0.5 * std::f64::consts::PI * odd(m) * (1.0 - eta)).sin() / odd(m).powi(2);
        (0..1_000_000).rev().map(term).sum::<f64>() * 8.0 / std::f64::consts::PI.powi(2)
    };
    for eta in [0.0, 0.3, 0.77, 0.99, 1.0 - 1e-4] {
        let off = (exact(eta) - slow(eta)).abs();
        let left =
            8.0 / std::f64::consts::PI.powi(2) / (4e12 * (0.5 * std::f64::consts::PI * (1.0 - eta)).sin());
        println!("η = {eta}: off by {off:.1e} ρah, of which the million terms leave at most {left:.1e}");
        assert!(off < left + 1e-14);
    }
    let count = 2000;
    let weight = |i: i32| if i == 0 || i == count { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    let integrand = |x: f64| 4.0 * x.powi(3) * exact(1.0 - x.powi(4));
    let force = (0..=count).map(|i| weight(i) * integrand(f64::from(i) / f64::from(count))).sum::<f64>()
        / (3.0 * f64::from(count))
        - chopra_1967::STATIC_FORCE;
    println!("series: base off by {base:.1e} ρah, force by {force:.1e} ρah²");
    assert!(base.abs() < 1e-15 && force.abs() < 1e-12 && exact(1.0) == 0.0);
    let unit = ReservoirParameters { fidelity: Fidelity::WestergaardExact, ..parameters(1.0, 16, 0.01, 1.0) };
    let pressure = added_mass(&unit)?.column_sum() / DENSITY;
    let profile = |elevations: &[f64]| -> Vec<Complex64> {
        elevations.iter().map(|y| westergaard_1933::series_pressure(DEPTH, *y).into()).collect()
    };
    for (found, exact) in pressure.iter().zip(projected(&unit.wet_face, profile)) {
        assert!((found - exact.re).abs() < 1e-6 * DEPTH, "{found} m against {exact} m");
    }
    Ok(())
}
