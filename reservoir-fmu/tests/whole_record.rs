//! The pressure under a whole record at once; and, over an absorbing bed, all time-stepping methods, against an independent
//! inversion of Fenves and Chopra's closed form.

use crate::rectangular;
use crate::shipped;

use cofferdam_reservoir::analytical::{chopra_1967, fenves_chopra_1984};
use cofferdam_reservoir::{
    Complex64, Fidelity, Method, ReservoirError, ReservoirParameters, added_mass, ground_added_mass,
    pressure_of_record,
};
use cofferdam_unit::WetFace;
use nalgebra::DMatrix;
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, parameters, rising_ground, stepped};
use shipped::{accelerations, read, velocities};
use std::f64::consts::PI;
use std::num::NonZeroUsize;

const RECORD: &str = "northridge-1994-canyon-country-270";

/// The whole face moves towards the water with `acceleration`, the ground rests.
fn towards_the_water(points: usize, acceleration: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(
        points + 2,
        acceleration.len(),
        |row, n| if row < points { -acceleration[n] } else { 0.0 },
    )
}

/// Relative L2 difference.
fn apart(found: &[f64], exact: &[f64]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    (square(&mut found.iter().zip(exact).map(|(a, b)| a - b)) / square(&mut exact.iter().copied())).sqrt()
}

/// Base pressure (Pa) and force (N/m) by the transform for an acceleration towards the water.
fn at_once(water: &ReservoirParameters, acceleration: &[f64]) -> Result<[Vec<f64>; 2], ReservoirError> {
    let face = &water.wet_face;
    let pressure = pressure_of_record(water, &towards_the_water(face.len(), acceleration), THREADS)?;
    let force = |p: &[f64]| face.nodal_forces(p).iter().map(|force| force[0]).sum();
    let forces = pressure.column_iter().map(|p| force(p.as_slice())).collect();
    Ok([pressure.row(0).iter().copied().collect(), forces])
}

/// A ramp of acceleration in 0.1 s, then held for 2 s, over a rigid bed: largest error, divided by the peak. The elements of
/// h/20, also used for the time-stepping methods, have an error of 2.6e-4 (`methods.rs`).
#[test]
fn ramp_and_hold() -> Result<(), ReservoirError> {
    let record = [(0.0, 0.0), (0.1, 1.0)];
    for h in [0.01, 0.005] {
        let times: Vec<f64> = (0..=(2.0 / h) as usize).map(|n| n as f64 * h).collect();
        let moved: Vec<f64> = times.iter().map(|t| (t / 0.1).min(1.0)).collect();
        let [found, _] = at_once(&parameters(1.0, 20, h, 2.0), &moved)?;
        let exact: Vec<f64> = times
            .iter()
            .map(|&t| DENSITY * SOUND_SPEED * chopra_1967::base_pressure(&record, DEPTH, SOUND_SPEED, t))
            .collect();
        let peak = exact.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        let error = found.iter().zip(&exact).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / peak;
        println!("ramp and hold, H = {h} s: error {error:.2e} of the peak");
        assert!(error < 1e-3);
    }
    Ok(())
}

/// Ten seconds of a shipped record over a rigid bed: relative L2 error of the base pressure, and of its last tenth, where
/// undoing the damping magnifies most, and motion is weak.
#[test]
fn a_record_over_a_rigid_bed() -> Result<(), ReservoirError> {
    let (h, steps, record) = (0.005, 2000, read(RECORD));
    let moved = accelerations(&record, h, steps + 1);
    // Sum of responses to ramps that begin at the samples.
    let ramp: Vec<f64> = (0..=steps)
        .map(|n| chopra_1967::base_pressure_of_acceleration_ramp(DEPTH, SOUND_SPEED, n as f64 * h))
        .collect();
    let slope = |n: usize| if n < steps { (moved[n + 1] - moved[n]) / h } else { 0.0 };
    let kinks: Vec<f64> = (0..=steps).map(|n| slope(n) - if n > 0 { slope(n - 1) } else { 0.0 }).collect();
    let exact: Vec<f64> = (0..=steps)
        .map(|n| {
            let start = chopra_1967::base_pressure_of_acceleration_step(DEPTH, SOUND_SPEED, n as f64 * h);
            let bent: f64 = (0..=n).map(|k| kinks[k] * ramp[n - k]).sum();
            DENSITY * SOUND_SPEED * (moved[0] * start + bent)
        })
        .collect();
    let [found, _] = at_once(&parameters(1.0, 20, h, 1.0), &moved)?;
    let late = steps * 9 / 10;
    let [error, at_last] = [apart(&found, &exact), apart(&found[late..], &exact[late..])];
    println!(
        "{RECORD}, {steps} steps, α = 1: base pressure off by {error:.2e}, in the last tenth by {at_last:.2e}"
    );
    assert!(error < 1e-3 && at_last < 3e-3);
    Ok(())
}

/// Response at the ends of `steps` steps of `h` to a record of acceleration, linear between its samples, of a system whose
/// response to `e^{st}` is `response`: Bromwich's integral by the trapezoidal rule, summed term by term, e^{−σP} = 1e-6 with P one
/// and a half times the record, up to the `zeros`-th frequency at which the transform of the record's hats vanishes.
fn inverted(
    record: &[(f64, f64)],
    [h, zeros]: [f64; 2],
    steps: usize,
    response: impl Fn(Complex64) -> Complex64 + Sync,
) -> Vec<f64> {
    let period = 1.5 * steps as f64 * h;
    let sigma = 1e6f64.ln() / period;
    let interval = record[1].0 - record[0].0;
    let count = (period * zeros / interval).round() as usize;
    let slopes: Vec<f64> = record.windows(2).map(|p| (p[1].1 - p[0].1) / (p[1].0 - p[0].0)).collect();
    let kinks = |k: usize| slopes.get(k).unwrap_or(&0.0) - if k > 0 { slopes[k - 1] } else { 0.0 };
    let at = |k: usize| {
        let s = Complex64::new(sigma, 2.0 * PI * k as f64 / period);
        let bent: Complex64 = (0..record.len()).map(|j| kinks(j) * (-s * record[j].0).exp()).sum();
        response(s) * (record[0].1 / s + bent / (s * s))
    };
    // Higher frequencies take longer.
    let terms = std::thread::scope(|scope| {
        let odd = scope.spawn(|| (1..count).step_by(2).map(at).collect::<Vec<_>>());
        let even: Vec<Complex64> = (0..count).step_by(2).map(at).collect();
        let odd = odd.join().unwrap();
        (0..count).map(|k| if k % 2 == 0 { even[k / 2] } else { odd[k / 2] }).collect::<Vec<_>>()
    });
    (0..=steps)
        .map(|n| {
            let turn = Complex64::from_polar(1.0, 2.0 * PI * n as f64 * h / period);
            let (mut sum, mut power) = (0.5 * terms[0].re, turn);
            for term in &terms[1..] {
                sum += (term * power).re;
                power *= turn;
            }
            2.0 / period * (sigma * n as f64 * h).exp() * sum
        })
        .collect()
}

/// Over a rigid bed the inversion agrees with the closed form in time, which has no integral.
#[test]
fn the_inversion_is_right_over_a_rigid_bed() {
    let (h, steps, record) = (0.01, 300, [(0.0, 0.0), (0.05, 1.0), (0.1, -0.5), (0.15, 0.0)]);
    let found = inverted(&record, [h, 8.0], steps, |s| {
        fenves_chopra_1984::pressures(s, DEPTH, SOUND_SPEED, 1.0, &[0.0])[0]
    });
    let exact: Vec<f64> = (0..=steps)
        .map(|n| SOUND_SPEED * chopra_1967::base_pressure(&record, DEPTH, SOUND_SPEED, n as f64 * h))
        .collect();
    let error = apart(&found, &exact);
    println!("inversion of the closed form: {error:.1e} off the closed form in time");
    assert!(error < 1e-4);
}

/// Eight seconds of a shipped record over an absorbing bed, H = 5 ms, h/12: relative L2 error of the force and, for
/// α = 0.9 only, because its inversion takes long, of the base pressure. Its closed form holds at a point; it is not the
/// mean over a panel of 15 m.
fn over_an_absorbing_bed(alpha: f64) -> Result<(), ReservoirError> {
    let (h, steps) = (0.005, 1600);
    let record: Vec<(f64, f64)> =
        read(RECORD).into_iter().take_while(|(t, _)| *t < (steps as f64 + 0.5) * h).collect();
    let force = inverted(&record, [h, 2.0], steps, |s| {
        DENSITY * fenves_chopra_1984::force(s, DEPTH, SOUND_SPEED, alpha)
    });
    let base = (alpha == 0.9).then(|| {
        inverted(&record, [h, 1.0], steps, |s| {
            DENSITY * fenves_chopra_1984::pressures(s, DEPTH, SOUND_SPEED, alpha, &[0.0])[0]
        })
    });
    let water = parameters(alpha, 12, h, steps as f64 * h);
    let check = |name: &str, [found_base, found_force]: [Vec<f64>; 2], most: f64| {
        let of_force = apart(&found_force, &force[1..]);
        let of_base = base.as_ref().map(|base| apart(&found_base, &base[1..]));
        let said = of_base.map_or_else(String::new, |error| format!(", base pressure by {error:.2e}"));
        println!("α = {alpha}, {name}: force off by {of_force:.2e}{said}");
        assert!(of_force < most && of_base.is_none_or(|error| error < 5e-3));
    };
    let whole = at_once(&water, &accelerations(&record, h, steps + 1))?;
    check("whole record", whole.map(|history| history[1..].to_vec()), 5e-3);
    let velocity = velocities(&record, h, steps + 1);
    for (method, most) in [(Method::Radau2, 5e-3), (Method::Radau3, 5e-3), (Method::Recursive, 1.5e-3)] {
        let water = ReservoirParameters { method, ..water.clone() };
        let found = stepped(water, |t| velocity[(t / h).round() as usize])?;
        let histories = [0, 1].map(|i| found.iter().map(|(_, values)| values[i]).collect());
        check(&format!("{method:?}"), histories, most);
    }
    Ok(())
}

#[test]
fn absorbing_bed_of_nine_tenths() -> Result<(), ReservoirError> {
    over_an_absorbing_bed(0.9)
}

#[test]
fn absorbing_bed_of_a_half() -> Result<(), ReservoirError> {
    over_an_absorbing_bed(0.5)
}

#[test]
fn absorbing_bed_that_returns_nothing() -> Result<(), ReservoirError> {
    over_an_absorbing_bed(0.0)
}

/// Ground and dam rise together: one column of water, whose echoes over a rigid bed never end.
#[test]
fn the_ground_moves_up() -> Result<(), ReservoirError> {
    let (h, count) = (0.0025, 401);
    for alpha in [1.0, 0.5] {
        let water = parameters(alpha, 20, h, 1.0);
        let points = water.wet_face.len();
        let exact = |t| rising_ground::base_pressure(alpha, t);
        let motion = DMatrix::from_fn(points + 2, count, |row, n| {
            if row == points + 1 { rising_ground::acceleration(n as f64 * h) } else { 0.0 }
        });
        let found = pressure_of_record(&water, &motion, THREADS)?;
        let (mut off, mut peak): (f64, f64) = (0.0, 0.0);
        for n in 0..count {
            off = off.max((found[(0, n)] - exact(n as f64 * h)).abs());
            peak = peak.max(exact(n as f64 * h).abs());
        }
        println!("vertical motion, α = {alpha}: base pressure off by {:.1e} of its peak", off / peak);
        assert!(off < 5e-3 * peak);
    }
    Ok(())
}

/// Water without memory gives `−A a`. One and two threads give the same bits.
#[test]
fn added_mass_and_threads() -> Result<(), ReservoirError> {
    let moved: Vec<f64> = (0..50).map(|n| (f64::from(n) * 0.4).sin()).collect();
    let water = parameters(0.7, 6, 0.01, 1.0);
    let still = ReservoirParameters { fidelity: Fidelity::Incompressible, ..water.clone() };
    let points = water.wet_face.len();
    let motion = DMatrix::from_fn(points + 2, 50, |row, n| moved[n] * (row as f64 - 3.0));
    let found = pressure_of_record(&still, &motion, THREADS)?;
    let mass = added_mass(&still)?;
    let ground = ground_added_mass(&still)?;
    for n in [0, 7, 49] {
        let a = motion.column(n);
        let expected = -(&mass * a.rows(0, points) + &ground * a.rows(points, 2));
        assert!((found.column(n) - &expected).norm() <= 1e-14 * expected.norm());
    }
    let [one, two] = [1, 2].map(|n| NonZeroUsize::new(n).unwrap());
    let both = [pressure_of_record(&water, &motion, one)?, pressure_of_record(&water, &motion, two)?];
    assert!(both[0].iter().zip(&both[1]).all(|(a, b)| a.to_bits() == b.to_bits()));
    Ok(())
}

#[test]
fn nonsense_is_refused() {
    let water = parameters(1.0, 4, 0.01, 1.0);
    let refused = |water: &ReservoirParameters, motion: DMatrix<f64>| {
        pressure_of_record(water, &motion, THREADS).unwrap_err()
    };
    for shape in [(6, 10), (7, 0), (8, 10)] {
        let error = refused(&water, DMatrix::zeros(shape.0, shape.1));
        assert!(matches!(error, ReservoirError::RecordShape { expected: 7, .. }), "{error}");
    }
    let mut motion = DMatrix::zeros(7, 10);
    motion[(2, 5)] = f64::NAN;
    let error = refused(&water, motion.clone());
    assert!(matches!(error, ReservoirError::NonFiniteRecord { row: 2, instant: 5, .. }), "{error}");
    motion[(2, 5)] = 1e308;
    let error = refused(&water, motion.clone());
    assert!(matches!(error, ReservoirError::NonFinitePressure { .. }), "{error}");
    motion[(2, 5)] = 1.0;
    let waves = ReservoirParameters { fidelity: Fidelity::Incompressible, surface_waves: true, ..water };
    assert!(matches!(refused(&waves, motion), ReservoirError::GravityWaves { .. }));
    let far = ReservoirParameters { far_end_distance: -1.0, ..ReservoirParameters::before(face()) };
    assert!(matches!(refused(&far, DMatrix::zeros(7, 10)), ReservoirError::NotPositive { .. }));
}

fn face() -> WetFace {
    WetFace::straight([0.0, DEPTH], 4).unwrap()
}
