//! A plane wave that crosses a joint at normal incidence.
//!
//! On both sides of a joint without mass the stress is the same, and the velocities differ by the rate of
//! closure of the joint. Therefore `σ̇_t = (2k/Z) (σ_i − σ_t)`, with stiffness k and impedance `Z = ρc`, and
//! the amplitude of a harmonic wave is multiplied by `1/√(1 + (ωZ/2k)²)`.
//!
//! **Source**: L.J. Pyrak-Nolte, L.R. Myer, N.G.W. Cook, *Transmission of seismic waves across single natural
//! fractures*, Journal of Geophysical Research 95 (1990) 8617–8638; tested in `tests/waves.rs`.

use std::f64::consts::TAU;

/// Transmitted share of the amplitude of a harmonic wave with circular frequency `frequency` (rad/s).
///
/// **Units**: `impedance` ρc in Pa·s/m, `stiffness` k in Pa/m.
pub fn transmission(frequency: f64, impedance: f64, stiffness: f64) -> f64 {
    1.0 / (1.0 + (frequency * impedance / (2.0 * stiffness)).powi(2)).sqrt()
}

/// Transmitted stress at time `t` (s) over the largest incident stress, for the pulse `sin²(πt/T)`, 0 ≤ t ≤
/// T, with T = `duration` (s); `rate` is 2k/Z, 1/s.
pub fn transmitted_pulse(rate: f64, duration: f64, t: f64) -> f64 {
    if t <= 0.0 {
        return 0.0;
    }
    let turn = TAU / duration;
    let within = |t: f64| {
        let decay = (-rate * t).exp();
        let harmonic = rate * (rate * (turn * t).cos() + turn * (turn * t).sin() - rate * decay);
        0.5 * (1.0 - decay - harmonic / (rate * rate + turn * turn))
    };
    if t < duration { within(t) } else { within(duration) * (-rate * (t - duration)).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pulse satisfies its differential equation, and a stiff joint transmits it completely.
    #[test]
    fn the_pulse_solves_its_equation() {
        let (rate, duration, step) = (70.0, 0.05, 1e-6);
        for t in [0.01, 0.03, 0.049, 0.06] {
            let incident = if t < duration { (0.5 * TAU * t / duration).sin().powi(2) } else { 0.0 };
            let at = |t| transmitted_pulse(rate, duration, t);
            let slope = (at(t + step) - at(t - step)) / (2.0 * step);
            assert!((slope - rate * (incident - at(t))).abs() < 1e-6 * rate);
        }
        assert!((transmitted_pulse(1e7, duration, 0.025) - 1.0).abs() < 1e-5);
        assert!((transmission(1.0, 2.0, 1.0) - 0.5f64.sqrt()).abs() < 1e-15);
    }
}
