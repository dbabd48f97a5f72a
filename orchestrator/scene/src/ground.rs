//! `[ground_motion]`: what moves the ground.

use cofferdam_motion::{STRONGEST, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

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
    /// Further shocks, such as aftershocks, in their order after the record. Each begins after a rest with still ground, in the state in
    /// which the shock before left dam and water. Every shock has its own `scale`. Where the intervals of the records differ, the
    /// motion has the longest interval that divides all of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sequence: Vec<ShockScene>,
}

/// A shock after the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShockScene {
    /// Name of the shock in results.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "`shock 2` and so on; the record is `shock 1`"))]
    pub name: Option<String>,
    /// Time with still ground before this shock, rounded up to whole intervals of the motion. The residual sliding after the shock
    /// before needs 5 s.
    #[serde(default = "rest")]
    #[schemars(range(min = 0, max = 1000), extend("unit" = "s"))]
    pub rest: f64,
    /// Its record.
    #[serde(flatten)]
    pub record: RecordScene,
    /// Its vertical component. Without it the shock moves the ground horizontally only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("like" = "ground_motion.vertical"))]
    pub vertical: Option<VerticalScene>,
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
    /// Where in the record its motion begins, counted from its first sample. For the first record this is time 0 of the results.
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
    #[schemars(extend("otherwise" = "the header's, or g; in the file of the record as its `units`"))]
    pub units: Option<Units>,
    /// SHA-256 of the file, in hexadecimal digits. It is recorded in the manifest of a run; a file with a different hash is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the file's"))]
    pub sha256: Option<String>,
    /// Factor on the vertical acceleration, in addition to the `scale` of the record.
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

fn rest() -> f64 {
    10.0
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// A record of the ground motion, with what belongs to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shock<'a> {
    /// What results call it.
    pub label: String,
    /// Key of its table, such as `ground_motion.record`.
    pub table: String,
    /// The record.
    pub record: &'a RecordScene,
    /// Its vertical component.
    pub vertical: Option<&'a VerticalScene>,
    /// Key of the vertical component's table.
    pub vertical_table: String,
    /// Time with still ground before it, s.
    pub rest: f64,
}

impl Shock<'_> {
    /// Whether both components are in the file of the record.
    pub fn shares_file(&self) -> bool {
        self.vertical.is_some_and(|vertical| vertical.file.is_none())
    }

    /// Name of the file of the record.
    pub fn file_name(&self) -> String {
        name_of(&self.record.file)
    }

    /// Name of the file of the vertical component, if there is one.
    pub fn vertical_file_name(&self) -> Option<String> {
        self.vertical.map(|vertical| name_of(vertical.file.as_ref().unwrap_or(&self.record.file)))
    }
}

fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

impl GroundMotionScene {
    /// Whether the ground moves vertically, too.
    pub fn has_vertical(&self) -> bool {
        self.shocks().iter().any(|shock| shock.vertical.is_some())
            || self.ramp.as_ref().is_some_and(|ramp| ramp.vertical_acceleration != 0.0)
    }

    /// The record and those of the sequence after it, in their order; none for a ramp.
    pub fn shocks(&self) -> Vec<Shock<'_>> {
        let first = self.record.iter().map(|record| Shock {
            label: "shock 1".to_owned(),
            table: "ground_motion.record".to_owned(),
            record,
            vertical: self.vertical.as_ref(),
            vertical_table: "ground_motion.vertical".to_owned(),
            rest: 0.0,
        });
        let further = self.sequence.iter().enumerate().map(|(index, shock)| Shock {
            label: shock.name.clone().unwrap_or_else(|| format!("shock {}", index + 2)),
            table: format!("ground_motion.sequence.{index}"),
            record: &shock.record,
            vertical: shock.vertical.as_ref(),
            vertical_table: format!("ground_motion.sequence.{index}.vertical"),
            rest: shock.rest,
        });
        first.chain(further).collect()
    }

    /// The records and vertical components of all shocks, in the order of [`shocks`](Self::shocks).
    pub fn shocks_mut(&mut self) -> impl Iterator<Item = (&mut RecordScene, Option<&mut VerticalScene>)> {
        let first = self.record.iter_mut().zip(std::iter::once(self.vertical.as_mut()));
        let further = self.sequence.iter_mut().map(|shock| (&mut shock.record, shock.vertical.as_mut()));
        first.chain(further)
    }

    /// The files of all records.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        self.shocks_mut().flat_map(|(record, vertical)| {
            std::iter::once(&mut record.file).chain(vertical.and_then(|vertical| vertical.file.as_mut()))
        })
    }

    /// Settings, as of `--set`, that multiply the motion of all shocks by `factor`.
    pub fn scaled(&self, factor: f64) -> Vec<String> {
        let set = |shock: Shock<'_>| format!("{}.scale={}", shock.table, factor * shock.record.scale);
        self.shocks().into_iter().map(set).collect()
    }
}
