//! Damping: `C = α M + β K`, or local damping.

use serde::{Deserialize, Serialize};

use crate::error::{DamError, Problem, require};

mod model;

pub use model::DampingModel;

/// Damping of the dam. Sliding depends strongly on it, also because β acts in the contacts: state the damping
/// with every result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Damping {
    /// No damping.
    None,
    /// `C = α M + β K`, with the same damping ratio at two frequencies. β also acts in the contacts.
    Rayleigh {
        /// Damping ratio ξ, in (0, 1).
        ratio: f64,
        /// The two frequencies.
        frequencies: DampingFrequencies,
    },
    /// `C = α M`: slow motion, and sliding or rocking of blocks, are damped more than fast vibration.
    Mass {
        /// Damping ratio ξ, in (0, 1).
        ratio: f64,
        /// The ratio holds at the lower frequency; the other one is not used.
        frequencies: DampingFrequencies,
    },
    /// `C = β K`, also in the contacts: fast vibration is damped more than slow motion.
    Stiffness {
        /// Damping ratio ξ, in (0, 1).
        ratio: f64,
        /// The ratio holds at the lower frequency; the other one is not used.
        frequencies: DampingFrequencies,
    },
    /// A force `−κ |F| sgn v` against the motion of every degree of freedom, with the out-of-balance force F.
    /// The damping ratio is the same at every frequency, `κ = tanh πξ`; steady motion is not damped. The sign
    /// changes smoothly around v = 0, over about 1 mm/s. It is not linear and not available with modes.
    ///
    /// **Source**: P.A. Cundall, *Distinct element models of rock and soil structure*, 1987.
    Local {
        /// Coefficient κ, in (0, 1).
        coefficient: f64,
    },
}

/// Frequencies at which the damping ratio holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DampingFrequencies {
    /// Multiples of the first frequency of the intact dam with an empty reservoir.
    MultiplesOfFirst([f64; 2]),
    /// Circular frequencies, rad/s.
    RadiansPerSecond([f64; 2]),
}

/// Rayleigh damping of 5 %.
impl Default for Damping {
    fn default() -> Self {
        Self::Rayleigh { ratio: 0.05, frequencies: DampingFrequencies::default() }
    }
}

/// Once and five times the first frequency.
impl Default for DampingFrequencies {
    fn default() -> Self {
        Self::MultiplesOfFirst([1.0, 5.0])
    }
}

impl Damping {
    /// What is wrong: a ratio or coefficient must lie in (0, 1), frequencies must be positive and ascend.
    pub(crate) fn problems(&self) -> Vec<Problem> {
        let share = |name, value: f64| {
            require(value > 0.0 && value < 1.0, name, value, "between 0 and 1, both excluded")
        };
        let checks = match *self {
            Self::None => Vec::new(),
            Self::Rayleigh { ratio, frequencies }
            | Self::Mass { ratio, frequencies }
            | Self::Stiffness { ratio, frequencies } => {
                let (DampingFrequencies::MultiplesOfFirst([low, high])
                | DampingFrequencies::RadiansPerSecond([low, high])) = frequencies;
                let lower = require(low > 0.0, "lower damping frequency", low, "positive");
                let upper = require(high > low, "upper damping frequency", high, "above the lower one");
                vec![
                    ("damping.ratio", share("damping ratio", ratio)),
                    ("damping.frequencies", lower.and(upper)),
                ]
            }
            Self::Local { coefficient } => vec![("damping.ratio", share("local damping", coefficient))],
        };
        checks.into_iter().filter_map(|(key, check)| Some(Problem::of([key], check.err()?))).collect()
    }

    /// The kind of damping; `None` without damping.
    pub fn model(&self) -> Option<DampingModel> {
        Some(match self {
            Self::None => return None,
            Self::Rayleigh { .. } => DampingModel::Rayleigh,
            Self::Mass { .. } => DampingModel::Mass,
            Self::Stiffness { .. } => DampingModel::Stiffness,
            Self::Local { .. } => DampingModel::Local,
        })
    }

    /// The frequencies at which the ratio holds, rad/s; zeros without a ratio. `first` computes the first natural
    /// frequency and is called only if it is needed.
    pub(crate) fn frequencies(
        &self,
        first: impl FnOnce() -> Result<f64, DamError>,
    ) -> Result<[f64; 2], DamError> {
        let (frequencies, one) = match *self {
            Self::None | Self::Local { .. } => return Ok([0.0; 2]),
            Self::Rayleigh { frequencies, .. } => (frequencies, false),
            Self::Mass { frequencies, .. } | Self::Stiffness { frequencies, .. } => (frequencies, true),
        };
        let [low, high] = match frequencies {
            DampingFrequencies::RadiansPerSecond(frequencies) => frequencies,
            DampingFrequencies::MultiplesOfFirst(multiples) => {
                let first = first()?;
                multiples.map(|multiple| multiple * first)
            }
        };
        Ok([low, if one { low } else { high }])
    }

    /// α and β that give the ratio at `frequencies`, rad/s.
    pub(crate) fn coefficients(&self, frequencies: [f64; 2]) -> RayleighCoefficients {
        match *self {
            Self::None | Self::Local { .. } => RayleighCoefficients::default(),
            Self::Rayleigh { ratio, .. } => RayleighCoefficients::through(ratio, frequencies),
            Self::Mass { ratio, .. } => {
                RayleighCoefficients { mass: 2.0 * ratio * frequencies[0], stiffness: 0.0 }
            }
            Self::Stiffness { ratio, .. } => {
                RayleighCoefficients { mass: 0.0, stiffness: 2.0 * ratio / frequencies[0] }
            }
        }
    }

    /// The damping ratio, if there is one.
    pub(crate) fn ratio_mut(&mut self) -> Option<&mut f64> {
        match self {
            Self::None | Self::Local { .. } => None,
            Self::Rayleigh { ratio, .. } | Self::Mass { ratio, .. } | Self::Stiffness { ratio, .. } => {
                Some(ratio)
            }
        }
    }

    /// The damping ratio; `artanh(κ)/π` for local damping, 0 without damping.
    pub(crate) fn ratio(&self) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Local { coefficient } => coefficient.atanh() / std::f64::consts::PI,
            Self::Rayleigh { ratio, .. } | Self::Mass { ratio, .. } | Self::Stiffness { ratio, .. } => ratio,
        }
    }

    /// Coefficient κ of local damping, 0 for other kinds.
    pub(crate) fn local(&self) -> f64 {
        if let Self::Local { coefficient } = *self { coefficient } else { 0.0 }
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

    /// The ratio that limits the time step, if ω is the highest frequency and stiffness damping has the memory m:
    /// `ξ = α/2ω + (1 − m)/(1 + m) βω/2`.
    pub fn limiting_ratio(&self, frequency: f64, memory: f64) -> f64 {
        let felt = Self { stiffness: self.stiffness * (1.0 - memory) / (1.0 + memory), ..*self };
        felt.ratio_at(frequency)
    }

    /// Smallest memory m with which stiffness damping allows a time step of `share` times 2/ω, with the
    /// highest frequency ω (rad/s): `√(1 + ξ²) − ξ = share`, `ξ = (1 − m)/(1 + m) βω/2`; 0 if βω/2 is small
    /// enough without memory.
    pub fn memory_reaching(&self, share: f64, frequency: f64) -> f64 {
        let allowed = (1.0 - share * share) / (2.0 * share);
        let kept = allowed / (self.stiffness * frequency / 2.0);
        if kept < 1.0 { (1.0 - kept) / (1.0 + kept) } else { 0.0 }
    }
}

/// Share of the undamped limit 2/ω to which stiffness damping, in elements or in dashpots of contacts, may reduce the time step. With the usual safety
/// factor of 0.9 it is just above the largest step that a dam with cracks takes.
pub(crate) const DAMPED_SHARE: f64 = 0.3;

/// Coefficients of all damping that acts on a [`Structure`](crate::Structure).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DampingCoefficients {
    /// α and β, of elements and contacts.
    pub rayleigh: RayleighCoefficients,
    /// Memory m of stiffness damping, in [0, 1).
    pub memory: f64,
    /// Coefficient κ of local damping, in [0, 1).
    pub local: f64,
    /// Whether mass damping also drags blocks that slide or rock: `C = α M` instead of `α Pᵀ M P`.
    pub drags_blocks: bool,
}

impl DampingCoefficients {
    /// No damping.
    pub const NONE: Self = Self {
        rayleigh: RayleighCoefficients { mass: 0.0, stiffness: 0.0 },
        memory: 0.0,
        local: 0.0,
        drags_blocks: false,
    };

    /// Stiffness damping with its memory.
    pub fn stiffness(&self) -> StiffnessDamping {
        StiffnessDamping { coefficient: self.rayleigh.stiffness, memory: self.memory }
    }
}

/// Without memory and without local damping.
impl From<RayleighCoefficients> for DampingCoefficients {
    fn from(rayleigh: RayleighCoefficients) -> Self {
        Self { rayleigh, ..Self::default() }
    }
}

/// Stiffness damping with a memory m in [0, 1) from one time step to the next:
///
/// ```text
/// dⁿ = m dⁿ⁻¹ + (1 − m) β K vⁿ⁻½
/// ```
///
/// It applies to the damping stress of every element, and to the rates that act on the dashpots of closed
/// contacts. With time steps Δt this is a Maxwell element, `τ ḋ + d = β K v`, `τ = m Δt/(1 − m)`: a spring
/// β/τ times as stiff as the element in series with the dashpot. Elastic forces do not change. The damping
/// tends to `β K v` as Δt tends to 0. The memory increases the time step that damping allows by a factor of
/// up to (1 + m)/(1 − m) ([`CriticalTimeStep`](crate::CriticalTimeStep)).
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
