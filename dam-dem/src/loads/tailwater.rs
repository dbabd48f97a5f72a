use serde::{Deserialize, Serialize};

use super::LoadBasis;
use super::fixed::{Fixed, check_level, downstream};
use crate::error::{DamError, require};
use crate::{Mesh, Section};

/// Tailwater that exerts its hydrostatic pressure and does not move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StillTailwater {
    /// Its depth at the toe, m.
    pub depth: f64,
    /// Its density, kg/m³.
    pub density: f64,
}

impl Fixed for StillTailwater {
    fn forces(&self, mesh: &Mesh, gravity: f64) -> Option<LoadBasis> {
        Some(downstream(mesh, self.depth, [self.density * gravity; 2]))
    }

    fn check(&self, section: &Section) -> Result<(), DamError> {
        check_level("depth", self.depth, &section.downstream)?;
        require(self.density > 0.0, "density", self.density, "positive")
    }
}
