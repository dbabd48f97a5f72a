//! Rigid flat bed, vertical face, against Chopra (1967) and Westergaard's static limit.

use crate::rectangular;

use cofferdam_reservoir::analytical::chopra_1967;
use cofferdam_reservoir::{Complex64, ReservoirError, frequency_response};
use rectangular::{
    DEPTH, SOUND_SPEED, THREADS, base_pressures, difference, of_uniform_motion, parameters, projected,
};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

/// Pressures divided by ρa at the points for a uniform acceleration towards the water.
fn response(
    parameters: &cofferdam_reservoir::ReservoirParameters,
    s: Complex64,
) -> Result<Vec<Complex64>, ReservoirError> {
    let k = frequency_response(parameters, &[s], THREADS)?.remove(0);
    Ok(of_uniform_motion(&k, s))
}

/// The closed form, projected onto functions that are linear along the panels, m.
fn exact(parameters: &cofferdam_reservoir::ReservoirParameters, s: Complex64) -> Vec<Complex64> {
    projected(&parameters.wet_face, |elevations| {
        elevations.iter().map(|&y| chopra_1967::pressure(s, DEPTH, SOUND_SPEED, y)).collect()
    })
}

/// 0.1 %: two orders above the discretisation error of 16 linear elements at s → 0.
#[test]
fn static_pressure_and_force() -> Result<(), ReservoirError> {
    let parameters = parameters(1.0, 16, 0.0025, 1.0);
    let s = Complex64::new(1e-3 * CUT_OFF, 0.0);
    let p: Vec<f64> = response(&parameters, s)?.iter().map(|p| p.re).collect();
    let force: f64 = parameters.wet_face.nodal_forces(&p).iter().map(|f| f[0]).sum();
    let base_error = p[0] / exact(&parameters, s)[0].re - 1.0;
    let force_error = force / (DEPTH * DEPTH) / chopra_1967::STATIC_FORCE - 1.0;
    println!("static: base pressure off by {base_error:.2e}, force by {force_error:.2e} at 16 panels");
    assert!(base_error.abs() < 1e-3 && force_error.abs() < 1e-3);

    let fine = rectangular::parameters(1.0, 64, 0.0025, 1.0);
    let p: Vec<f64> = response(&fine, s)?.iter().map(|p| p.re).collect();
    let force: f64 = fine.wet_face.nodal_forces(&p).iter().map(|f| f[0]).sum();
    let error = force / (DEPTH * DEPTH) / chopra_1967::STATIC_FORCE - 1.0;
    println!("static: force off the closed form by {error:.2e} at 64 panels");
    assert!(error.abs() < 1e-3);
    Ok(())
}

/// 0.5 % of the peak over 2 s, sixteen surface echoes, and over the 10 000 steps of 25 s: the
/// errors of the weights, amplified like R⁻ⁿ, remain invisible.
#[test]
fn ramp_and_hold() -> Result<(), ReservoirError> {
    use rectangular::ramp_and_hold::{base_pressure as exact, velocity};
    let pressures = base_pressures(parameters(1.0, 8, 0.0025, 25.0), velocity)?;
    let peak = pressures.iter().fold(0.0, |m: f64, &(t, _)| m.max(exact(t).abs()));
    let largest =
        |range: &[(f64, f64)]| range.iter().fold(0.0, |m: f64, &(t, p)| m.max((p - exact(t)).abs())) / peak;
    let [early, late] = [largest(&pressures[..800]), largest(&pressures[9000..])];
    println!("ramp and hold, H = 2.5 ms: error {early:.2e} of the peak in 2 s, {late:.2e} after 22.5 s");
    assert!(largest(&pressures) < 5e-3);
    Ok(())
}

/// 0.1 % of the profile's norm: at least nine linear elements per wavelength.
#[test]
fn frequency_response_of_the_modes() -> Result<(), ReservoirError> {
    let parameters = parameters(1.0, 16, 0.0025, 1.0);
    for ratio in [0.3, 0.7, 1.5, 2.5, 3.6] {
        let s = Complex64::new(0.02, ratio) * CUT_OFF;
        let p = response(&parameters, s)?;
        let error = difference(&parameters.wet_face, &p, &exact(&parameters, s));
        println!("α = 1, ω = {ratio} ω₁: relative L2 error {error:.2e}");
        assert!(error < 1e-3);
    }
    Ok(())
}

/// The radiation condition is exact for every mode, so its distance does not matter.
#[test]
fn far_end_may_stand_anywhere() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.5] {
        for ratio in [0.7, 1.5, 2.5] {
            let s = Complex64::new(0.02, ratio) * CUT_OFF;
            let base = |distance: f64| {
                let parameters = cofferdam_reservoir::ReservoirParameters {
                    far_end_distance: distance,
                    ..parameters(alpha, 16, 0.0025, 1.0)
                };
                response(&parameters, s).map(|p| p[0])
            };
            let [near, middle, far] = [base(DEPTH / 4.0)?, base(DEPTH / 2.0)?, base(DEPTH)?];
            let spread = (near - middle).norm().max((far - middle).norm()) / middle.norm();
            println!("α = {alpha}, ω = {ratio} ω₁: far end at h/4, h/2, h differ by {spread:.2e}");
            assert!(spread < 1e-3);
        }
    }
    Ok(())
}
