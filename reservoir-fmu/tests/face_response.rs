//! The response of a vertical face at real frequencies against the closed forms, for different numbers of elements per wavelength.

use crate::rectangular;

use cofferdam_reservoir::analytical::fenves_chopra_1984;
use cofferdam_reservoir::{Complex64, ElementOrder, ReservoirError, ReservoirParameters, frequency_response};
use cofferdam_unit::WetFace;
use rectangular::{DEPTH, SOUND_SPEED, THREADS, difference, of_uniform_motion, projected};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

fn parameters(alpha: f64, elements: usize, element_order: ElementOrder) -> ReservoirParameters {
    ReservoirParameters { element_order, ..rectangular::parameters(alpha, elements, 0.0025, 1.0) }
}

/// Relative L² difference from the closed form, both linear along the panels, for a face in uniform motion at s = iω,
/// Ω = ω/ω₁.
fn error(parameters: &ReservoirParameters, ratio: f64) -> Result<f64, ReservoirError> {
    let s = Complex64::new(0.0, ratio * CUT_OFF);
    let k = frequency_response(parameters, &[s], THREADS)?.remove(0);
    let exact = projected(&parameters.wet_face, |elevations| {
        let alpha = parameters.wave_reflection_coefficient;
        fenves_chopra_1984::pressures(s, DEPTH, SOUND_SPEED, alpha, elevations)
    });
    Ok(difference(&parameters.wet_face, &of_uniform_motion(&k, s), &exact))
}

/// Ω from 0.01 to 7, except within 0.01 of a cut-off frequency.
const RATIOS: [f64; 24] = [
    0.01, 0.3, 0.6, 0.9, 0.99, 1.01, 1.2, 1.6, 2.0, 2.5, 2.9, 2.99, 3.01, 3.3, 3.7, 4.0, 4.5, 4.99, 5.01,
    5.5, 6.0, 6.5, 6.9, 6.99,
];

/// 0.3 % of the profile at six elements per wavelength, 0.1 % at ten, at least eight per depth. Within 0.15 of a cut-off
/// frequency of a rigid bed the response depends strongly on κ² = λ² − ω²/c²: a relative error ε of the waves' speed in the meshed
/// water becomes ε/|Ω/(2m − 1) − 1|, at most 100 ε here.
#[test]
fn linear_elements_by_their_number_a_wavelength() -> Result<(), ReservoirError> {
    for (a_wavelength, most, at_cut_off) in [(6.0, 3e-3, 2e-2), (10.0, 1e-3, 5e-3)] {
        for alpha in [1.0, 0.75, 0.5, 0.0] {
            let mut worst = [(0.0f64, 0.0); 2];
            for ratio in RATIOS {
                let elements = (a_wavelength * ratio / 4.0f64).ceil().max(8.0) as usize;
                let error = error(&parameters(alpha, elements, ElementOrder::Linear), ratio)?;
                let close = usize::from([1.0, 3.0, 5.0, 7.0].iter().any(|m| (ratio - m).abs() < 0.15));
                worst[close] = if error > worst[close].0 { (error, ratio) } else { worst[close] };
            }
            let [(error, ratio), (close, near)] = worst;
            println!(
                "α = {alpha}, {a_wavelength} linear elements a wavelength: at most {error:.1e}, at Ω = {ratio}; beside the \
                 cut-offs {close:.1e}, at {near}"
            );
            assert!(error <= most && close <= if alpha == 1.0 { at_cut_off } else { 1.1 * most });
        }
    }
    Ok(())
}

/// 0.9 %: one value per element leaves an error of ℓ²ω²/c²/24 of a wave, 0.25 % at Ω = 2.5, and more near the surface.
/// 1.1 % with as many panels as elements: a saw tooth of velocities then has a zero mean on every element, and the pressure
/// has no part that does work on it.
#[test]
fn sixteen_constant_elements() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.75, 0.5, 0.0] {
        for (panels, most) in [(8, 9e-3), (16, 1.1e-2)] {
            let mut worst = (0.0f64, 0.0);
            for ratio in RATIOS.into_iter().filter(|ratio| *ratio <= 2.5) {
                let water = ReservoirParameters {
                    element_size: DEPTH / 16.0,
                    ..parameters(alpha, panels, ElementOrder::Constant)
                };
                let error = error(&water, ratio)?;
                worst = if error > worst.0 { (error, ratio) } else { worst };
            }
            let (error, ratio) = worst;
            println!(
                "α = {alpha}, 16 constant elements, {panels} panels: at most {error:.2e}, at Ω = {ratio}"
            );
            assert!(error <= most);
        }
    }
    Ok(())
}

/// Eight panels in all cases, so that only the elements change; the series is accurate to 1e-5.
#[test]
fn orders_of_both_elements() -> Result<(), ReservoirError> {
    let face = WetFace::straight([0.0, DEPTH], 8).unwrap();
    for (order, least) in [(ElementOrder::Linear, 1.9), (ElementOrder::Constant, 0.9)] {
        for alpha in [1.0, 0.5] {
            for ratio in [0.5, 1.5, 2.5] {
                let errors = [4, 8, 16].map(|elements| {
                    let parameters = parameters(alpha, elements, order);
                    error(&ReservoirParameters { wet_face: face.clone(), ..parameters }, ratio)
                });
                let errors = errors.into_iter().collect::<Result<Vec<_>, _>>()?;
                let rate = (errors[0] / errors[2]).log2() / 2.0;
                println!(
                    "{order:?}, α = {alpha}, Ω = {ratio}: {errors:.6?} with 4, 8, 16 elements, order {rate:.2}"
                );
                assert!(rate > least);
            }
        }
    }
    Ok(())
}
