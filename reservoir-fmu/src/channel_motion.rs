//! The response of the channel upstream to vertical motion of the ground: plane waves between bed and surface.
//!
//! Depends on `water`.

use crate::water::Water;
use num_complex::Complex64;

/// Below this |kξ|, two terms of the series of sinh are exact to rounding.
const SMALL: f64 = 1e-3;

/// `p₁/(ρ s v)` (m) at the depth `below` (m) under the surface of a channel of `depth` (m), whose bed moves
/// upwards with the velocity v:
///
/// ```text
/// p₁ = ρ s v σ(ξ)/(χ(d) + q s σ(d)),                                        p = 0 at the surface
/// p₁ = ρ s v [s² σ(ξ) + g χ(ξ)]/[s² χ(d) + g k² σ(d) + q s (s² σ(d) + g χ(d))],  with gravity waves
/// ```
///
/// with `σ(ξ) = sinh(kξ)/k`, `χ(ξ) = cosh kξ`, k = s/c, both multiplied by `e^{−kd}` to avoid overflow.
/// p₁ does not depend on x, so it is not an outgoing wave. At s = 0 and without gravity waves the result is ξ.
pub(crate) fn plane_wave(water: &Water, s: Complex64, depth: f64, below: f64) -> Complex64 {
    let k = s / water.sound_speed;
    let [sine, cosine] = scaled(k, depth, below);
    let [sine_at_bed, cosine_at_bed] = scaled(k, depth, depth);
    let bed = water.bed_admittance * s;
    match water.gravity {
        None => sine / (cosine_at_bed + bed * sine_at_bed),
        Some(g) => {
            let top = |sine: Complex64, cosine: Complex64| s * s * sine + g * cosine;
            let slope = s * s * cosine_at_bed + g * k * k * sine_at_bed;
            top(sine, cosine) / (slope + bed * top(sine_at_bed, cosine_at_bed))
        }
    }
}

/// `[sinh(kξ)/k, cosh kξ] e^{−kd}` for 0 ≤ ξ ≤ d, Re k ≥ 0.
fn scaled(k: Complex64, depth: f64, below: f64) -> [Complex64; 2] {
    let [up, down] = [(k * (below - depth)).exp(), (-k * (below + depth)).exp()];
    let z = k * below;
    let sine = if z.norm() < SMALL {
        below * (1.0 + z * z / 6.0) * (-k * depth).exp()
    } else {
        (up - down) / (2.0 * k)
    };
    [sine, 0.5 * (up + down)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equation and both boundary conditions, checked by finite differences.
    #[test]
    fn plane_waves_obey_their_equation() {
        let (depth, step) = (90.0, 1e-2);
        for gravity in [None, Some(9.81)] {
            for bed_admittance in [0.0, 3e-4] {
                for s in [(0.0, 20.0), (3.0, 8.0), (1e-2, 0.0), (0.0, 0.3), (40.0, 900.0)] {
                    let (water, s) = (
                        Water { density: 1000.0, sound_speed: 1440.0, bed_admittance, gravity },
                        Complex64::new(s.0, s.1),
                    );
                    let p = |below: f64| plane_wave(&water, s, depth, below);
                    let k = s / water.sound_speed;
                    let slope = |x: f64| (p(x + step) - p(x - step)) / (2.0 * step);
                    // ξ points downwards, out of the water at the bed: ∂p/∂n = −ρ s v·n − q s p, v·n = −v.
                    let at_bed = (slope(depth) - (1.0 - bed_admittance * s * p(depth))).norm();
                    let at_top = gravity.map_or(p(0.0), |g| slope(0.0) - s * s / g * p(0.0)).norm();
                    let curvature = (p(40.0 + step) + p(40.0 - step) - 2.0 * p(40.0)) / (step * step);
                    let inside = (curvature - k * k * p(40.0)).norm() / ((k * k * p(40.0)).norm() + 1e-4);
                    println!("s = {s}, {gravity:?}: {at_bed:.1e} {at_top:.1e} {inside:.1e}");
                    assert!(at_bed < 1e-4 && at_top < 1e-4 && inside < 1e-2);
                }
            }
        }
        let water = Water { density: 1.0, sound_speed: f64::INFINITY, bed_admittance: 0.0, gravity: None };
        assert_eq!(plane_wave(&water, Complex64::ZERO, depth, 30.0), 30.0.into());
    }
}
