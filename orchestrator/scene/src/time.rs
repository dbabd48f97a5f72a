//! `[time]`: the clock.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Time {
    /// Length H of a communication step. It is at most the interval of the record, best a whole fraction of it.
    #[schemars(range(min = 1e-5, max = 10), extend("unit" = "s"))]
    pub communication_step: f64,
    /// Time without ground motion after the record. Residual sliding needs 5 s.
    #[schemars(range(min = 0, max = 1e6), extend("unit" = "s"))]
    pub quiet: f64,
    /// Latest end of the run after the record. If it is set, the run ends as soon as the dam is at rest, but not before `quiet`
    /// and at least 5 s have passed; the water is prepared for this time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 5, max = 1e6), extend("unit" = "s", "otherwise" = "`quiet`, rest or not"))]
    pub longest_quiet: Option<f64>,
    /// Simulated time. After its last sample a record falls to zero within one interval. Required with a ramp.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(
        range(min = 0, max = 1e6),
        extend("unit" = "s", "otherwise" = "record + `longest_quiet` or `quiet`")
    )]
    pub duration: Option<f64>,
    /// Communication steps whose length follows the estimate of the coupling error, from `communication_step` on: for
    /// water without memory or water by recursion, in a scheme that exchanges pressure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<AdaptiveScene>,
}

impl Default for Time {
    fn default() -> Self {
        Self { communication_step: 0.0025, quiet: 5.0, longest_quiet: None, duration: None, adaptive: None }
    }
}

/// Communication steps of varying length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveScene {
    /// Largest estimate of the coupling error, as a share of the largest pressure.
    #[schemars(range(min = 1e-12, max = 1))]
    pub tolerance: f64,
    /// Shortest communication step.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0))]
    pub shortest: f64,
    /// Longest communication step, at most the interval of the record.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0))]
    pub longest: f64,
}
