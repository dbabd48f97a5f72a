use super::LoadBasis;
use super::face::{self, Side};
use crate::error::{DamError, require};
use crate::{Mesh, Section};

/// What makes the nodal forces of a static load.
pub(super) trait Fixed {
    /// Its nodal forces under `gravity` (m/s²); `None` where a point of it lies outside the dam.
    fn forces(&self, mesh: &Mesh, gravity: f64) -> Option<LoadBasis>;

    /// What is wrong with it in a dam of this `section`.
    fn check(&self, section: &Section) -> Result<(), DamError>;
}

/// Refuses a level that is not on a side of the dam.
pub(super) fn check_level(name: &'static str, level: f64, side: &[[f64; 2]]) -> Result<(), DamError> {
    let crest = side.last().map_or(0.0, |point| point[1]);
    require(level > 0.0 && level <= crest, name, level, "above the base and not above the crest")
}

/// Nodal forces of silt or water up to a `level` on the upstream side (see [`face::of_depth`]).
pub(super) fn upstream(mesh: &Mesh, level: f64, weights: [f64; 2]) -> LoadBasis {
    face::of_depth(mesh, Side::Upstream, level, weights)
}

/// The same downstream.
pub(super) fn downstream(mesh: &Mesh, level: f64, weights: [f64; 2]) -> LoadBasis {
    face::of_depth(mesh, Side::Downstream, level, weights)
}
