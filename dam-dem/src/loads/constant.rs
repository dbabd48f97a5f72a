use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::face::{self, Side};
use super::{Acting, Load, LoadBasis};
use crate::error::{DamError, Problem, require};
use crate::{Mesh, Section};

/// A load that does not vary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StaticLoad {
    /// Tailwater.
    Tailwater(super::StillTailwater),
    /// Silt in front of the dam.
    Silt(super::Silt),
    /// Ice on the reservoir.
    Ice(super::Ice),
    /// A post-tensioned anchor.
    Anchor(super::Anchor),
    /// A force on the dam.
    Surcharge(super::Surcharge),
}

/// What makes the nodal forces of a static load.
pub(super) trait Static {
    /// Its nodal forces under `gravity` (m/s²); `None` where a point of it lies outside the dam.
    fn forces(&self, mesh: &Mesh, gravity: f64) -> Option<LoadBasis>;

    /// What is wrong with it in a dam of this `section`: the key within its table, and the mistake.
    fn check(&self, section: &Section) -> Result<(), DamError>;
}

impl StaticLoad {
    fn get(&self) -> &dyn Static {
        match self {
            Self::Tailwater(load) => load,
            Self::Silt(load) => load,
            Self::Ice(load) => load,
            Self::Anchor(load) => load,
            Self::Surcharge(load) => load,
        }
    }

    /// Its word in scenes.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Tailwater(_) => "tailwater",
            Self::Silt(_) => "silt",
            Self::Ice(_) => "ice",
            Self::Anchor(_) => "anchor",
            Self::Surcharge(_) => "surcharge",
        }
    }

    /// What is wrong with the load of that `index`.
    pub(crate) fn problem(&self, index: usize, section: &Section) -> Option<Problem> {
        let error = self.get().check(section).err()?;
        let key = error.parameter().unwrap_or("point");
        Some(Problem { keys: vec![format!("static_loads.{index}.{key}")], error })
    }
}

/// Nodal forces that do not vary; their amplitude is 1.
#[derive(Debug)]
pub(crate) struct Constant(LoadBasis);

impl Constant {
    /// Those of a `load` on a `mesh` under `gravity` (m/s²).
    ///
    /// **Errors**: [`DamError::PointOutside`].
    pub fn new(load: &StaticLoad, mesh: &Mesh, gravity: f64) -> Result<Self, DamError> {
        let forces = load.get().forces(mesh, gravity);
        forces.map(Self).ok_or(DamError::PointOutside { load: load.word() })
    }

    /// Its nodal forces.
    pub fn nodal(&self) -> &LoadBasis {
        &self.0
    }
}

impl Load for Constant {
    fn basis(&self) -> &LoadBasis {
        &self.0
    }

    fn amplitudes<'a>(&'a self, _: &'a Acting) -> Cow<'a, [f64]> {
        Cow::Borrowed(&[1.0])
    }

    fn at_rest(&self) -> Vec<Vec<f64>> {
        vec![vec![1.0]]
    }
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
