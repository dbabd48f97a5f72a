//! Cut-off frequencies of the channel, where the response of a rigid bed is infinite.
//!
//! Depends on `water`.

use crate::ReservoirError;
use crate::water::Water;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Relative distance from a cut-off frequency within which a response is refused.
const CLOSE: f64 = 1e-6;

/// ω (rad/s) at which the `mode`-th mode (from 1) of a channel of `depth` (m) over a rigid bed begins to propagate.
///
/// `ωd/c = (2m − 1)π/2`; with gravity waves `tan(ωd/c) = −ωc/g`, and a mode 0 propagates at all frequencies.
pub(crate) fn cut_off(water: &Water, depth: f64, mode: f64) -> f64 {
    let rate = water.sound_speed / depth;
    match water.gravity {
        None => (mode - 0.5) * PI * rate,
        // A contraction: with x = ωd/c and a = c²/gd the slope is a/(1 + a²x²) ≤ 1/2x < ⅓.
        Some(g) => (0..60).fold((mode - 0.5) * PI * rate, |omega, _| {
            (mode * PI - (omega * water.sound_speed / g).atan()) * rate
        }),
    }
}

/// Refuses s = iω at a cut-off frequency of a rigid bed.
///
/// There a mode neither decays nor propagates: `κ = 0`, and the pressure per velocity is unbounded.
///
/// **Errors**: [`ReservoirError::CutOff`].
pub(crate) fn check_cut_off(water: &Water, s: Complex64, depth: f64) -> Result<(), ReservoirError> {
    if water.bed_admittance > 0.0 || !water.sound_speed.is_finite() || s == Complex64::ZERO {
        return Ok(());
    }
    let mode = (s.im.abs() * depth / (PI * water.sound_speed) + 0.5).round();
    // With gravity waves the cut-offs can lie up to half a mode higher; in real water the shift is far smaller.
    for mode in [mode - 1.0, mode] {
        if mode < 1.0 {
            continue;
        }
        let cut_off = cut_off(water, depth, mode);
        if (Complex64::new(s.re, s.im.abs()) - Complex64::new(0.0, cut_off)).norm() < CLOSE * cut_off {
            return Err(ReservoirError::CutOff { frequency: s, mode: mode as u64, cut_off });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cut_offs_solve_their_equation_and_are_refused() {
        let depth = 180.0;
        let water = |gravity| Water { density: 1000.0, sound_speed: 1440.0, bed_admittance: 0.0, gravity };
        for gravity in [None, Some(9.81), Some(9.81e4)] {
            for mode in [1.0, 2.0, 7.0] {
                let omega = cut_off(&water(gravity), depth, mode);
                // cos x = 0, or sin x + (ωc/g) cos x = 0
                let x = omega * depth / 1440.0;
                let off = gravity.map_or(x.cos(), |g| x.sin() * g / (omega * 1440.0) + x.cos());
                println!("gravity {gravity:?}, mode {mode}: ω = {omega}, equation off by {off:.1e}");
                assert!(off.abs() < 1e-12);
                for sign in [1.0, -1.0] {
                    let at = |ratio: f64| {
                        check_cut_off(&water(gravity), Complex64::new(0.0, sign * ratio * omega), depth)
                    };
                    let refused = at(1.0 - 5e-7).unwrap_err();
                    assert!(matches!(refused, ReservoirError::CutOff { mode: m, .. } if m as f64 == mode));
                    assert!(at(1.0 + 2e-6).is_ok() && at(0.9).is_ok());
                }
                let damped = Complex64::new(1e-5 * omega, omega);
                assert!(check_cut_off(&water(gravity), damped, depth).is_ok());
                let absorbing = Water { bed_admittance: 1e-5, ..water(gravity) };
                assert!(check_cut_off(&absorbing, Complex64::new(0.0, omega), depth).is_ok());
            }
        }
    }
}
