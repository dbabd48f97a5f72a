//! Vertical motion of a level bed under water of infinite extent: plane waves between bed and surface.
//!
//! **Source**: Chakrabarti, P. and Chopra, A. K. (1973), Hydrodynamic pressures and response of gravity dams to
//! vertical earthquake component, Earthquake Engineering and Structural Dynamics 1, 325–335, for a rigid bed; with
//! absorption Fenves, G. and Chopra, A. K. (1984), report UCB/EERC-84/10. Checked by `tests/ground_motion.rs`.

use num_complex::Complex64;

/// `p/(ρa)` in m at elevation y for the upward acceleration `a e^{st}` of the bed, α its wave reflection coefficient:
///
/// `p = ρa [sinh k(h − y)/k] / (cosh kh + qc sinh kh)`, k = s/c, qc = (1 − α)/(1 + α);
/// at the bed `ρah [tanh(kh)/kh]/(1 + qc tanh kh)`, tan for tanh at s = iω.
pub fn pressure(s: Complex64, depth: f64, sound_speed: f64, alpha: f64, elevation: f64) -> Complex64 {
    let k = s / sound_speed;
    // Both sides times 2e^{−kh}.
    (-k * elevation).exp() * (1.0 - (-2.0 * k * (depth - elevation)).exp()) / (k * bed(k * depth, alpha))
}

/// `∫ p dy/(ρa)` in m², of [`pressure`] over the depth: `[(cosh kh − 1)/k²] / (cosh kh + qc sinh kh)`.
pub fn force(s: Complex64, depth: f64, sound_speed: f64, alpha: f64) -> Complex64 {
    let k = s / sound_speed;
    (1.0 - (-k * depth).exp()).powi(2) / (k * k * bed(k * depth, alpha))
}

/// `2e^{−kh} (cosh kh + qc sinh kh)`: no exponent has a positive real part.
fn bed(kh: Complex64, alpha: f64) -> Complex64 {
    let decay = (-2.0 * kh).exp();
    (1.0 + decay) + (1.0 - alpha) / (1.0 + alpha) * (1.0 - decay)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The field equation by central differences, both boundary conditions, the force by summation, and depths at which
    /// hyperbolic functions would overflow.
    #[test]
    fn a_column_of_water_fulfils_its_equations() {
        let (depth, c, alpha) = (90.0, 1440.0, 0.3);
        for s in [Complex64::new(0.0, 20.0), Complex64::new(3.0, 70.0)] {
            let p = |y: f64| pressure(s, depth, c, alpha, y);
            let (h, y) = (1e-2, 30.0);
            let curvature = (p(y + h) - 2.0 * p(y) + p(y - h)) / (h * h);
            assert!((curvature - (s / c).powi(2) * p(y)).norm() < 1e-5 * curvature.norm());
            let slope = (-1.5 * p(0.0) + 2.0 * p(h) - 0.5 * p(2.0 * h)) / h;
            let at_bed = 1.0 - (1.0 - alpha) / (1.0 + alpha) / c * s * p(0.0);
            assert!((-slope - at_bed).norm() < 1e-6 && p(depth).norm() < 1e-12);
            let sum: Complex64 = (0..1000).map(|i| p((f64::from(i) + 0.5) * 0.09) * 0.09).sum();
            assert!((sum - force(s, depth, c, alpha)).norm() < 1e-5 * sum.norm());
        }
        let deep = pressure(Complex64::new(1e6, 0.0), depth, c, 1.0, 0.0);
        assert!((deep.re * 1e6 / c - 1.0).abs() < 1e-12);
    }
}
