//! `[stability]`: the combinations of loads and the criteria of `cofferdam stability`.

use cofferdam_dam::stability::{Authority, LoadCombination};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The combinations of loads and the criteria of `cofferdam stability` and the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StabilityScene {
    /// The authority whose factors are required.
    #[serde(default)]
    pub authority: Authority,
    /// Factors against sliding of your own, in place of those of the authority.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub required: Option<RequiredScene>,
    /// Inertia of dam and water in the combination `seismic`, as a share of g: downstream, and downwards.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "two thirds of the record's peak, and 0"))]
    pub seismic_coefficients: Option<[f64; 2]>,
    /// The combinations. By default these are `usual`; `unusual` with drains out of service, if there are drains; `seismic`; and
    /// `post-earthquake` with a joint that is cracked as the run left it, or altogether.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub combinations: Vec<CombinationScene>,
}

/// Required factors against sliding.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RequiredScene {
    /// Usual loads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 100), extend("otherwise" = "the authority's"))]
    pub usual: Option<f64>,
    /// Unusual loads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 100), extend("otherwise" = "the authority's"))]
    pub unusual: Option<f64>,
    /// Extreme loads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 100), extend("otherwise" = "the authority's"))]
    pub extreme: Option<f64>,
    /// During the earthquake.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 100), extend("otherwise" = "the authority's"))]
    pub seismic: Option<f64>,
    /// After the earthquake.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 100), extend("otherwise" = "the authority's"))]
    pub post_earthquake: Option<f64>,
}

impl RequiredScene {
    /// The factor for a combination.
    pub fn factor(&self, combination: LoadCombination) -> Option<f64> {
        match combination {
            LoadCombination::Usual => self.usual,
            LoadCombination::Unusual => self.unusual,
            LoadCombination::Extreme => self.extreme,
            LoadCombination::Seismic => self.seismic,
            LoadCombination::PostEarthquake => self.post_earthquake,
        }
    }
}

/// A combination of loads: those of the scene, with what is said here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CombinationScene {
    /// Its name in tables.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "that of its kind"))]
    pub name: Option<String>,
    /// Its kind, by which factors are required.
    pub kind: LoadCombination,
    /// Level of the reservoir above the heel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1e4), extend("unit" = "m", "otherwise" = "`reservoir.depth`"))]
    pub water_level: Option<f64>,
    /// Level of the tailwater above the toe.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1e4), extend("unit" = "m", "otherwise" = "that of the scene"))]
    pub tailwater_level: Option<f64>,
    /// Whether drains work.
    #[serde(default = "yes")]
    pub drains: bool,
    /// Whether there is ice.
    #[serde(default = "yes")]
    pub ice: bool,
}

fn yes() -> bool {
    true
}
