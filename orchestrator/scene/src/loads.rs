//! `[loads]`: static loads beside weight and water.

use super::Scene;
use cofferdam_dam::loads::{Anchor, Ice, Silt, StaticLoad, StillTailwater, Surcharge};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Static loads beside weight and water. They act from the state of rest on and do not change during the earthquake.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadsScene {
    /// Tailwater that exerts its hydrostatic pressure and does not move, in place of `[tailwater]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tailwater: Option<StillTailwaterScene>,
    /// Silt in front of the dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub silt: Option<SiltScene>,
    /// Thrust of an ice sheet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ice: Option<IceScene>,
    /// Post-tensioned anchors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub anchors: Vec<AnchorScene>,
    /// Other forces on the dam, such as those of a bridge, a gate or a fill.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surcharges: Vec<SurchargeScene>,
}

/// Tailwater at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StillTailwaterScene {
    /// Its depth at the toe.
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0))]
    pub depth: f64,
    /// Its density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 500, max = 2000), extend("unit" = "kg/m³", "otherwise" = "`reservoir.density`"))]
    pub density: Option<f64>,
}

/// Silt in front of the dam, as far as it presses more than the water in it: σ_v = ρ' g z on the horizontal and σ_h = K σ_v on the
/// vertical projection of the face, with Rankine's K = tan²(45° − φ/2). Its inertia is not modelled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SiltScene {
    /// Its depth at the heel.
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0))]
    pub depth: f64,
    /// Submerged density ρ', that of the saturated silt less that of water. USBR's fluid of 85 lb/ft³ with its water is 361 kg/m³.
    #[schemars(range(min = 1, max = 3000), extend("unit" = "kg/m³"))]
    pub submerged_density: f64,
    /// Friction angle φ; 0 for a fluid.
    #[serde(default)]
    #[schemars(range(min = 0, max = 89), extend("unit" = "°"))]
    pub friction_angle: f64,
    /// Factor on its pressure.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 10))]
    pub factor: f64,
}

/// Thrust of an ice sheet on the upstream side, horizontal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IceScene {
    /// Thrust, positive downstream. A common value is 146e3 N/m (10 kip/ft).
    #[schemars(range(min = 0, max = 1e8), extend("unit" = "N/m"))]
    pub force: f64,
    /// Where it acts: elevation above the heel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "otherwise" = "`reservoir.depth`"))]
    pub elevation: Option<f64>,
    /// Factor on it.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 10))]
    pub factor: f64,
}

/// A post-tensioned anchor, whose force does not change with the motion of the dam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnchorScene {
    /// Its head, a point of the dam.
    #[schemars(extend("unit" = "m"))]
    pub head: [f64; 2],
    /// Its other end, towards which it pulls the head: in the ground, or a point of the dam, which it pulls back.
    #[schemars(extend("unit" = "m"))]
    pub end: [f64; 2],
    /// Force per metre of dam: that of one anchor over the spacing of anchors.
    #[schemars(range(min = 0, max = 1e9), extend("unit" = "N/m"))]
    pub force: f64,
    /// Factor on it.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 10))]
    pub factor: f64,
}

/// A force on a point of the dam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurchargeScene {
    /// The point of the dam.
    #[schemars(extend("unit" = "m"))]
    pub point: [f64; 2],
    /// Its components downstream and upwards, per metre of dam.
    #[schemars(extend("unit" = "N/m"))]
    pub force: [f64; 2],
    /// Factor on it.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 10))]
    pub factor: f64,
}

fn one() -> f64 {
    1.0
}

impl Scene {
    /// The static loads as the dam has them, each with its key.
    pub fn static_loads(&self) -> Vec<(String, StaticLoad)> {
        let LoadsScene { tailwater, silt, ice, anchors, surcharges } = &self.loads;
        let mut loads = Vec::new();
        if let Some(StillTailwaterScene { depth, density }) = *tailwater {
            let density = density.unwrap_or(self.reservoir.density);
            loads.push((
                "loads.tailwater".to_owned(),
                StaticLoad::Tailwater(StillTailwater { depth, density }),
            ));
        }
        if let Some(SiltScene { depth, submerged_density, friction_angle, factor }) = *silt {
            let silt = Silt { depth, submerged_density, friction_angle, factor };
            loads.push(("loads.silt".to_owned(), StaticLoad::Silt(silt)));
        }
        if let Some(IceScene { force, elevation, factor }) = *ice {
            let elevation = elevation.unwrap_or(self.depth());
            loads.push(("loads.ice".to_owned(), StaticLoad::Ice(Ice { elevation, force, factor })));
        }
        for (index, &AnchorScene { head, end, force, factor }) in anchors.iter().enumerate() {
            let anchor = Anchor { head, end, force, factor };
            loads.push((format!("loads.anchors.{index}"), StaticLoad::Anchor(anchor)));
        }
        for (index, &SurchargeScene { point, force, factor }) in surcharges.iter().enumerate() {
            let surcharge = Surcharge { point, force, factor };
            loads.push((format!("loads.surcharges.{index}"), StaticLoad::Surcharge(surcharge)));
        }
        loads
    }
}
