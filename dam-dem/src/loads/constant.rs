use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::fixed::Fixed;
use super::{Acting, Load, LoadBasis};
use crate::error::{DamError, Problem};
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

impl StaticLoad {
    fn get(&self) -> &dyn Fixed {
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

    /// The parameter that says where it acts.
    pub(crate) fn point_key(&self) -> &'static str {
        match self {
            Self::Tailwater(_) | Self::Silt(_) => "depth",
            Self::Ice(_) => "elevation",
            Self::Anchor(_) => "head",
            Self::Surcharge(_) => "point",
        }
    }

    /// What is wrong with the load of that `index`.
    pub(crate) fn problem(&self, index: usize, section: &Section) -> Option<Problem> {
        let error = self.get().check(section).err()?;
        let key = error.parameter().unwrap_or_else(|| self.point_key());
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
