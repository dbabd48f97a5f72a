//! Every time-stepping method for compressible water, against closed forms and passivity.

use crate::rectangular;
use crate::shipped;

use cofferdam_reservoir::analytical::chopra_1967;
use cofferdam_reservoir::{Method, Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir::{
    BASE_PRESSURE, GROUND_ACCELERATION, INTERFACE_ACCELERATION, INTERFACE_PRESSURE, TOTAL_FORCE,
};
use cofferdam_unit::{CoSimulation, WetFace};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, base_pressures, parameters, rising_ground};
use shipped::{read, velocities};
use std::f64::consts::PI;

const RECORD: &str = "northridge-1994-canyon-country-270";
const CONVOLUTIONS: [Method; 4] = [Method::Bdf2, Method::Trapezoid, Method::Radau2, Method::Radau3];

fn number(unit: &Reservoir, variable: cofferdam_unit::Variable) -> f64 {
    let mut value = [0.0];
    unit.get(variable.value_reference, &mut value).unwrap();
    value[0]
}

/// A ramp of acceleration in 0.1 s, then held, H = 5 ms: the largest error of the base pressure in 2 s, eight echoes (0.5 s, two
/// echoes, with the methods that take long to prepare), divided by its peak.
#[test]
fn ramp_and_hold() -> Result<(), ReservoirError> {
    use rectangular::ramp_and_hold::{base_pressure as exact, velocity};
    // BDF2 and the trapezoidal rule are of order 2.
    for (method, duration, most) in [
        (Method::Bdf2, 2.0, 1e-2),
        (Method::Trapezoid, 0.5, 5e-3),
        (Method::Radau2, 2.0, 1e-3),
        (Method::Radau3, 0.5, 1e-3),
        (Method::Recursive, 2.0, 1e-3),
    ] {
        let element_size = DEPTH / 12.0;
        let parameters = ReservoirParameters { method, element_size, ..parameters(1.0, 20, 0.005, duration) };
        let pressures = base_pressures(parameters, velocity)?;
        let peak = pressures.iter().fold(0.0, |m: f64, &(t, _)| m.max(exact(t).abs()));
        let error = pressures.iter().fold(0.0, |m: f64, &(t, p)| m.max((p - exact(t)).abs())) / peak;
        println!("ramp and hold, {method:?}, H = 5 ms: error {error:.2e} of the peak");
        assert!(error < most);
    }
    Ok(())
}

/// A shipped record on a rigid dam, its first `duration` s, α = 1, H = 5 ms: the relative L2 error of the base pressure with
/// `elements` over the depth is less than `most`.
fn record_follows_the_closed_form(
    name: &str,
    duration: f64,
    (method, elements): (Method, f64),
    most: f64,
) -> Result<(), ReservoirError> {
    let (h, record) = (0.005, read(name));
    let duration = duration.min(record[record.len() - 1].0);
    let exact = response(&record, h, (duration / h).round() as usize);
    let velocity = velocities(&record, h, exact.len());
    let parameters =
        ReservoirParameters { method, element_size: DEPTH / elements, ..parameters(1.0, 20, h, duration) };
    let pressures = base_pressures(parameters, |t| velocity[(t / h).round() as usize])?;
    let (mut off, mut whole) = (0.0, 0.0);
    for (&(_, p), exact) in pressures.iter().zip(&exact[1..]) {
        off += (p - exact).powi(2);
        whole += exact * exact;
    }
    let error = (off / whole).sqrt();
    println!("{name}, {duration} s, {method:?}, H = 5 ms: relative L2 error {error:.2e}");
    assert!(error < most);
    Ok(())
}

/// The recursion for the whole records. The convolution, which takes longer to prepare, for the first 8 s of one of them, its
/// strong part; that of three stages has such a test over absorbing beds (`whole_record.rs`).
#[test]
fn records() -> Result<(), ReservoirError> {
    for name in [RECORD, "northridge-1994-beverly-hills-279", "loma-prieta-1989-corralitos-038"] {
        record_follows_the_closed_form(name, f64::INFINITY, (Method::Recursive, 10.0), 1e-3)?;
    }
    record_follows_the_closed_form(RECORD, 8.0, (Method::Radau2, 10.0), 5e-3)
}

#[test]
#[ignore = "takes a minute of processor time: `cargo test --release -p cofferdam-reservoir -- --ignored`"]
fn records_by_convolutions_of_two_and_three_stages() -> Result<(), ReservoirError> {
    record_follows_the_closed_form(RECORD, f64::INFINITY, (Method::Radau2, 10.0), 5e-3)?;
    record_follows_the_closed_form(RECORD, 8.0, (Method::Radau3, 16.0), 1e-3)
}

/// The recursion against the convolution by Radau's method of two stages, which shares only the frequency response with
/// it: force in 6 s of a record, H = 5 ms. Also with panels that are finer than the elements.
/// Level beds are compared with an inversion of their closed form (`whole_record.rs`).
#[test]
fn a_recursion_equals_the_convolution() -> Result<(), ReservoirError> {
    let (h, steps) = (0.005, 1200);
    let velocity = velocities(&read(RECORD), h, steps + 1);
    let sloped = |panels: usize, element_size: f64| ReservoirParameters {
        bed: vec![[-60.0, 0.0], [-140.0, 40.0]],
        bed_element_size: Some(15.0),
        wet_face: WetFace::straight([30.0, DEPTH], panels).unwrap(),
        element_size,
        ..parameters(0.8, 12, h, 6.0)
    };
    for (name, parameters) in [
        ("battered face, rising bed, α = 0.8", sloped(12, 15.0)),
        ("the same, 24 panels, 9 elements", sloped(24, 22.0)),
    ] {
        let mut forces = Vec::new();
        for method in [Method::Radau2, Method::Recursive] {
            let mut unit = Reservoir::new(ReservoirParameters { method, ..parameters.clone() }, THREADS)?;
            unit.initialise(0.0)?;
            let normals: Vec<f64> = unit.parameters().wet_face.normals().iter().map(|n| n[0]).collect();
            let mut force = Vec::new();
            for step in 0..steps {
                let mean = (velocity[step + 1] - velocity[step]) / h;
                let along: Vec<f64> = normals.iter().map(|n| n * mean).collect();
                unit.set(INTERFACE_ACCELERATION.value_reference, &along)?;
                unit.step(step as f64 * h, h)?;
                force.push(number(&unit, TOTAL_FORCE));
            }
            forces.push(force);
        }
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let off = norm(&mut forces[0].iter().zip(&forces[1]).map(|(a, b)| a - b))
            / norm(&mut forces[0].iter().copied());
        println!("recursion against convolution, {name}: force differs by {off:.1e}");
        assert!(off < 2e-3);
    }
    Ok(())
}

/// Base pressure (Pa) at the steps' ends for a piecewise linear acceleration, by sums of the response to a ramp.
fn response(record: &[(f64, f64)], h: f64, steps: usize) -> Vec<f64> {
    let interval = record[1].0 - record[0].0;
    let every = (interval / h).round() as usize;
    assert!((every as f64 * h - interval).abs() < 1e-9 && record[0].0 == 0.0);
    let at = |n: usize| n as f64 * h;
    let ramp: Vec<f64> = (0..=steps)
        .map(|n| chopra_1967::base_pressure_of_acceleration_ramp(DEPTH, SOUND_SPEED, at(n)))
        .collect();
    let mut last = 0.0;
    let mut bends: Vec<f64> = record
        .windows(2)
        .map(|pair| {
            let slope = (pair[1].1 - pair[0].1) / interval;
            slope - std::mem::replace(&mut last, slope)
        })
        .collect();
    bends.push(-last);
    (0..=steps)
        .map(|n| {
            let start = chopra_1967::base_pressure_of_acceleration_step(DEPTH, SOUND_SPEED, at(n));
            let bent: f64 = bends
                .iter()
                .enumerate()
                .take_while(|(k, _)| k * every <= n)
                .map(|(k, b)| b * ramp[n - k * every])
                .sum();
            DENSITY * SOUND_SPEED * (record[0].1 * start + bent)
        })
        .collect()
}

/// An undamped mass on a spring, its frequency just below and just above the cut-off, light and heavy: the
/// water never gives back more energy than it has received, for 200 s (the convolution 50 s; finite elements, for which this is proved, 20 s).
#[test]
fn a_mass_at_the_cut_off_stays_bounded() -> Result<(), ReservoirError> {
    let (h, panels) = (0.005, 6);
    let cut_off = PI * SOUND_SPEED / (2.0 * DEPTH);
    for (method, duration) in
        [(Method::Radau2, 50.0), (Method::Recursive, 200.0), (Method::FiniteElements, 20.0)]
    {
        for alpha in [1.0, 0.9] {
            let parameters = ReservoirParameters { method, ..parameters(alpha, panels, h, duration) };
            let mut unit = Reservoir::new(parameters, THREADS)?;
            unit.initialise(0.0)?;
            let rest = unit.save_state();
            for (ratio, mass) in [(0.98, 0.1), (1.02, 0.1), (0.98, 10.0), (1.02, 10.0)] {
                unit.restore_state(&rest)?;
                let mass = mass * DENSITY * DEPTH * DEPTH;
                let stiffness = mass * (ratio * cut_off).powi(2);
                let (mut x, mut v, mut force) = (1.0, 0.0, 0.0);
                let first = 0.5 * stiffness;
                let (mut largest, mut slope): (f64, Option<f64>) = (0.0, None);
                for step in 0..(duration / h) as usize {
                    // The force at the end is linear in the acceleration of the step.
                    let state = unit.save_state();
                    let mut with = |a: f64| -> Result<f64, ReservoirError> {
                        unit.restore_state(&state)?;
                        unit.set(INTERFACE_ACCELERATION.value_reference, &[a; 7][..=panels])?;
                        unit.step(step as f64 * h, h)?;
                        Ok(number(&unit, TOTAL_FORCE))
                    };
                    let free = with(0.0)?;
                    let slope = match slope {
                        Some(slope) => slope,
                        None => *slope.insert(with(1.0)? - free),
                    };
                    // m a = ½(F + F') − k (x + ½Hv + ¼H²a)
                    let a = (0.5 * (force + free) - stiffness * (x + 0.5 * h * v))
                        / (mass - 0.5 * slope + 0.25 * h * h * stiffness);
                    force = with(a)?;
                    x += h * v + 0.5 * h * h * a;
                    v += h * a;
                    largest = largest.max((0.5 * mass * v * v + 0.5 * stiffness * x * x) / first);
                }
                let last = (0.5 * mass * v * v + 0.5 * stiffness * x * x) / first;
                println!(
                    "{method:?}, α = {alpha}, ω₀ = {ratio} ω₁, m = {:.1} ρh²: energy at most {largest:.4}, at last {last:.1e}",
                    mass / DENSITY / DEPTH / DEPTH
                );
                assert!(largest < 1.0 + 1e-6);
            }
        }
    }
    Ok(())
}

/// A recursion takes steps of any length: with the same velocities at their ends, linear in between, the same pressure.
#[test]
fn steps_may_vary() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.75] {
        let parameters =
            ReservoirParameters { method: Method::Recursive, ..parameters(alpha, 8, 0.0025, 1.0) };
        let points = parameters.wet_face.len();
        let mut ends = Vec::new();
        for lengths in [vec![0.0025; 400], vec![0.0125; 80], [0.0025, 0.005, 0.0075, 0.01].repeat(40)] {
            let mut unit = Reservoir::new(parameters.clone(), THREADS)?;
            unit.initialise(0.0)?;
            let mut time = 0.0;
            for length in lengths {
                unit.set(INTERFACE_ACCELERATION.value_reference, &vec![-2.0; points])?;
                unit.step(time, length)?;
                time += length;
            }
            ends.push(number(&unit, BASE_PRESSURE));
        }
        println!("α = {alpha}, 1 s in steps of three kinds: base pressure {ends:?} Pa");
        assert!(ends.iter().all(|p| (p / ends[0] - 1.0).abs() < 1e-11));
    }
    Ok(())
}

/// Save, step, restore, step, also through bytes in another unit, give the same bits with every method.
#[test]
fn states_repeat_every_bit() -> Result<(), ReservoirError> {
    for method in CONVOLUTIONS.into_iter().chain([Method::Recursive, Method::FiniteElements]) {
        let parameters = ReservoirParameters { method, ..parameters(0.75, 6, 0.005, 2.0) };
        let made = || -> Result<Reservoir, ReservoirError> {
            let mut unit = Reservoir::new(parameters.clone(), THREADS)?;
            unit.initialise(0.0)?;
            Ok(unit)
        };
        let advance = |unit: &mut Reservoir, step: usize| -> Result<Vec<u64>, ReservoirError> {
            let a: Vec<f64> = (0..7).map(|i| ((step * 7 + i) as f64).sin() * 3.0).collect();
            unit.set(INTERFACE_ACCELERATION.value_reference, &a)?;
            unit.set(GROUND_ACCELERATION.value_reference, &[1.0, (step as f64 * 0.3).cos()])?;
            unit.step(step as f64 * 0.005, 0.005)?;
            let mut p = vec![0.0; 7];
            unit.get(INTERFACE_PRESSURE.value_reference, &mut p)?;
            Ok(p.iter().map(|p| p.to_bits()).collect())
        };
        let (mut unit, mut other) = (made()?, made()?);
        for step in 0..200 {
            let state = unit.save_state();
            let first = advance(&mut unit, step)?;
            advance(&mut unit, step + 1)?;
            unit.restore_state(&state)?;
            assert_eq!(advance(&mut unit, step)?, first, "{method:?}, step {step}");
            if step % 50 == 49 {
                let state = unit.save_state();
                let read = other.deserialise_state(&unit.serialise_state(&state)?)?;
                other.restore_state(&read)?;
                let next = advance(&mut unit, step + 1)?;
                assert_eq!(advance(&mut other, step + 1)?, next, "{method:?}, step {step}, through bytes");
                unit.restore_state(&state)?;
            }
        }
    }
    Ok(())
}

/// Vertical motion of ground and dam against the one-dimensional wave: before the first echo `p = ρ c v` at the base.
#[test]
fn the_ground_moves_up() -> Result<(), ReservoirError> {
    let h = 0.0025;
    for method in [Method::Radau2, Method::Recursive, Method::FiniteElements] {
        for alpha in [1.0, 0.5] {
            let face = WetFace::straight([0.0, DEPTH], 20).unwrap();
            let parameters = ReservoirParameters {
                method,
                wave_reflection_coefficient: alpha,
                communication_step: h,
                horizon: 0.5,
                ..ReservoirParameters::before(face)
            };
            let mut unit = Reservoir::new(parameters, THREADS)?;
            unit.initialise(0.0)?;
            let exact = |t| rising_ground::base_pressure(alpha, t);
            let (mut off, mut peak): (f64, f64) = (0.0, 0.0);
            for step in 0..200 {
                let end = (step + 1) as f64 * h;
                unit.set(GROUND_ACCELERATION.value_reference, &[0.0, rising_ground::acceleration(end)])?;
                unit.step(step as f64 * h, h)?;
                off = off.max((number(&unit, BASE_PRESSURE) - exact(end)).abs());
                peak = peak.max(exact(end).abs());
            }
            println!(
                "vertical ground motion, {method:?}, α = {alpha}: base pressure off by {:.1e} of its peak",
                off / peak
            );
            assert!(off < 0.02 * peak);
        }
    }
    Ok(())
}
