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
    let absorption = (1.0 - alpha) / (1.0 + alpha);
    // All times 2e^{−kh}.
    let below = depth - elevation;
    let numerator = (k * (below - depth)).exp() - (-k * (below + depth)).exp();
    let decay = (-2.0 * k * depth).exp();
    numerator / k / ((1.0 + decay) + absorption * (1.0 - decay))
}
