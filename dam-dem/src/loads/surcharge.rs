use serde::{Deserialize, Serialize};

use super::fixed::Fixed;
use super::{LoadBasis, face};
use crate::error::{DamError, require};
use crate::{Mesh, Section};

/// A force on the dam, such as that of a bridge, a gate, or a fill at its toe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surcharge {
    /// The point of the dam on which it acts, m.
    pub point: [f64; 2],
    /// Its components along x (downstream) and y (up), N per metre of dam.
    pub force: [f64; 2],
    /// Factor on it.
    pub factor: f64,
}

impl Fixed for Surcharge {
    fn forces(&self, mesh: &Mesh, _: f64) -> Option<LoadBasis> {
        face::at_point(mesh, self.point, self.force.map(|force| self.factor * force))
    }

    fn check(&self, _: &Section) -> Result<(), DamError> {
        for coordinate in self.point {
            require(coordinate.is_finite(), "point", coordinate, "finite")?;
        }
        for force in self.force {
            require(force.is_finite(), "force", force, "finite")?;
        }
        require(self.factor >= 0.0, "factor", self.factor, "zero or positive")
    }
}
