//! `[accuracy]`, `[[stop]]`, `[snapshots]` and `[log]`: what is watched and kept of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The accuracy that a run chooses its numerics for, as shares: `accuracy = { crest = 0.02, sliding = 0.2 }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AccuracyScene {
    /// Largest error of the crest's two peaks, over the larger one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-4, max = 1), extend("otherwise" = "not asked for"))]
    pub crest: Option<f64>,
    /// Largest error of the crest's displacement at any instant, over its peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-4, max = 1), extend("otherwise" = "not asked for"))]
    pub history: Option<f64>,
    /// Largest error of any crack's residual sliding, over the largest of all cracks, 1 mm at least.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-4, max = 1), extend("otherwise" = "not asked for"))]
    pub sliding: Option<f64>,
}

/// Pictures of the dam's fields and of the pressure in the water during the run: `snapshots.pvd`, for ParaView.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnapshotsScene {
    /// Time from one picture to the next. A picture is made at each multiple, or at the first end of a step (of a window of
    /// steps) after it.
    #[schemars(range(min = 1e-6, max = 1e6), extend("unit" = "s"))]
    pub interval: f64,
    /// No picture before this time.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1e6), extend("unit" = "s"))]
    pub from: f64,
    /// No picture after this time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1e6), extend("unit" = "s", "otherwise" = "no end"))]
    pub until: Option<f64>,
    /// Whether the pictures include the pressure in the water, up to two depths from the dam; only for built-in reservoirs that
    /// have a pressure field.
    #[serde(default = "SnapshotsScene::with_water")]
    pub water: bool,
}

impl SnapshotsScene {
    fn with_water() -> bool {
        true
    }
}

/// A limit that ends a run before its time, or marks it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopScene {
    /// Quantity that is watched, at every communication point.
    pub quantity: StopQuantity,
    /// Magnitude that is too much, in the quantity's SI unit.
    #[schemars(extend("unit" = "m, rad, 1", "exclusiveMinimum" = 0))]
    pub above: f64,
    /// What is done then.
    #[serde(default)]
    pub action: StopAction,
}

/// A quantity that a run is watched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StopQuantity {
    /// Sliding of any crack, m.
    Sliding,
    /// Opening of any crack, m.
    Opening,
    /// Rotation above any crack, rad.
    Rotation,
    /// Displacement of the crest, m.
    CrestDisplacement,
    /// Iterations of a communication step.
    Iterations,
    /// Energy balance error over the peak kinetic energy so far.
    EnergyError,
}

impl StopQuantity {
    /// The word for it in messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::Opening => "opening",
            Self::Rotation => "rotation",
            Self::CrestDisplacement => "crest displacement",
            Self::Iterations => "iterations",
            Self::EnergyError => "energy error",
        }
    }

    /// Its unit, with a space before it.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Sliding | Self::Opening | Self::CrestDisplacement => " m",
            Self::Rotation => " rad",
            Self::Iterations | Self::EnergyError => "",
        }
    }

    /// The dam's output that tells it.
    pub fn variable(self) -> Option<&'static str> {
        match self {
            Self::Sliding => Some("crack_sliding"),
            Self::Opening => Some("crack_opening"),
            Self::Rotation => Some("crack_rotation"),
            Self::CrestDisplacement => Some("crest_displacement"),
            Self::EnergyError => Some("energy_balance_error"),
            Self::Iterations => None,
        }
    }
}

/// What is done when a quantity is too much.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StopAction {
    /// The run ends after this communication step; its status says so.
    #[default]
    End,
    /// The run continues; its results say so.
    Flag,
}
