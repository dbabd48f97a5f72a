//! Extreme parameters and frequencies: a correct result, or an error that gives the reason.

use crate::rectangular;

use cofferdam_reservoir::analytical::{chopra_1967, fenves_chopra_1984};
use cofferdam_reservoir::{
    Complex64, ElementOrder, Fidelity, ReservoirError, ReservoirParameters, added_mass, frequency_response,
};
use cofferdam_unit::WetFace;
use rectangular::{DEPTH, SOUND_SPEED, THREADS, difference, of_uniform_motion, parameters, projected};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

/// Relative error of the pressure profile under uniform motion, against the modes.
fn error(parameters: &ReservoirParameters, s: Complex64) -> Result<f64, ReservoirError> {
    let face = &parameters.wet_face;
    let k = frequency_response(parameters, &[s], THREADS)?.remove(0);
    let alpha = parameters.wave_reflection_coefficient;
    let exact = projected(face, |y| {
        if alpha < 1.0 {
            return fenves_chopra_1984::pressures(s, face.depth(), parameters.sound_speed, alpha, y);
        }
        y.iter().map(|&y| chopra_1967::pressure(s, face.depth(), parameters.sound_speed, y)).collect()
    });
    Ok(difference(face, &of_uniform_motion(&k, s), &exact))
}

#[test]
fn cut_off_frequencies_of_a_rigid_bed_are_refused() -> Result<(), ReservoirError> {
    for mode in [1.0, 3.0, 5.0] {
        for s in [Complex64::new(0.0, mode * CUT_OFF), Complex64::new(0.0, -mode * CUT_OFF)] {
            let error = frequency_response(&parameters(1.0, 8, 0.0025, 1.0), &[s], THREADS).unwrap_err();
            assert!(matches!(error, ReservoirError::CutOff { .. }), "{error}");
            assert!(frequency_response(&parameters(0.99, 8, 0.0025, 1.0), &[s], THREADS).is_ok());
        }
    }
    // Near the cut-off the response is finite, and grows like 1/√(Ω − 1).
    let base = |off: f64| -> Result<f64, ReservoirError> {
        let s = Complex64::new(0.0, (1.0 + off) * CUT_OFF);
        let k = frequency_response(&parameters(1.0, 32, 0.0025, 1.0), &[s], THREADS)?.remove(0);
        Ok(of_uniform_motion(&k, s)[0].norm())
    };
    let ratio = base(1e-3)? / base(4e-3)?;
    println!("base pressure 0.1 % above a cut-off over that at 0.4 %: {ratio:.4}");
    assert!((ratio - 2.0).abs() < 0.02);
    Ok(())
}

/// The conjugate frequency has the conjugate response.
#[test]
fn negative_frequencies_are_conjugate() -> Result<(), ReservoirError> {
    for (alpha, waves) in [(1.0, false), (0.5, false), (0.5, true)] {
        let parameters = ReservoirParameters { surface_waves: waves, ..parameters(alpha, 8, 0.0025, 1.0) };
        let s = [Complex64::new(0.0, 2.3 * CUT_OFF), Complex64::new(0.0, -2.3 * CUT_OFF)];
        let k = frequency_response(&parameters, &s, THREADS)?;
        let off = (&k[0] - k[1].conjugate()).norm() / k[0].norm();
        println!("α = {alpha}, waves {waves}: conjugate to {off:.1e}");
        assert!(off < 1e-13);
    }
    Ok(())
}

/// kh from 1e-4 to 100, six elements per wavelength or 16 per depth; the far end is near, because there are many waves.
#[test]
fn wavenumbers_from_1e_4_to_100_a_depth() -> Result<(), ReservoirError> {
    for kh in [1e-4, 1e-2, 1.0, 10.0, 100.0] {
        for alpha in [1.0, 0.5] {
            let elements = (6.0 * kh / (2.0 * PI)).ceil().max(16.0) as usize;
            let far_end_distance = if kh > 50.0 { DEPTH / 16.0 } else { DEPTH / 2.0 };
            let parameters =
                ReservoirParameters { far_end_distance, ..parameters(alpha, elements, 0.0025, 1.0) };
            let error = error(&parameters, Complex64::new(0.0, kh * SOUND_SPEED / DEPTH))?;
            println!("kh = {kh}, α = {alpha}, {elements} elements: off by {error:.1e}");
            assert!(error < if kh > 50.0 { 3e-2 } else { 3e-3 });
        }
    }
    Ok(())
}

/// The same dimensionless problem at every depth; beds that are long, or far shorter than an element, which costs some per
/// cent near the corners.
#[test]
fn depths_and_lengths() -> Result<(), ReservoirError> {
    for depth in [0.01, 1.0, 1000.0] {
        for length in [1e-3, 0.5, 20.0] {
            let parameters = ReservoirParameters {
                far_end_distance: length * depth,
                bed_element_size: (length > 1.0).then_some(depth / 6.0),
                ..ReservoirParameters::before(WetFace::straight([0.0, depth], 16).unwrap())
            };
            let s = Complex64::new(0.0, 0.6 * PI * parameters.sound_speed / (2.0 * depth));
            let error = error(&parameters, s)?;
            println!("depth {depth} m, far end at {length} h: off by {error:.1e}");
            assert!(error < if length < 0.1 { 3e-2 } else { 2e-3 });
        }
    }
    Ok(())
}

/// One linear element per depth still gives the force to some per cent at low frequencies, one constant element its order
/// of magnitude.
#[test]
fn a_single_element() -> Result<(), ReservoirError> {
    for element_order in [ElementOrder::Linear, ElementOrder::Constant] {
        for surface_waves in [false, true] {
            let parameters = ReservoirParameters {
                element_order,
                surface_waves,
                element_size: 10.0 * DEPTH,
                wet_face: WetFace::straight([0.0, DEPTH], 1).unwrap(),
                ..parameters(0.9, 8, 0.0025, 1.0)
            };
            let s = Complex64::new(0.0, 0.5 * CUT_OFF);
            let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
            let force = of_uniform_motion(&k, s).iter().sum::<Complex64>() / 2.0;
            let exact = chopra_1967::force(s, DEPTH, SOUND_SPEED) / DEPTH;
            println!("{element_order:?}, waves {surface_waves}: force {force:.3}, rigid bed {exact:.3}");
            let most = if element_order == ElementOrder::Linear { 0.1 } else { 0.5 };
            assert!((force / exact - 1.0).norm() < most);
        }
    }
    Ok(())
}

/// Water so deep that e^{kh} overflows, and sound far above its cut-off in damped water.
#[test]
fn nothing_overflows() -> Result<(), ReservoirError> {
    for surface_waves in [false, true] {
        let parameters = ReservoirParameters { surface_waves, ..parameters(0.7, 16, 0.0025, 1.0) };
        for s in [(0.0, 900.0), (2e4, 1e3), (1e6, 0.0), (1e-9, 1e-3), (0.0, 1e-7)] {
            let s = Complex64::new(s.0, s.1);
            let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
            assert!(k.iter().all(|k| k.is_finite()), "s = {s}, waves {surface_waves}");
        }
    }
    Ok(())
}

/// Every number of the parameters negative, zero, infinite and NaN: an error or a result, but no panic.
#[test]
fn wrong_parameters_are_refused() {
    type Change = fn(&mut ReservoirParameters, f64);
    let changes: [(&str, Change); 12] = [
        ("density", |p, v| p.density = v),
        ("sound_speed", |p, v| p.sound_speed = v),
        ("gravity", |p, v| p.gravity = v),
        ("element_size", |p, v| p.element_size = v),
        ("bed_element_size", |p, v| p.bed_element_size = Some(v)),
        ("corner_element_size", |p, v| p.corner_element_size = Some(v)),
        ("far_end_distance", |p, v| p.far_end_distance = v),
        ("communication_step", |p, v| p.communication_step = v),
        ("horizon", |p, v| p.horizon = v),
        ("wave_reflection_coefficient", |p, v| p.wave_reflection_coefficient = v),
        ("bed x", |p, v| p.bed = vec![[v, 0.0]]),
        ("bed y", |p, v| p.bed = vec![[-50.0, v]]),
    ];
    for (name, change) in changes {
        for value in [-1.0, 0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            for fidelity in [Fidelity::Compressible, Fidelity::Incompressible] {
                let mut parameters = ReservoirParameters { fidelity, ..parameters(1.0, 8, 0.0025, 1.0) };
                change(&mut parameters, value);
                // A bed may lie anywhere below the surface, and α may be 0.
                let allowed =
                    (name.starts_with("bed ") && value.is_finite() && (name != "bed x" || value < 0.0))
                        || (name == "wave_reflection_coefficient" && value == 0.0);
                let response = frequency_response(&parameters, &[Complex64::new(0.0, 5.0)], THREADS);
                assert_eq!(response.is_ok(), allowed, "{name} = {value}");
                if fidelity == Fidelity::Incompressible {
                    assert_eq!(added_mass(&parameters).is_ok(), allowed, "{name} = {value}");
                }
            }
        }
    }
    let fine = ReservoirParameters { element_size: 1e-3, ..parameters(1.0, 8, 0.0025, 1.0) };
    let error = frequency_response(&fine, &[Complex64::ONE], THREADS).unwrap_err();
    assert!(matches!(error, ReservoirError::TooMuch { .. }), "{error}");
    let graded = ReservoirParameters { corner_element_size: Some(1e-300), ..parameters(1.0, 8, 0.0025, 1.0) };
    let error = frequency_response(&graded, &[Complex64::ONE], THREADS).map(|_| ());
    println!("corners of 1e-300 m: {error:?}");
}
