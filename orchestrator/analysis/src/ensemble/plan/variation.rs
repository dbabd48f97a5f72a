//! The values that a key of the scene takes.

use serde::Deserialize;
use statrs::distribution::{ContinuousCDF, Normal};
use toml::Value;

/// The values that a key takes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Variation {
    /// Each of them with all else.
    Values(Vec<Value>),
    /// Any between both, equally likely.
    Uniform {
        /// The smallest.
        from: f64,
        /// The largest.
        to: f64,
    },
    /// Normally distributed.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation.
        deviation: f64,
    },
    /// Its logarithm is normally distributed.
    Lognormal {
        /// The median.
        median: f64,
        /// The standard deviation of the logarithm.
        dispersion: f64,
    },
}

impl std::fmt::Display for Variation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Values(values) => {
                f.write_str(&values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
            }
            Self::Uniform { from, to } => write!(f, "uniform from {from} to {to}"),
            Self::Normal { mean, deviation } => {
                write!(f, "normal, mean {mean}, standard deviation {deviation}")
            }
            Self::Lognormal { median, dispersion } => {
                write!(f, "lognormal, median {median}, dispersion {dispersion}")
            }
        }
    }
}

impl Variation {
    /// The value below which a random one lies with this probability; none for a list.
    pub(super) fn at(&self, probability: f64) -> Option<f64> {
        let z = || Normal::standard().inverse_cdf(probability);
        match self {
            Self::Values(_) => None,
            Self::Uniform { from, to } => Some(from + probability * (to - from)),
            Self::Normal { mean, deviation } => Some(mean + deviation * z()),
            Self::Lognormal { median, dispersion } => Some(median * (dispersion * z()).exp()),
        }
    }

    /// Whether there is no value, or a spread that is none.
    pub(super) fn problem(&self) -> Option<&'static str> {
        match self {
            Self::Values(values) => values.is_empty().then_some("give at least one value"),
            Self::Uniform { from, to } => {
                (!(from < to && (to - from).is_finite())).then_some("`from` must be below `to`")
            }
            Self::Normal { mean, deviation } => {
                (!(mean.is_finite() && *deviation > 0.0 && deviation.is_finite()))
                    .then_some("`deviation` must be greater than 0")
            }
            Self::Lognormal { median, dispersion } => {
                let positive = |x: f64| x > 0.0 && x.is_finite();
                (!(positive(*median) && positive(*dispersion)))
                    .then_some("`median` and `dispersion` must be greater than 0")
            }
        }
    }
}
