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
    /// The vertical component of the record. Without it a record moves the ground horizontally only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical: Option<VerticalScene>,
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
    /// Column of the horizontal acceleration in a `.csv` with several, counted from 1 after the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000), extend("otherwise" = "the only one, or 1 next to a vertical column"))]
    pub column: Option<usize>,
    /// Unit of the accelerations in the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the header's, or g"))]
    pub units: Option<Units>,
    /// SHA-256 of the file, in hexadecimal digits. It is recorded in the manifest of a run; a file with a different hash is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the file's"))]
    pub sha256: Option<String>,
    /// Factor on the acceleration, also on the vertical one.
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

/// The vertical component of the record. It has the clock of the horizontal one: `start` and `end` apply to both. Its samples may have
/// another interval; before and after them it is 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VerticalScene {
    /// File of the vertical component, of the same kinds as that of the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "that of the record; then `column` is required"))]
    pub file: Option<PathBuf>,
    /// Column of the vertical acceleration in a `.csv` with several, counted from 1 after the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000), extend("otherwise" = "the only one"))]
    pub column: Option<usize>,
    /// Unit of the accelerations in the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the header's, or g; in the file of the record as `ground_motion.record.units`"))]
    pub units: Option<Units>,
    /// SHA-256 of the file, in hexadecimal digits. It is recorded in the manifest of a run; a file with a different hash is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the file's"))]
    pub sha256: Option<String>,
    /// Factor on the vertical acceleration, in addition to `ground_motion.record.scale`.
    #[serde(default = "one")]
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub scale: f64,
    /// Direction of positive accelerations: 1 is up, -1 is down.
    #[serde(default = "upwards")]
    pub polarity: i64,
}

/// A ramp of acceleration that is then held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampScene {
    /// Acceleration that is reached and held, positive downstream.
    #[schemars(range(min = -STRONGEST, max = STRONGEST), extend("unit" = "m/s²"))]
    pub acceleration: f64,
    /// Vertical acceleration that is reached and held, positive upwards.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -STRONGEST, max = STRONGEST), extend("unit" = "m/s²", "otherwise" = "0"))]
    pub vertical_acceleration: f64,
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

fn upwards() -> i64 {
    1
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl GroundMotionScene {
    /// Whether the ground moves vertically, too.
    pub fn has_vertical(&self) -> bool {
        self.vertical.is_some() || self.ramp.as_ref().is_some_and(|ramp| ramp.vertical_acceleration != 0.0)
    }

    /// Whether both components are in the file of the record.
    pub fn shares_file(&self) -> bool {
        self.vertical.as_ref().is_some_and(|vertical| vertical.file.is_none())
    }
}
