//! Finite element water: accuracy in space and time, energy, gravity waves, vertical ground.

use crate::rectangular;

use cofferdam_reservoir::analytical::{chopra_1967, fenves_chopra_1984};
use cofferdam_reservoir::{
    Complex64, FarEnd, FiniteElements, ReservoirError, ReservoirParameters, frequency_response,
};
use cofferdam_unit::WetFace;
use nalgebra::{DMatrix, DVector};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, consistent_mass, relative};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

fn parameters(panels: usize, elements: usize, distance: f64) -> ReservoirParameters {
    ReservoirParameters {
        element_size: DEPTH / elements as f64,
        far_end_distance: distance * DEPTH,
        ..rectangular::parameters(1.0, panels, 0.0025, 1.0)
    }
}

fn projected_at(face: &WetFace, field: impl Fn(f64) -> Complex64) -> DVector<Complex64> {
    DVector::from_vec(rectangular::projected(face, |at| at.iter().copied().map(field).collect()))
}

/// Pressure divided by ρa at the points for a uniform acceleration towards the water.
fn uniform(water: &FiniteElements, s: Complex64) -> Result<DVector<Complex64>, ReservoirError> {
    let k = water.symbol(s)?;
    Ok(DVector::from_fn(k.nrows(), |i, _| -k.row(i).columns(0, k.nrows()).sum() / (s * DENSITY)))
}

/// Below the cut-off frequency, the end at 4h: the first mode is reflected with e^{−8κ₁h}, κ₁h = (π/2)√(1 − Ω²). Triangles
/// are small at the corners, because of the one at the surface (see the orders below).
#[test]
fn frequency_response_below_the_cut_off() -> Result<(), ReservoirError> {
    let parameters =
        ReservoirParameters { corner_element_size: Some(DEPTH / 2048.0), ..parameters(32, 16, 4.0) };
    let water = FiniteElements::new(&parameters)?;
    for ratio in [0.01, 0.3, 0.6, 0.8] {
        let s = Complex64::new(1e-9, ratio) * CUT_OFF;
        let exact = projected_at(&parameters.wet_face, |y| chopra_1967::pressure(s, DEPTH, SOUND_SPEED, y));
        let error = relative(&uniform(&water, s)?, &exact);
        let reflected = (-4.0 * PI * (1.0 - ratio * ratio).sqrt()).exp();
        println!(
            "α = 1, ω = {ratio} ω₁, h/16, L = 4h: relative L2 error {error:.2e}, of the end {reflected:.1e}"
        );
        // The error of the end, plus that of h/16 where the end has no effect.
        assert!(error < 1e-4 + 2.0 * reflected / (1.0 - ratio));
    }
    Ok(())
}

/// At an s with so much damping that the end has no effect. One mode of the depth: third order in L2, that of quadratic
/// elements. Uniform motion: where face and surface meet, p falls like r ln r, which reduces the order on the face to 1.5.
/// Small triangles there cannot raise the order, since they grow in proportion to r, but remove at least nine tenths of
/// the error.
#[test]
fn orders_in_the_element_size() -> Result<(), ReservoirError> {
    let s = Complex64::new(1.0, 0.5) * CUT_OFF;
    let lambda = 3.0 * PI / (2.0 * DEPTH);
    let kappa = (lambda * lambda + (s / SOUND_SPEED).powi(2)).sqrt();
    let panels = 64;
    let face = parameters(panels, 2, 4.0).wet_face;
    let velocity: Vec<f64> = face.points().iter().map(|p| (lambda * p[1]).cos()).collect();
    // The mode's share in its own linear interpolation; the next mode in it, the 126th, is 1e-4 of that in velocity
    // and 2e-6 in pressure.
    let half = lambda * DEPTH / panels as f64 / 2.0;
    let share = (half.sin() / half).powi(2);
    let exact_mode = projected_at(&face, |y| share * (lambda * y).cos() / kappa);
    let exact_uniform = projected_at(&face, |y| chopra_1967::pressure(s, DEPTH, SOUND_SPEED, y));
    let mut errors: Vec<[f64; 3]> = Vec::new();
    for elements in [2, 4, 8, 16] {
        let even = parameters(panels, elements, 4.0);
        let graded =
            ReservoirParameters { corner_element_size: Some(even.element_size / 100.0), ..even.clone() };
        let water = FiniteElements::new(&even)?;
        let k = water.symbol(s)?;
        let mode = DVector::from_fn(face.len(), |i, _| {
            -(0..face.len()).map(|j| k[(i, j)] * velocity[j]).sum::<Complex64>() / (s * DENSITY)
        });
        let graded = uniform(&FiniteElements::new(&graded)?, s)?;
        let even = uniform(&water, s)?;
        let error = [
            relative(&mode, &exact_mode),
            relative(&even, &exact_uniform),
            relative(&graded, &exact_uniform),
        ];
        println!(
            "h/{elements}: mode {:.2e}, uniform {:.2e}, with small corners {:.2e}",
            error[0], error[1], error[2]
        );
        errors.push(error);
    }
    let order = |which: usize| (errors[0][which] / errors[3][which]).log2() / 3.0;
    println!("order: mode {:.2}, uniform {:.2}, with small corners {:.2}", order(0), order(1), order(2));
    assert!(order(0) > 2.8 && order(1) > 1.4 && errors[3][2] < 0.1 * errors[3][1]);
    Ok(())
}

/// A battered face, and a bed that rises towards the dam, against the boundary elements at damped s, where the end
/// has no effect. The slope is a bed for the finite elements, and the lowest piece of a face at rest for the boundary
/// elements, whose heel is then its foot. Points below 0.9 h: the boundary elements give values at points, the finite
/// elements means, which differ by p″/12 times the square of the panels' length, and p″ is infinite at the surface.
/// 0.1 %: h/24.
#[test]
fn against_the_boundary_elements() -> Result<(), ReservoirError> {
    let s = [Complex64::new(0.5, 0.3), Complex64::new(0.7, 2.2)].map(|z| z * CUT_OFF);
    let compare =
        |fe: &ReservoirParameters, be: &ReservoirParameters, what: &str| -> Result<(), ReservoirError> {
            let water = FiniteElements::new(fe)?;
            let references = frequency_response(be, &s, THREADS)?;
            let n = fe.wet_face.len();
            let first = be.wet_face.len() - n;
            for (s, reference) in s.iter().zip(references) {
                let found = water.symbol(*s)?;
                for (motion, shape) in [("uniform", 0.0), ("rocking", 1.0)] {
                    let velocity: Vec<f64> =
                        fe.wet_face.points().iter().map(|p| 1.0 - shape + shape * p[1] / DEPTH).collect();
                    let answer = |k: &DMatrix<Complex64>, first: usize| {
                        DVector::from_fn(n * 9 / 10, |i, _| {
                            (0..n).map(|j| k[(first + i, first + j)] * velocity[j]).sum::<Complex64>()
                        })
                    };
                    let error = relative(&answer(&found, 0), &answer(&reference, first));
                    println!("{what}, s = {:.2} ω₁, {motion}: differs by {error:.2e}", s / CUT_OFF);
                    assert!(error < 1e-3);
                }
            }
            Ok(())
        };
    let battered = ReservoirParameters {
        wet_face: WetFace::straight([0.15 * DEPTH, DEPTH], 48).unwrap(),
        corner_element_size: Some(DEPTH / 2048.0),
        ..parameters(48, 24, 4.0)
    };
    let be = ReservoirParameters { far_end_distance: DEPTH / 2.0, ..battered.clone() };
    compare(&battered, &be, "batter 0.15")?;

    let (run, rise, panels) = (0.5 * DEPTH, 0.25 * DEPTH, 40);
    let upper = |i: usize| [0.0, DEPTH * i as f64 / panels as f64];
    let slope = (0..panels / 2).map(|i| [run, rise].map(|c| c * i as f64 / (panels / 2) as f64));
    // The top of the slope and the foot of the face coincide, so that the velocity can jump.
    let shifted =
        slope.chain([[run, rise]]).chain((0..=panels).map(|i| [run + upper(i)[0], rise + upper(i)[1]]));
    let fe = ReservoirParameters {
        bed: vec![[-run, -rise]],
        corner_element_size: Some(DEPTH / 2048.0),
        ..parameters(panels, 24, 4.0)
    };
    let be = ReservoirParameters {
        wet_face: WetFace::new(shifted.collect()).unwrap(),
        far_end_distance: DEPTH / 2.0,
        ..parameters(panels, 24, 4.0)
    };
    compare(&fe, &be, "rising bed")?;

    // Motion of the ground along x moves only the slope along its normal.
    let water = FiniteElements::new(&fe)?;
    let along = rise / run.hypot(rise);
    for (s, reference) in s.iter().zip(frequency_response(&be, &s, THREADS)?) {
        let found = water.symbol(*s)?.column(panels + 1).rows(0, panels * 9 / 10).into_owned();
        let first = panels / 2 + 1;
        let reference = DVector::from_fn(found.len(), |i, _| {
            along * (0..first).map(|j| reference[(first + i, j)]).sum::<Complex64>()
        });
        let error = relative(&found, &reference);
        println!("rising bed, s = {:.2} ω₁, ground along x: differs by {error:.2e}", s / CUT_OFF);
        assert!(error < 1e-3);
    }
    Ok(())
}

/// An absorbing bed, at damped s, where the end at 4h has no effect, against Fenves and Chopra (1984). 5e-4: h/16, and
/// a corner field at the heel.
#[test]
fn absorbing_bed() -> Result<(), ReservoirError> {
    for alpha in [0.9, 0.5, 0.0] {
        let parameters = ReservoirParameters {
            wave_reflection_coefficient: alpha,
            corner_element_size: Some(DEPTH / 2048.0),
            ..parameters(32, 16, 4.0)
        };
        let water = FiniteElements::new(&parameters)?;
        for ratio in [0.3, 1.5, 2.5] {
            let s = Complex64::new(0.5, ratio) * CUT_OFF;
            let exact = DVector::from_vec(rectangular::projected(&parameters.wet_face, |elevations| {
                fenves_chopra_1984::pressures(s, DEPTH, SOUND_SPEED, alpha, elevations)
            }));
            let error = relative(&uniform(&water, s)?, &exact);
            println!("α = {alpha}, s = {:.2} ω₁: relative L2 error {error:.2e}", s / CUT_OFF);
            assert!(error < 5e-4);
        }
    }
    Ok(())
}

/// Pressures at the steps' ends from the velocities there, starting from rest.
fn run(water: &FiniteElements, velocities: impl Iterator<Item = Vec<f64>>) -> Vec<Vec<f64>> {
    let (mut state, mut next) = (vec![0.0; water.state_len()], vec![0.0; water.state_len()]);
    velocities
        .map(|inputs| {
            let pressure = water.step(&state, &inputs, &mut next);
            std::mem::swap(&mut state, &mut next);
            pressure
        })
        .collect()
}

/// Base pressure for a ramp that is then held, against the closed form, with halved steps, until the first wave returns
/// from the far end at 4h; 64 panels, so that the mean over the last panel is the base to 1e-4.
#[test]
fn ramp_and_hold() -> Result<(), ReservoirError> {
    use rectangular::ramp_and_hold::{base_pressure as exact, velocity};
    let mut errors = Vec::new();
    for step in [0.01, 0.005, 0.0025] {
        let parameters = ReservoirParameters { communication_step: step, ..parameters(64, 16, 4.0) };
        let water = FiniteElements::new(&parameters)?;
        let steps = (8.0 * DEPTH / SOUND_SPEED / step) as usize;
        let inputs = (1..=steps).map(|n| {
            let mut inputs = vec![-velocity(n as f64 * step); water.inputs()];
            inputs[65..].fill(0.0);
            inputs
        });
        let (mut error, mut peak): (f64, f64) = (0.0, 0.0);
        for (n, p) in run(&water, inputs).iter().enumerate() {
            let exact = exact((n + 1) as f64 * step);
            error = error.max((p[0] - exact).abs());
            peak = peak.max(exact.abs());
        }
        println!(
            "ramp and hold, L = 4h, H = {step} s: largest error {:.2e} of the peak in 8h/c = 1 s",
            error / peak
        );
        errors.push(error / peak);
    }
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("ramp and hold: order {order:.2} in H");
    // Kinks of the acceleration reduce the second order of smooth motion.
    assert!(errors[2] < 1e-3 && order > 1.5);
    Ok(())
}

/// The response of the steps to a velocity ζ⁻ⁿ, after the initial transient, is the symbol at 2(1 − ζ)/(H(1 + ζ)): another
/// path through assembly, factors and the column. With ground motion along y and an absorbing bed.
#[test]
fn steps_have_the_symbol() -> Result<(), ReservoirError> {
    let face =
        WetFace::new(vec![[0.0, 0.0], [2.0, 60.0], [2.0, 60.0], [20.0, 120.0], [20.0, DEPTH]]).unwrap();
    for (surface_waves, alpha) in [(false, 0.5), (true, 0.5)] {
        let parameters = ReservoirParameters {
            wet_face: face.clone(),
            bed: vec![[-40.0, -20.0]],
            surface_waves,
            wave_reflection_coefficient: alpha,
            communication_step: 0.01,
            ..parameters(4, 6, 0.5)
        };
        let water = FiniteElements::new(&parameters)?;
        // The velocity grows, so that the initial transient becomes negligible.
        let zeta = Complex64::from_polar(0.9, -0.3);
        let s = 2.0 * (1.0 - zeta) / (0.01 * (1.0 + zeta));
        let symbol = water.symbol(s)?;
        for input in 0..water.inputs() {
            let steps = 240;
            let part = |part: fn(Complex64) -> f64| {
                let inputs = (1..=steps).map(|n| {
                    let mut inputs = vec![0.0; 7];
                    inputs[input] = part(zeta.powi(steps - n));
                    inputs
                });
                run(&water, inputs).pop().unwrap()
            };
            let (re, im) = (part(|z| z.re), part(|z| z.im));
            let found = DVector::from_fn(5, |i, _| Complex64::new(re[i], im[i]));
            let error = relative(&found, &symbol.column(input).into_owned());
            println!("steps against symbol, waves {surface_waves}, input {input}: {error:.1e}");
            // The initial transient is 0.9²⁴⁰ = 1e-11.
            assert!(error < 1e-9);
        }
    }
    Ok(())
}

/// Before a vertical face the response to vertical motion of the ground is that of the column, on an absorbing bed at every frequency:
/// base `p = ρ a tan(kh)/(k (1 + iqc tan kh))`, k = ω/c, with s = iω plus a small damping.
#[test]
fn vertical_ground_motion() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.6, 0.0] {
        let parameters =
            ReservoirParameters { wave_reflection_coefficient: alpha, ..parameters(32, 16, 1.0) };
        let water = FiniteElements::new(&parameters)?;
        let admittance = (1.0 - alpha) / (1.0 + alpha);
        for ratio in [0.02, 0.7, 1.6, 2.4] {
            let s = Complex64::new(1e-3, ratio) * CUT_OFF;
            let k = s / SOUND_SPEED;
            let exact = projected_at(&parameters.wet_face, |y| {
                (k * (DEPTH - y)).sinh() / (k * ((k * DEPTH).cosh() + admittance * (k * DEPTH).sinh()))
            });
            let symbol = water.symbol(s)?;
            let found = symbol.column(water.inputs() - 1) / (s * DENSITY);
            let error = relative(&found.into_owned(), &exact);
            println!("vertical ground, α = {alpha}, ω = {ratio} ω₁: relative L2 error {error:.2e}");
            // The error of h/16 for a mode of about this wavelength.
            assert!(error < 2e-4);
        }
    }
    Ok(())
}

/// Pseudo-random numbers in [−1, 1): a linear congruence.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Random velocities, rough and smooth: the energy balance of every step is exact to rounding, in the open water and in
/// the tank, which loses no energy. The work of pressure and velocity that are linear within a step is never below
/// the mid-step work, which is never below the stored energy.
#[test]
fn energy_is_balanced_and_never_given() -> Result<(), ReservoirError> {
    let face = || {
        WetFace::new(vec![[0.0, 0.0], [0.0, 20.0], [10.0, 60.0], [10.0, 60.0], [-5.0, 100.0], [0.0, 180.0]])
            .unwrap()
    };
    for (end, alpha, surface_waves, step) in [
        (FarEnd::Sommerfeld, 0.4, false, 0.0025),
        (FarEnd::Sommerfeld, 1.0, true, 0.02),
        (FarEnd::Rigid, 1.0, false, 0.0025),
        (FarEnd::Rigid, 1.0, true, 0.1),
    ] {
        let parameters = ReservoirParameters {
            wet_face: face(),
            bed: vec![[-30.0, -15.0], [-50.0, 5.0]],
            wave_reflection_coefficient: alpha,
            surface_waves,
            communication_step: step,
            ..parameters(5, 8, 0.5)
        };
        let water = FiniteElements::with_far_end(&parameters, end)?;
        let mass = consistent_mass(&parameters.wet_face);
        let n = parameters.wet_face.len();
        let (mut worst_balance, mut least_gap, mut total): (f64, f64, f64) = (0.0, f64::INFINITY, 0.0);
        let mut seed = 7;
        for memory in [0.0, 0.8, 0.98, 0.999] {
            let (mut state, mut next) = (vec![0.0; water.state_len()], vec![0.0; water.state_len()]);
            let (mut v0, mut p0) = (DVector::zeros(n), DVector::<f64>::zeros(n));
            let (mut linear, mut middle, mut lost, mut scale) = (0.0, 0.0, 0.0, 0.0);
            for _ in 0..400 {
                let v1 = v0.map(|v: f64| memory * v + (1.0 - memory) * noise(&mut seed));
                let mut inputs: Vec<f64> = v1.iter().copied().collect();
                inputs.extend([0.0, 0.0]);
                let p1 = DVector::from_vec(water.step(&state, &inputs, &mut next));
                let work = |v: &DVector<f64>, p: &DVector<f64>| -step * v.dot(&(&mass * p));
                let in_step = work(&(0.5 * (&v0 + &v1)), &(0.5 * (&p0 + &p1)));
                middle += in_step;
                linear += in_step + work(&(&v1 - &v0), &(&p1 - &p0)) / 12.0;
                lost += water.loss(&state, &next);
                scale += in_step.abs();
                let held = water.energy(&next);
                // The balance is summed from rest, so the errors of all steps add up.
                worst_balance = worst_balance.max((middle - held - lost).abs() / scale);
                least_gap = least_gap.min((linear - middle) / scale);
                assert!(held >= 0.0 && linear >= middle - 1e-12 * scale, "{linear} {middle} {scale}");
                total = f64::max(total, held);
                std::mem::swap(&mut state, &mut next);
                (v0, p0) = (v1, p1);
            }
            assert!(end == FarEnd::Sommerfeld || lost == 0.0);
        }
        println!(
            "{end:?}, α = {alpha}, waves {surface_waves}, H = {step} s: balance {worst_balance:.1e} of the work done, \
             work of the linear fields above mid-step work by {least_gap:.1e} at least; up to {total:.2e} J/m"
        );
        assert!(worst_balance < 1e-11);
    }
    Ok(())
}

/// A closed tank with gravity waves: the face moves once, and each mode of the length L oscillates at ω² = g k tanh(kh),
/// k = mπ/L. The frequencies are the poles of the symbol, as least squares would need long runs: the pressure on the face
/// is computed near each pole, which follows by the secant method on the inverse.
#[test]
fn sloshing_frequencies() -> Result<(), ReservoirError> {
    // Nearly incompressible, so that the formula without compression is right to 1e-6.
    let depth = 10.0;
    let length = 20.0;
    let parameters = ReservoirParameters {
        sound_speed: 1e5,
        surface_waves: true,
        element_size: 1.25,
        far_end_distance: length,
        ..ReservoirParameters::before(WetFace::straight([0.0, depth], 16).unwrap())
    };
    let water = FiniteElements::with_far_end(&parameters, FarEnd::Rigid)?;
    for mode in 1..=3 {
        let k = f64::from(mode) * PI / length;
        let exact = (parameters.gravity * k * (k * depth).tanh()).sqrt();
        // 1/p is zero at the pole; the small damping δ is removed.
        let inverse = |omega: f64| -> Result<f64, ReservoirError> {
            let symbol = water.symbol(Complex64::new(1e-9, omega))?;
            let p: Complex64 = symbol.row(15).columns(0, 17).sum();
            Ok(1.0 / p.im)
        };
        let (mut a, mut b) = (exact * 0.999, exact * 1.001);
        let (mut fa, mut fb) = (inverse(a)?, inverse(b)?);
        for _ in 0..4 {
            let c = b - fb * (b - a) / (fb - fa);
            (a, fa) = (b, fb);
            (b, fb) = (c, inverse(c)?);
            if (fb - fa).abs() <= 1e-9 * fa.abs() || (b - a).abs() < 1e-9 * b {
                break;
            }
        }
        println!(
            "sloshing mode {mode}: ω = {b:.6} rad/s, formula {exact:.6}, off by {:.1e}",
            b / exact - 1.0
        );
        assert!((b / exact - 1.0).abs() < 2e-4);
    }
    Ok(())
}

/// A repeated step gives equal bits, and another step length gives the same as water made with it.
#[test]
fn repetition_and_other_step_lengths() -> Result<(), ReservoirError> {
    let parameters = parameters(12, 8, 1.0);
    let mut water = FiniteElements::new(&parameters)?;
    let mut seed = 3;
    let mut inputs = || -> Vec<f64> { (0..15).map(|_| noise(&mut seed)).collect() };
    let (mut state, mut next) = (vec![0.0; water.state_len()], vec![0.0; water.state_len()]);
    for _ in 0..5 {
        let prepared = water.prepare(&state);
        let (first, other) = (inputs(), inputs());
        let rejected = water.pressure(&prepared, &other);
        let repeated = water.pressure(&prepared, &first);
        assert!(water.step(&state, &first, &mut next) == repeated);
        // ∂p/∂(inputs) is exact.
        let change = water.instantaneous() * DVector::from_fn(15, |i, _| first[i] - other[i]);
        let largest = change.amax();
        for i in 0..13 {
            assert!((repeated[i] - rejected[i] - change[i]).abs() < 1e-12 * largest);
        }
        state.copy_from_slice(&next);
    }
    water.set_communication_step(0.001)?;
    let made = FiniteElements::new(&ReservoirParameters { communication_step: 0.001, ..parameters })?;
    let inputs = inputs();
    let mut again = next.clone();
    assert!(
        water.step(&state, &inputs, &mut next) == made.step(&state, &inputs, &mut again) && next == again
    );
    assert!(water.set_communication_step(0.0).is_err());
    Ok(())
}

#[test]
fn bad_parameters_are_refused() {
    let given = || parameters(8, 8, 1.0);
    let refused =
        |parameters: ReservoirParameters| FiniteElements::new(&parameters).err().map(|e| e.to_string());
    let message = refused(ReservoirParameters { bed: vec![[-10.0, 200.0]], ..given() }).unwrap();
    assert!(message.contains("(-10, 200)"), "{message}");
    let message = refused(ReservoirParameters { bed: vec![[50.0, 20.0]], ..given() }).unwrap();
    assert!(message.contains("(50, 20)"), "{message}");
    let message =
        refused(ReservoirParameters { element_size: 0.3, far_end_distance: 1000.0, ..given() }).unwrap();
    assert!(message.contains("finite elements") || message.contains("boundary elements"), "{message}");
    let message = refused(ReservoirParameters { bed_element_size: Some(1e-6), ..given() }).unwrap();
    assert!(message.contains("elements"), "{message}");
    // Elements at the corners that are smaller than the rounding of the coordinates.
    assert!(refused(ReservoirParameters { corner_element_size: Some(1e-18), ..given() }).is_some());
    for size in [0.0, -1.0, f64::NAN] {
        assert!(refused(ReservoirParameters { corner_element_size: Some(size), ..given() }).is_some());
        assert!(refused(ReservoirParameters { bed_element_size: Some(size), ..given() }).is_some());
    }
    let water = FiniteElements::new(&given()).unwrap();
    assert!(matches!(water.symbol(Complex64::new(-1.0, 3.0)), Err(ReservoirError::Frequency { .. })));
}
