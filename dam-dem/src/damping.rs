//! Rayleigh damping `C = α M + β K`.

use serde::{Deserialize, Serialize};

use crate::error::{DamError, require};

/// Damping of the dam.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Damping {
    /// No damping.
    None,
    /// `C = α M + β K`, with one damping ratio at two frequencies. β damps the contacts too.
    Rayleigh {
        /// Damping ratio ξ, in (0, 1).
        ratio: f64,
        /// The two frequencies.
        frequencies: DampingFrequencies,
    },
}

/// Where the damping ratio holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DampingFrequencies {
    /// Multiples of the first frequency of the intact dam on an empty reservoir.
    MultiplesOfFirst([f64; 2]),
    /// Circular frequencies, rad/s.
    RadiansPerSecond([f64; 2]),
}

impl Damping {
    /// Checks the ranges.
    ///
    /// **Errors**: [`DamError::OutOfRange`] for a ratio outside (0, 1), or frequencies that are
    /// not positive and ascending.
    pub fn check(&self) -> Result<(), DamError> {
        let Self::Rayleigh { ratio, frequencies } = self else { return Ok(()) };
        require(*ratio > 0.0 && *ratio < 1.0, "damping ratio", *ratio, "between 0 and 1, both excluded")?;
        let (DampingFrequencies::MultiplesOfFirst([a, b]) | DampingFrequencies::RadiansPerSecond([a, b])) =
            *frequencies;
        require(a > 0.0, "lower damping frequency", a, "positive")?;
        require(b > a, "upper damping frequency", b, "above the lower one")
    }
}

/// Coefficients of `C = α M + β K`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RayleighCoefficients {
    /// α, 1/s.
    pub mass: f64,
    /// β, s.
    pub stiffness: f64,
}

impl RayleighCoefficients {
    /// `α = 2ξω₁ω₂/(ω₁+ω₂)`, `β = 2ξ/(ω₁+ω₂)`: ratio ξ at the circular frequencies ω₁ and ω₂, rad/s.
    pub fn through(ratio: f64, [low, high]: [f64; 2]) -> Self {
        let stiffness = 2.0 * ratio / (low + high);
        Self { mass: stiffness * low * high, stiffness }
    }

    /// Damping ratio at circular frequency ω, rad/s: `ξ = α/2ω + βω/2`.
    pub fn ratio_at(&self, frequency: f64) -> f64 {
        self.mass / (2.0 * frequency) + self.stiffness * frequency / 2.0
    }

    /// The same where stiffness damping has the memory m and frequency ω is the highest: what limits the time
    /// step, `ξ = α/2ω + (1 − m)/(1 + m) βω/2`.
    pub fn limiting_ratio(&self, frequency: f64, memory: f64) -> f64 {
        let felt = Self { stiffness: self.stiffness * (1.0 - memory) / (1.0 + memory), ..*self };
        felt.ratio_at(frequency)
    }

    /// Least memory with which stiffness damping lets a time step reach `share` of 2/ω, ω the highest frequency
    /// (rad/s): m with `√(1 + ξ²) − ξ = share`, `ξ = (1 − m)/(1 + m) βω/2`; 0 where βω/2 is small enough.
    pub fn memory_reaching(&self, share: f64, frequency: f64) -> f64 {
        let allowed = (1.0 - share * share) / (2.0 * share);
        let kept = allowed / (self.stiffness * frequency / 2.0);
        if kept < 1.0 { (1.0 - kept) / (1.0 + kept) } else { 0.0 }
    }
}

/// Stiffness damping as it acts from one time step to the next, with a memory m in [0, 1):
///
/// ```text
/// dⁿ = m dⁿ⁻¹ + (1 − m) β K vⁿ⁻½
/// ```
///
/// for the damping stress of every element, and for the rates that dashpots of closed contacts feel. With time
/// steps Δt this is a Maxwell element, `τ ḋ + d = β K v`, `τ = m Δt/(1 − m)`: a spring β/τ times as stiff as the
/// element in series with the dashpot. Elastic forces are not touched. It tends to `β K v` with Δt, and stretches
/// the time step that damping allows by up to (1 + m)/(1 − m)
/// ([`CriticalTimeStep`](crate::CriticalTimeStep)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StiffnessDamping {
    /// β, s.
    pub coefficient: f64,
    /// m.
    pub memory: f64,
}

/// Without memory.
impl From<f64> for StiffnessDamping {
    fn from(coefficient: f64) -> Self {
        Self { coefficient, memory: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_reaches_the_share() {
        let rayleigh = RayleighCoefficients { mass: 0.0, stiffness: 1e-3 };
        for (share, frequency) in [(0.3, 1e4), (0.3, 1e5), (0.5, 4e3)] {
            let memory = rayleigh.memory_reaching(share, frequency);
            let ratio = rayleigh.limiting_ratio(frequency, memory);
            assert!(memory > 0.0 && ((1.0 + ratio * ratio).sqrt() - ratio - share).abs() < 1e-14);
        }
        assert_eq!(rayleigh.memory_reaching(0.3, 3e3), 0.0);
        assert_eq!(RayleighCoefficients::default().memory_reaching(0.3, 3e3), 0.0);
    }

    #[test]
    fn the_ratio_holds_at_both_frequencies() {
        let rayleigh = RayleighCoefficients::through(0.05, [18.9, 94.5]);
        for frequency in [18.9, 94.5] {
            assert!((rayleigh.ratio_at(frequency) - 0.05).abs() < 1e-15);
        }
    }
}
