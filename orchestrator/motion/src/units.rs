use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Standard gravity, m/s².
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// Unit of the accelerations in the file of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Units {
    /// Standard gravity, 9.80665 m/s².
    #[default]
    #[serde(rename = "g")]
    Gravity,
    /// Metres per second squared.
    #[serde(rename = "m/s2")]
    Metres,
    /// Centimetres per second squared (gal).
    #[serde(rename = "cm/s2")]
    Centimetres,
}

impl Units {
    /// One of them, m/s².
    pub fn in_si(self) -> f64 {
        match self {
            Self::Gravity => STANDARD_GRAVITY,
            Self::Metres => 1.0,
            Self::Centimetres => 0.01,
        }
    }
}

impl std::fmt::Display for Units {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Gravity => "g",
            Self::Metres => "m/s²",
            Self::Centimetres => "cm/s²",
        })
    }
}
