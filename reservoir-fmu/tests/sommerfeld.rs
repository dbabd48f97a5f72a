//! Distance at which a Sommerfeld end must lie.

use crate::rectangular;

use cofferdam_reservoir::analytical::chopra_1967;
use cofferdam_reservoir::{Complex64, FiniteElements, ReservoirError, ReservoirParameters};
use cofferdam_unit::WetFace;
use nalgebra::DVector;
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, relative};
use std::f64::consts::PI;

const PANELS: usize = 32;

/// The pressure before a uniformly moving face if every mode is reflected at L by `∂p/∂n = −ṗ/c`:
/// each term of Chopra's series times `(1 + R e^{−2κL})/(1 − R e^{−2κL})`, `R = (κ − s/c)/(κ + s/c)`.
fn with_reflections(s: Complex64, distance: f64, elevation: f64) -> Complex64 {
    (0..2000)
        .map(|m| {
            let lambda = f64::from(2 * m + 1) * PI / (2.0 * DEPTH);
            let k = s / SOUND_SPEED;
            let kappa = (lambda * lambda + k * k).sqrt();
            let returned = (kappa - k) / (kappa + k) * (-2.0 * kappa * distance).exp();
            let sign = if m % 2 == 0 { 2.0 } else { -2.0 };
            sign * (lambda * elevation).cos() / (lambda * DEPTH) / kappa * (1.0 + returned) / (1.0 - returned)
        })
        .sum()
}

fn projected(face: &WetFace, field: impl Fn(f64) -> Complex64) -> DVector<Complex64> {
    DVector::from_vec(rectangular::projected(face, |at| at.iter().copied().map(field).collect()))
}

/// Relative L2 error on the face, beside that of the closed form with the reflections of the end: the error comes from the
/// end, not from the elements. The elements' error is at most 5e-4 (h/12, order 3: at 2.5 ω₁ the wave is 1.6 h long), times
/// the factor of a resonance between face and end.
#[test]
fn error_of_the_end() -> Result<(), ReservoirError> {
    const RATIOS: [f64; 4] = [0.5, 0.99, 1.5, 2.5];
    let frequency = |ratio| Complex64::new(1e-6, ratio) * (PI * SOUND_SPEED / (2.0 * DEPTH));
    let at = |distance: f64| ReservoirParameters {
        element_size: DEPTH / 12.0,
        corner_element_size: Some(DEPTH / 2048.0),
        far_end_distance: distance * DEPTH,
        ..rectangular::parameters(1.0, PANELS, 0.0025, 1.0)
    };
    let face = at(1.0).wet_face;
    let exact = RATIOS.map(|ratio| {
        let s = frequency(ratio);
        projected(&face, |y| chopra_1967::pressure(s, DEPTH, SOUND_SPEED, y))
    });
    println!(
        "relative L2 error on the face, rigid bed, uniform motion (in brackets: predicted from the reflections)"
    );
    println!("   L/h            0.5 ω₁           0.99 ω₁            1.5 ω₁            2.5 ω₁");
    for distance in [1.0, 2.0, 4.0, 8.0] {
        let water = FiniteElements::new(&at(distance))?;
        let (mut row, mut worst) = (format!("{distance:>6}"), 0.0f64);
        for (ratio, exact) in RATIOS.into_iter().zip(&exact) {
            let s = frequency(ratio);
            let symbol = water.symbol(s)?;
            let found = DVector::from_fn(PANELS + 1, |i, _| {
                -symbol.row(i).columns(0, PANELS + 1).sum() / (s * DENSITY)
            });
            let reflected = projected(&face, |y| with_reflections(s, distance * DEPTH, y));
            row += &format!(" {:>8.2e} ({:.1e})", relative(&found, exact), relative(&reflected, exact));
            worst = worst.max(relative(&found, &reflected) / (reflected.norm() / exact.norm()).max(1.0));
        }
        println!("{row}; from the prediction {worst:.1e} at most");
        assert!(worst < 5e-4);
    }
    Ok(())
}

/// Ramp and hold for 4 s at 2.5 ms: exact, up to the elements' error, until the first wave has returned from the end,
/// 2L/c; afterwards the reflections appear. Largest error of the base pressure, divided by the largest base pressure.
#[test]
fn ramp_and_hold() -> Result<(), ReservoirError> {
    let (rise, step) = (0.1, 0.0025);
    let velocity = |t: f64| if t < rise { 0.5 * t * t / rise } else { t - 0.5 * rise };
    let exact = |t| {
        DENSITY * SOUND_SPEED * chopra_1967::base_pressure(&[(0.0, 0.0), (rise, 1.0)], DEPTH, SOUND_SPEED, t)
    };
    let mut late = Vec::new();
    for distance in [0.5, 1.0, 2.0, 4.0, 8.0] {
        let water = FiniteElements::new(&ReservoirParameters {
            element_size: DEPTH / 12.0,
            far_end_distance: distance * DEPTH,
            ..rectangular::parameters(1.0, PANELS, step, 1.0)
        })?;
        let (mut state, mut next) = (vec![0.0; water.state_len()], vec![0.0; water.state_len()]);
        let back = 2.0 * distance * DEPTH / SOUND_SPEED;
        let (mut before, mut after, mut peak): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for n in 1..=1600 {
            let t = f64::from(n) * step;
            let mut inputs = vec![-velocity(t); water.inputs()];
            inputs[PANELS + 1..].fill(0.0);
            let error = (water.step(&state, &inputs, &mut next)[0] - exact(t)).abs();
            std::mem::swap(&mut state, &mut next);
            peak = peak.max(exact(t).abs());
            if t < back { before = before.max(error) } else { after = after.max(error) }
        }
        println!(
            "ramp and hold, L = {distance} h: error {:.1e} of the peak before 2L/c = {back:.2} s, {:.1e} after",
            before / peak,
            after / peak
        );
        assert!(before < 2e-3 * peak);
        late.push(after / peak);
    }
    // A larger distance is better; the reflected waves do not come from the elements.
    assert!(late.windows(2).all(|pair| pair[1] < pair[0]) && late[0] > 0.05);
    Ok(())
}
