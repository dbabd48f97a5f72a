//! `[ground_motion]`: what moves the ground.

use cofferdam_motion::{STRONGEST, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What moves the ground: either a record or a ramp.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroundMotionScene {
    /// A record from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordScene>,
    /// A ramp of acceleration that is then held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<RampScene>,
}

/// A record from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordScene {
    /// File of the record, relative to the scene's folder: `.csv` (time in s, acceleration, between them a comma, a tab or blanks;
    /// `#` begins a comment) or PEER `.at2`.
    pub file: PathBuf,
    /// Unit of the accelerations in the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the header's, or g"))]
    pub units: Option<Units>,
    /// SHA-256 of the file, in hexadecimal digits. It is recorded in the manifest of a run; a file with a different hash is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the file's"))]
    pub sha256: Option<String>,
    /// Factor on the acceleration.
    #[serde(default = "one")]
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub scale: f64,
    /// Direction of positive accelerations: 1 is downstream, -1 is upstream.
    #[serde(default = "downstream")]
    pub polarity: i64,
    /// Where in the record the run begins, counted from its first sample. This instant is time 0 of the results.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1e6), extend("unit" = "s"))]
    pub start: f64,
    /// Where in the record the motion ends, counted from its first sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "s", "otherwise" = "end of the record"))]
    pub end: Option<f64>,
}

/// A ramp of acceleration that is then held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampScene {
    /// Acceleration that is reached and held, positive downstream.
    #[schemars(range(min = -STRONGEST, max = STRONGEST), extend("unit" = "m/s²"))]
    pub acceleration: f64,
    /// Time in which it is reached.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0))]
    pub rise: f64,
}

fn one() -> f64 {
    1.0
}

fn downstream() -> i64 {
    1
}
