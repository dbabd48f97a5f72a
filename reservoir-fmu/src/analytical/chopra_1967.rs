//! Compressible water before a rigid, moving, vertical face on a rigid flat bed.
//!
//! Modes `λ_m = (2m − 1)π/2h`, `κ_m = √(λ_m² + (s/c)²)`. In time the base pressure is a
//! finite sum over the echoes that have arrived.
//!
//! **Source**: Chopra, A. K. (1967), Hydrodynamic pressures on dams during earthquakes,
//! Journal of the Engineering Mechanics Division, ASCE 93 (EM6), 205–223; the static limit
//! is Westergaard's (1933) series. Checked by `tests/chopra_1967.rs`.

use num_complex::Complex64;
use std::f64::consts::PI;

/// Terms of the modal series; they fall like m⁻².
const TERMS: u32 = 20_000;

/// Base pressure over ρah of incompressible water: 8G/π², G Catalan's constant.
pub const STATIC_BASE_PRESSURE: f64 = 8.0 * 0.915_965_594_177_219 / (PI * PI);

/// Force over ρah² of incompressible water: 14ζ(3)/π³.
pub const STATIC_FORCE: f64 = 14.0 * 1.202_056_903_159_594_2 / (PI * PI * PI);

/// `p/(ρa)` in m at elevation y for the acceleration `a e^{st}`:
/// `Σ_m 2(−1)^{m−1}/(λ_m h κ_m) cos λ_m y`.
pub fn pressure(s: Complex64, depth: f64, sound_speed: f64, elevation: f64) -> Complex64 {
    modes(s, depth, sound_speed)
        .map(|(sign, lambda, kappa)| 2.0 * sign * (lambda * elevation).cos() / (lambda * depth) / kappa)
        .sum()
}

/// Force over ρa in m² for the acceleration `a e^{st}`: `Σ_m 2/(λ_m² h κ_m)`.
pub fn force(s: Complex64, depth: f64, sound_speed: f64) -> Complex64 {
    modes(s, depth, sound_speed).map(|(_, lambda, kappa)| 2.0 / (lambda * lambda * depth) / kappa).sum()
}

fn modes(s: Complex64, depth: f64, sound_speed: f64) -> impl Iterator<Item = (f64, f64, Complex64)> {
    (0..TERMS).map(move |m| {
        let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
        let lambda = f64::from(2 * m + 1) * PI / (2.0 * depth);
        (sign, lambda, (lambda * lambda + (s / sound_speed).powi(2)).sqrt())
    })
}

/// Base pressure over ρc (m/s) for the velocity step v = 1 m/s at t = 0:
/// `1 − (4/π) Σ_j (−1)^j acos(b_j/t)`, `b_j = (2j + 1)h/c < t`.
pub fn base_pressure_of_velocity_step(depth: f64, sound_speed: f64, time: f64) -> f64 {
    echoes(depth / sound_speed, time, 1.0, |b, _, w| w.atan2(b))
}

/// Base pressure over ρc (m/s) for the acceleration step a = 1 m/s² at t = 0: the first integral,
/// with `∫acos(b/t) dt = t acos(b/t) − b acosh(t/b)`.
pub fn base_pressure_of_acceleration_step(depth: f64, sound_speed: f64, time: f64) -> f64 {
    echoes(depth / sound_speed, time, time, |b, t, w| t * w.atan2(b) - b * (w / b).asinh())
}

/// Base pressure over ρc (m/s) for the acceleration ramp a = t (1 m/s³) from t = 0: the second
/// integral, `t²/2 acos(b/t) + b/2 √(t² − b²) − bt acosh(t/b)`.
pub fn base_pressure_of_acceleration_ramp(depth: f64, sound_speed: f64, time: f64) -> f64 {
    echoes(depth / sound_speed, time, 0.5 * time * time, |b, t, w| {
        0.5 * t * t * w.atan2(b) + 0.5 * b * w - b * t * (w / b).asinh()
    })
}

/// Base pressure over ρc (m/s) for a piecewise linear acceleration given as (time, acceleration)
/// pairs, zero before the first and constant after the last.
pub fn base_pressure(record: &[(f64, f64)], depth: f64, sound_speed: f64, time: f64) -> f64 {
    let (mut sum, mut slope) = (0.0, 0.0);
    if let Some(&(start, acceleration)) = record.first() {
        sum += acceleration * base_pressure_of_acceleration_step(depth, sound_speed, time - start);
    }
    let slopes = record.windows(2).map(|p| (p[0].0, (p[1].1 - p[0].1) / (p[1].0 - p[0].0)));
    for (start, next) in slopes.chain(record.last().map(|&(end, _)| (end, 0.0))) {
        sum += (next - slope) * base_pressure_of_acceleration_ramp(depth, sound_speed, time - start);
        slope = next;
    }
    sum
}

/// `direct − (4/π) Σ_j (−1)^j echo(b_j, t, w_j)`, zero for t ≤ 0. From `w = √(t² − b²)` both `acos(b/t) = atan(w/b)` and
/// `acosh(t/b) = asinh(w/b)` are exact to rounding also for an echo that has just arrived, where the terms cancel.
fn echoes(crossing: f64, time: f64, direct: f64, echo: impl Fn(f64, f64, f64) -> f64) -> f64 {
    if time <= 0.0 {
        return 0.0;
    }
    let arrived = (0..).map(|j| (j, f64::from(2 * j + 1) * crossing)).take_while(|(_, b)| *b < time);
    let signed = |(j, b): (u32, f64)| {
        let echo = echo(b, time, ((time - b) * (time + b)).sqrt());
        if j % 2 == 0 { echo } else { -echo }
    };
    direct - 4.0 / PI * arrived.map(signed).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn static_limit_of_the_series() {
        let s = Complex64::new(1e-6, 0.0);
        // an alternating and a cubically falling series of 20 000 terms
        assert!((pressure(s, 1.0, 1.0, 0.0).re - STATIC_BASE_PRESSURE).abs() < 1e-8);
        assert!((force(s, 1.0, 1.0).re - STATIC_FORCE).abs() < 1e-8);
    }

    #[test]
    fn a_held_acceleration_tends_to_the_static_pressure() {
        let record = [(0.0, 0.0), (1.0, 0.0), (3.0, 1.0)];
        let p = base_pressure(&record, 1.0, 1.0, 4000.0);
        // the first mode dies like t^{-1/2}: its share at t = 4000 is below 2e-2
        assert!((p / STATIC_BASE_PRESSURE - 1.0).abs() < 0.03, "{p}");
    }
}
