use serde::{Deserialize, Serialize};

use super::fixed::Fixed;
use super::{LoadBasis, face};
use crate::error::{DamError, require};
use crate::{Mesh, Section};

/// A post-tensioned anchor, whose force does not change with the motion. It pulls its head towards its other end, and that end
/// towards the head if it lies in the dam; below the base it pulls at the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// Its head, a point of the dam, m.
    pub head: [f64; 2],
    /// Its other end, m.
    pub end: [f64; 2],
    /// Force, N per metre of dam: that of one anchor over the spacing of anchors.
    pub force: f64,
    /// Factor on it.
    pub factor: f64,
}

impl Fixed for Anchor {
    fn forces(&self, mesh: &Mesh, _: f64) -> Option<LoadBasis> {
        let [dx, dy] = [0, 1].map(|d| self.end[d] - self.head[d]);
        let pull = [dx, dy].map(|d| self.factor * self.force * d / dx.hypot(dy));
        let mut basis = face::at_point(mesh, self.head, pull)?;
        let reaction = face::at_point(mesh, self.end, pull.map(|force| -force));
        if reaction.is_none() && self.end[1] > 0.0 {
            return None;
        }
        basis.entries.extend(reaction.into_iter().flat_map(|basis| basis.entries));
        Some(basis)
    }

    fn check(&self, _: &Section) -> Result<(), DamError> {
        let [dx, dy] = [0, 1].map(|d| self.end[d] - self.head[d]);
        let length = dx.hypot(dy);
        for coordinate in self.head {
            require(coordinate.is_finite(), "head", coordinate, "finite")?;
        }
        require(length > 0.0 && length.is_finite(), "end", length, "a point other than the head")?;
        require(
            (0.0..f64::INFINITY).contains(&self.force),
            "force",
            self.force,
            "zero or positive, and finite",
        )?;
        require(self.factor >= 0.0, "factor", self.factor, "zero or positive")
    }
}
