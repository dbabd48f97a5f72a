//! Gravity waves: dispersion and pressure against the modal solution.

use crate::rectangular;

use cofferdam_reservoir::analytical::bustamante_1963;
use cofferdam_reservoir::{
    Complex64, Fidelity, ReservoirError, ReservoirParameters, added_mass, field_response, frequency_response,
};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, difference, of_uniform_motion, projected};

const GRAVITY: f64 = 9.81;

fn parameters(elements: usize) -> ReservoirParameters {
    ReservoirParameters { surface_waves: true, ..rectangular::parameters(1.0, elements, 0.0025, 1.0) }
}

/// 0.5 % from 0.05 rad/s, where the wave is 29 depths long, to sound at Ω = 1.5. Waves that decay within 0.4 elements
/// or less are not resolved: at most 1 %, and less the shorter they are, because then the surface is p = 0.
#[test]
fn pressure_of_compressible_and_incompressible_water() -> Result<(), ReservoirError> {
    for (fidelity, sound_speed) in
        [(Fidelity::Compressible, SOUND_SPEED), (Fidelity::Incompressible, f64::INFINITY)]
    {
        for elements in [8, 16, 32] {
            let parameters = ReservoirParameters { fidelity, ..parameters(elements) };
            let size = DEPTH / elements as f64;
            for omega in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 6.0, 12.0, 19.0] {
                let s = Complex64::new(0.0, omega);
                let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
                let exact = projected(&parameters.wet_face, |elevations| {
                    bustamante_1963::pressures(omega, DEPTH, sound_speed, GRAVITY, elevations)
                });
                let error = difference(&parameters.wet_face, &of_uniform_motion(&k, s), &exact);
                let decay = GRAVITY / (omega * omega);
                println!(
                    "{fidelity:?}, {elements} elements, ω = {omega} rad/s, 1/k = {:.2} elements: {error:.1e}",
                    decay / size
                );
                assert!(error < if decay > 0.4 * size { 5e-3 } else { 1e-2 });
            }
        }
    }
    Ok(())
}

/// The wavenumber from the phase of the pressure between two points under the surface, at least one depth before the face.
#[test]
fn dispersion() -> Result<(), ReservoirError> {
    for omega in [0.05, 0.2, 0.4, 0.7] {
        let far_end_distance = 6.0 * DEPTH;
        let parameters = ReservoirParameters { far_end_distance, ..parameters(8) };
        let at = [-4.0, -4.25].map(|x| [x * DEPTH, 0.7 * DEPTH]);
        let field = field_response(&parameters, Complex64::new(0.0, omega), &at, THREADS)?;
        let points = field.ncols() - 2;
        let [near, far] = [0, 1].map(|row| field.row(row).columns(0, points).sum());
        let found = (near / far).arg() / (0.25 * DEPTH);
        let exact = bustamante_1963::gravity_wave(omega, DEPTH, GRAVITY).hypot(omega / SOUND_SPEED);
        println!(
            "ω = {omega} rad/s: wavenumber {found:.6} against {exact:.6}, off by {:.1e}",
            found / exact - 1.0
        );
        assert!((found / exact - 1.0).abs() < 5e-3);
    }
    Ok(())
}

/// ω → 0: p grows like √(gh)/(iω), down to waves of 10⁴ km; damped, real s too.
#[test]
fn long_waves() -> Result<(), ReservoirError> {
    let parameters = parameters(8);
    for s in [(0.0, 1e-2), (0.0, 1e-4), (0.0, 1e-5), (1e-4, 0.0)] {
        let s = Complex64::new(s.0, s.1);
        let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
        let p = of_uniform_motion(&k, s);
        // With sound: κ = s √(1/gh + 1/c²) of the long wave to the leading order.
        let long = 1.0 / (s * (1.0 / (GRAVITY * DEPTH) + SOUND_SPEED.powi(-2)).sqrt());
        let off = p.iter().map(|p| (p / long - 1.0).norm()).fold(0.0, f64::max);
        println!("s = {s}: pressure over the long wave's, off by {off:.1e}");
        assert!(off < 1e-3 + 40.0 * s.norm());
    }
    Ok(())
}

/// A level bed that rises lifts the water: the pressure per displacement of the ground is ρ g as s → 0.
#[test]
fn vertical_motion_lifts_the_water() -> Result<(), ReservoirError> {
    let parameters = parameters(8);
    let s = Complex64::new(0.0, 0.01);
    let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
    let last = k.column(k.ncols() - 1) * (s / (DENSITY * GRAVITY));
    println!("p/(ρ g u) from {:.6} to {:.6}", last[0], last[last.len() - 1]);
    // 1/(1 + gh/c²), less s²h/g below.
    let exact = 1.0 / (1.0 + GRAVITY * DEPTH / SOUND_SPEED.powi(2));
    assert!(last.iter().all(|p| (p - exact).norm() < 3e-3));
    Ok(())
}

#[test]
fn models_that_know_no_waves_refuse_them() {
    let wrong = |fidelity| ReservoirParameters { fidelity, ..parameters(8) };
    for error in [
        frequency_response(&wrong(Fidelity::Westergaard), &[Complex64::ONE], THREADS).unwrap_err(),
        added_mass(&wrong(Fidelity::Incompressible)).unwrap_err(),
    ] {
        assert!(matches!(error, ReservoirError::GravityWaves { .. }), "{error}");
    }
}
