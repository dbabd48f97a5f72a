use serde::{Deserialize, Serialize};

use super::LoadBasis;
use super::fixed::{Fixed, check_level, upstream};
use crate::error::{DamError, require};
use crate::{Mesh, Section};

/// Silt in front of the dam, as far as it presses more than the water in it.
///
/// ```text
/// σ_v = ρ' g z    σ_h = K σ_v    K = tan²(45° − φ/2)
/// ```
///
/// z is the depth below the silt's surface. Its inertia during shaking is not modelled.
///
/// **Source**: W.J.M. Rankine, *On the stability of loose earth*, 1857.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Silt {
    /// Depth of the silt at the heel, m.
    pub depth: f64,
    /// Submerged density ρ': that of the saturated silt less that of water, kg/m³.
    pub submerged_density: f64,
    /// Friction angle φ, degrees; 0 for a fluid.
    pub friction_angle: f64,
    /// Factor on its pressure.
    pub factor: f64,
}

impl Silt {
    /// Coefficient K of horizontal pressure.
    pub fn pressure_coefficient(&self) -> f64 {
        (45.0 - self.friction_angle / 2.0).to_radians().tan().powi(2)
    }
}

impl Fixed for Silt {
    fn forces(&self, mesh: &Mesh, gravity: f64) -> Option<LoadBasis> {
        let vertical = self.factor * self.submerged_density * gravity;
        Some(upstream(mesh, self.depth, [self.pressure_coefficient() * vertical, vertical]))
    }

    fn check(&self, section: &Section) -> Result<(), DamError> {
        check_level("depth", self.depth, &section.upstream)?;
        let angle = self.friction_angle;
        require(self.submerged_density > 0.0, "submerged_density", self.submerged_density, "positive")?;
        require((0.0..90.0).contains(&angle), "friction_angle", angle, "in degrees, from 0 to below 90")?;
        require(self.factor >= 0.0, "factor", self.factor, "zero or positive")
    }
}
