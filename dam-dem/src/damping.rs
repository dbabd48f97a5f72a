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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_holds_at_both_frequencies() {
        let rayleigh = RayleighCoefficients::through(0.05, [18.9, 94.5]);
        for frequency in [18.9, 94.5] {
            assert!((rayleigh.ratio_at(frequency) - 0.05).abs() < 1e-15);
        }
    }
}
