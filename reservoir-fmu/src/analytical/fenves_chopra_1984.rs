//! Compressible water before a rigid, moving, vertical face on an absorbing flat bed.
//!
//! At the bed `∂p/∂y = q s p`, `q = (1 − α)/((1 + α)c)`. Modes `ψ_m = sin λ_m(h − y)` with
//! `λ cos λh + q s sin λh = 0`, which is `e^{2iλh} = −(λ − ωq)/(λ + ωq)` for s = iω.
//!
//! **Source**: Fenves, G. and Chopra, A. K. (1984), Earthquake analysis and response of
//! concrete gravity dams, report UCB/EERC-84/10. Checked by `tests/fenves_chopra_1984.rs`.

use num_complex::Complex64;
use std::f64::consts::PI;

/// Terms of the modal series; they fall like m⁻².
const TERMS: usize = 4000;
/// Terms of the force's series, which fall like m⁻³.
const FORCE_TERMS: usize = 400;
/// Steps of the first mode's continuation from the rigid bed.
const CONTINUATION: u32 = 80;

/// `p/(ρa)` in m at every elevation y for the acceleration `a e^{st}`:
/// `Σ_m ψ_m(y) ∫ψ_m/(κ_m ∫ψ_m²)`, `κ_m = √(λ_m² + (s/c)²)`.
pub fn pressures(
    s: Complex64,
    depth: f64,
    sound_speed: f64,
    alpha: f64,
    elevations: &[f64],
) -> Vec<Complex64> {
    let mut pressures = vec![Complex64::ZERO; elevations.len()];
    for (lambda, mean, weight) in modes(s, depth, sound_speed, alpha).take(TERMS) {
        for (pressure, y) in pressures.iter_mut().zip(elevations) {
            *pressure += (lambda * (depth - y)).sin() * mean * weight;
        }
    }
    pressures
}

/// Force over ρa in m² for the acceleration `a e^{st}`: `Σ_m (∫ψ_m)²/(κ_m ∫ψ_m²)`.
pub fn force(s: Complex64, depth: f64, sound_speed: f64, alpha: f64) -> Complex64 {
    let modes = modes(s, depth, sound_speed, alpha).take(FORCE_TERMS);
    modes.map(|(_, mean, weight)| mean * mean * weight).sum()
}

/// λ_m, `∫ψ_m` and `1/(κ_m ∫ψ_m²)` of all modes.
fn modes(
    s: Complex64,
    depth: f64,
    sound_speed: f64,
    alpha: f64,
) -> impl Iterator<Item = (Complex64, Complex64, Complex64)> {
    let admittance = (1.0 - alpha) / ((1.0 + alpha) * sound_speed);
    (0..).map(move |m| {
        let lambda = eigenvalue(m, admittance * s, depth);
        let kappa = (lambda * lambda + (s / sound_speed).powi(2)).sqrt();
        let phase = lambda * depth;
        let mean = (1.0 - phase.cos()) / lambda;
        let norm = depth / 2.0 - (2.0 * phase).sin() / (4.0 * lambda);
        (lambda, mean, 1.0 / (kappa * norm))
    })
}

/// λ_m by Newton's method, continued from the rigid bed's `(2m + 1)π/2h` to `bed` = q s.
fn eigenvalue(m: u32, bed: Complex64, depth: f64) -> Complex64 {
    let mut lambda = Complex64::from(f64::from(2 * m + 1) * PI / (2.0 * depth));
    // The bed's term in the equation falls like 1/λ, and so does the number of steps needed.
    let share = (bed.norm() / lambda.norm()).min(1.0);
    let steps = (f64::from(CONTINUATION) * share).ceil().max(2.0) as u32;
    for step in 1..=steps {
        let bed = bed * f64::from(step) / f64::from(steps);
        for _ in 0..4 {
            let (sine, cosine) = ((lambda * depth).sin(), (lambda * depth).cos());
            let value = lambda * cosine + bed * sine;
            let slope = cosine - lambda * depth * sine + bed * depth * cosine;
            lambda -= value / slope;
        }
    }
    lambda
}

/// Base pressure over ρcv before the first echo from the surface, t < h/c, after a velocity
/// step v: `γ = 2(1 + α)/(π√α) atan √α`, 2/π for α = 0.
///
/// It is the self-similar field of a corner between a moving face and an absorbing bed.
pub fn early_base_pressure(alpha: f64) -> f64 {
    let root = alpha.sqrt();
    let ratio = if root > 0.0 { root.atan() / root } else { 1.0 };
    2.0 * (1.0 + alpha) / PI * ratio
}
