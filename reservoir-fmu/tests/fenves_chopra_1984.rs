//! Absorbing flat bed, vertical face, against Fenves and Chopra (1984) and the corner field.

use crate::rectangular;

use cofferdam_reservoir::analytical::fenves_chopra_1984;
use cofferdam_reservoir::{Complex64, ReservoirError, frequency_response};
use rectangular::{
    DENSITY, DEPTH, SOUND_SPEED, THREADS, base_pressures, difference, of_uniform_motion, parameters,
    projected,
};
use std::f64::consts::PI;

/// 1 % between three elements' travel time and the first echo, whose front the Radau method smears
/// over four steps. Elements much longer than cH cause oscillations at an absorbing bed; 32 per depth are 1.6 cH long.
#[test]
fn before_the_first_echo() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.5, 0.0] {
        let (elements, h) = (32, 0.0025);
        let pressures =
            base_pressures(parameters(alpha, elements, h, 0.13), |t| if t > 0.0 { 1.0 } else { 0.0 })?;
        let exact = fenves_chopra_1984::early_base_pressure(alpha) * DENSITY * SOUND_SPEED;
        let window = 3.0 * DEPTH / elements as f64 / SOUND_SPEED..DEPTH / SOUND_SPEED - 4.0 * h;
        let error = pressures
            .iter()
            .filter(|(t, _)| window.contains(t))
            .fold(0.0, |m: f64, (_, p)| m.max((p / exact - 1.0).abs()));
        println!("α = {alpha}: base pressure before the first echo off by {error:.2e}");
        assert!(error < 1e-2);
    }
    Ok(())
}

/// 0.1 % of the profile's norm: at least nine linear elements per wavelength, corner field at the heel.
#[test]
fn frequency_response_of_the_modes() -> Result<(), ReservoirError> {
    let cut_off = PI * SOUND_SPEED / (2.0 * DEPTH);
    for alpha in [0.9, 0.5, 0.0] {
        let parameters = parameters(alpha, 16, 0.0025, 1.0);
        for ratio in [0.3, 0.7, 1.5, 2.5, 3.6] {
            let s = Complex64::new(0.02, ratio) * cut_off;
            let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
            let exact = projected(&parameters.wet_face, |elevations| {
                fenves_chopra_1984::pressures(s, DEPTH, SOUND_SPEED, alpha, elevations)
            });
            let error = difference(&parameters.wet_face, &of_uniform_motion(&k, s), &exact);
            println!("α = {alpha}, ω = {ratio} ω₁: relative L2 error {error:.2e}");
            assert!(error < 1e-3);
        }
    }
    Ok(())
}
