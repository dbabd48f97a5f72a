//! Gravity waves before a rigid, moving, vertical face on a rigid flat bed, at real frequencies.
//!
//! At the surface `∂p/∂y = (ω²/g) p`. Modes `ψ_m = cos λ_m y` with `λ tan λh = −ω²/g`: one imaginary λ₀ = iμ,
//! `μ tanh μh = ω²/g`, the gravity wave, and λ_m in ((m − ½)π/h, mπ/h), m = 1, 2, …, which are sound waves if ω
//! exceeds λ_m c and decay otherwise. Everything is scaled by e^{−μh}, so that deep water does not overflow.
//!
//! **Source**: Bustamante, J. I., Rosenblueth, E., Herrera, I. and Flores, A. (1963), Presión hidrodinámica en presas
//! y depósitos, Boletín de la Sociedad Mexicana de Ingeniería Sísmica 1 (2), 37–54; of incompressible water the
//! wavemaker of Havelock, T. H. (1929), Forced surface-waves on water, Philosophical Magazine 8, 569–576. Both sum
//! these modes. Checked by `tests/bustamante_1963.rs`.

use num_complex::Complex64;
use std::f64::consts::PI;

/// Terms of the modal series; they fall like m⁻³, except near the corner at the surface.
const TERMS: u32 = 4000;

/// μ (1/m) of the gravity wave: `μ tanh μh = ω²/g`.
///
/// Its wavenumber along x is `√(μ² + ω²/c²)`.
pub fn gravity_wave(omega: f64, depth: f64, gravity: f64) -> f64 {
    let deep = omega * omega / gravity;
    // From √(deep/h), the long wave's, or deep, whichever is larger, the function is convex: Newton's method.
    let mut mu = deep.max((deep / depth).sqrt());
    for _ in 0..50 {
        let t = (mu * depth).tanh();
        mu -= (mu * t - deep) / (t + mu * depth * (1.0 - t * t));
    }
    mu
}

/// λ_m (1/m), m ≥ 1: `λ tan λh = −ω²/g`, by bisection.
pub fn evanescent(m: u32, omega: f64, depth: f64, gravity: f64) -> f64 {
    let deep = omega * omega * depth / gravity;
    let [mut low, mut high] = [(f64::from(m) - 0.5) * PI, f64::from(m) * PI];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        // (−1)^m (x sin x + X cos x) rises through its root.
        let sign = if m.is_multiple_of(2) { 1.0 } else { -1.0 };
        if sign * (middle * middle.sin() + deep * middle.cos()) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high) / depth
}

/// `p/(ρa)` in m at every elevation y for the acceleration `a e^{iωt}` towards the water:
/// `Σ_m ψ_m(y) ∫ψ_m/(κ_m ∫ψ_m²)`, `κ_m = √(λ_m² − ω²/c²)`, with the root +i|κ| for modes that propagate.
///
/// The sound speed may be infinite.
pub fn pressures(
    omega: f64,
    depth: f64,
    sound_speed: f64,
    gravity: f64,
    elevations: &[f64],
) -> Vec<Complex64> {
    let sound = (omega / sound_speed).powi(2);
    let root = |square: f64| Complex64::from(square - sound).sqrt();
    let mu = gravity_wave(omega, depth, gravity);
    // cosh μy, sinh μh / μ and the norm, times e^{−μh}, e^{−μh} and e^{−2μh}.
    let decay = (-2.0 * mu * depth).exp();
    let mean = 0.5 * (1.0 - decay) / mu;
    let norm = 0.5 * depth * decay + 0.125 * (1.0 - decay * decay) / mu;
    let wave = mean / norm / root(-mu * mu);
    let hyperbolic = |y: f64| 0.5 * ((mu * (y - depth)).exp() + (-mu * (y + depth)).exp());
    let mut pressures: Vec<Complex64> = elevations.iter().map(|&y| wave * hyperbolic(y)).collect();
    for m in 1..=TERMS {
        let lambda = evanescent(m, omega, depth, gravity);
        let phase = lambda * depth;
        let mean = phase.sin() / lambda;
        let norm = 0.5 * depth + (2.0 * phase).sin() / (4.0 * lambda);
        let factor = mean / norm / root(lambda * lambda);
        for (pressure, y) in pressures.iter_mut().zip(elevations) {
            *pressure += factor * (lambda * y).cos();
        }
    }
    pressures
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The eigenvalues from long to deep-water waves, and the long wave's pressure √(g/h)/(iω) h.
    #[test]
    fn eigenvalues_solve_their_equations() {
        let (depth, gravity) = (100.0, 9.81);
        for omega in [1e-6, 0.05, 0.3, 3.0, 200.0] {
            let deep: f64 = omega * omega / gravity;
            let mu = gravity_wave(omega, depth, gravity);
            assert!((mu * (mu * depth).tanh() / deep - 1.0).abs() < 1e-12, "ω = {omega}: {mu}");
            for m in [1, 5, 1000] {
                let lambda = evanescent(m, omega, depth, gravity);
                let off = lambda * (lambda * depth).sin() + deep * (lambda * depth).cos();
                assert!(off.abs() < 1e-11 * (lambda + deep), "ω = {omega}, λ_{m} = {lambda}: {off}");
            }
            let p = pressures(omega, depth, 1440.0, gravity, &[0.0, depth]);
            assert!(p.iter().all(|p| p.is_finite()));
        }
        let p = pressures(1e-5, depth, f64::INFINITY, gravity, &[0.0])[0];
        let long = (gravity * depth).sqrt() / Complex64::new(0.0, 1e-5);
        assert!((p / long - 1.0).norm() < 1e-4, "{p} {long}");
    }
}
