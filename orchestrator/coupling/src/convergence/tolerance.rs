use super::IterationInfo;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How small a residual has to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Written", into = "Written")]
pub enum Tolerance {
    /// ε, dimensionless: a share of the norm of the values.
    Relative(f64),
    /// A tenth of the error e of values that are linear within the step, between bounds:
    /// `‖r‖₂ ≤ min(max(e/10, 3·10⁻⁴ P), 10⁻² P)`, P the largest ‖p‖₂ so far or, if that is larger, the expected one. Other
    /// measures have ε = 3·10⁻⁴.
    #[default]
    Balanced,
}

/// Share of the step's own error that a balanced residual may have.
const SHARE: f64 = 0.1;

/// Least and largest balanced residual over the largest pressure.
const BOUNDS: [f64; 2] = [3e-4, 1e-2];

impl Tolerance {
    /// ε where a share of something is needed that has no error of its own.
    pub fn relative(self) -> f64 {
        match self {
            Self::Relative(tolerance) => tolerance,
            Self::Balanced => BOUNDS[0],
        }
    }

    /// Largest residual of values whose norm is `values`.
    pub(super) fn allowed(self, values: f64, known: IterationInfo) -> f64 {
        match self {
            Self::Relative(tolerance) => tolerance * values,
            Self::Balanced => {
                let [least, most] = BOUNDS.map(|bound| bound * known.largest.max(values));
                (SHARE * known.step_error.unwrap_or(0.0)).max(least).min(most)
            }
        }
    }

    /// The residual that is always allowed, over a typical value.
    pub(super) fn floor(self) -> f64 {
        match self {
            Self::Relative(tolerance) => 0.01 * tolerance,
            // Small motion is as accurate as large one.
            Self::Balanced => 1e-8,
        }
    }
}

impl From<f64> for Tolerance {
    fn from(tolerance: f64) -> Self {
        Self::Relative(tolerance)
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Relative(tolerance) => write!(f, "{tolerance:e}"),
            Self::Balanced => write!(f, "balanced"),
        }
    }
}

/// A tolerance as a scene has it.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum Written {
    Number(#[cfg_attr(feature = "schema", schemars(range(min = 1e-14, max = 0.1)))] f64),
    Word(Word),
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum Word {
    /// A tenth of the error that the step has because values are taken as linear within it; at least 3e-4 and
    /// at most 1e-2 of the largest pressure so far.
    Balanced,
}

impl From<Written> for Tolerance {
    fn from(written: Written) -> Self {
        match written {
            Written::Number(tolerance) => Self::Relative(tolerance),
            Written::Word(Word::Balanced) => Self::Balanced,
        }
    }
}

impl From<Tolerance> for Written {
    fn from(tolerance: Tolerance) -> Self {
        match tolerance {
            Tolerance::Relative(tolerance) => Self::Number(tolerance),
            Tolerance::Balanced => Self::Word(Word::Balanced),
        }
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Tolerance {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Tolerance".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        Written::json_schema(generator)
    }
}
