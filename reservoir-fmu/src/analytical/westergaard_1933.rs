//! Water pressures on dams during earthquakes: the parabola, and the series that it approximates.
//!
//! **Source**: Westergaard, H. M. (1933), Transactions of the ASCE 98, 418–433. Checked by
//! `tests/westergaard_1933.rs`.

use std::f64::consts::PI;

/// Base pressure over ρah.
pub const BASE_PRESSURE: f64 = 7.0 / 8.0;

/// Force over ρah².
pub const FORCE: f64 = 7.0 / 12.0;

/// `p/(ρa) = ⅞ √(h(h − y))`, m.
pub fn pressure(depth: f64, elevation: f64) -> f64 {
    BASE_PRESSURE * (depth * (depth - elevation)).sqrt()
}

/// `p/(ρa) = 8h/π² S(θ)`, m: incompressible water before a rigid vertical face, summed in closed form.
///
/// `S = Σ_m sin((2m + 1)θ)/(2m + 1)²`, `θ = π(h − y)/2h`. Since `S′ = −½ ln tan(θ/2)`, and
/// `ln tan x = ln x + Σ_k η(2k)/k (2x/π)^{2k}` with Dirichlet's η,
///
/// ```text
/// S = ½ θ [1 − ln(θ/2) − Σ_{k≥1} η(2k)/(k(2k + 1)) (θ/π)^{2k}]
/// ```
///
/// whose terms fall like 4^{−k} or faster, where those of the series fall like m⁻².
pub fn series_pressure(depth: f64, elevation: f64) -> f64 {
    let theta = PI * (depth - elevation) / (2.0 * depth);
    if theta <= 0.0 {
        return 0.0;
    }
    let squared = (theta / PI).powi(2);
    // Twenty-four terms: 4^{−24} is below the rounding.
    let sum: f64 = (1..=24).map(|k| eta(k) * squared.powi(k) / f64::from(k * (2 * k + 1))).sum();
    8.0 * depth / (PI * PI) * 0.5 * theta * (1.0 - (0.5 * theta).ln() - sum)
}

/// η(2k) = Σ_n (−1)^{n−1} n^{−2k}, k ≥ 1.
fn eta(k: i32) -> f64 {
    // Multiples of π^{2k}, from Bernoulli's numbers, where the sum is slow.
    match k {
        1 => PI.powi(2) / 12.0,
        2 => 7.0 * PI.powi(4) / 720.0,
        3 => 31.0 * PI.powi(6) / 30_240.0,
        4 => 127.0 * PI.powi(8) / 1_209_600.0,
        _ => (1..=40).rev().map(|n| if n % 2 == 1 { 1.0 } else { -1.0 } / f64::from(n).powi(2 * k)).sum(),
    }
}
