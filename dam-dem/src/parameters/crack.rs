use cofferdam_unit::mean_elevation;
use serde::{Deserialize, Serialize};

use super::is_default;
use crate::contact::Integration;
use crate::error::{Problem, require};
use crate::uplift::Uplift;

/// Where a crack runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CrackLine {
    /// Horizontally through the whole section, at this elevation above the base, m; 0 for the joint between dam and ground.
    #[serde(rename = "elevation")]
    Level(f64),
    /// Through these points, m. What lies outside the section is no crack.
    #[serde(rename = "polyline")]
    Polyline(Vec<[f64; 2]>),
}

impl CrackLine {
    /// Mean elevation over its length, m.
    pub fn elevation(&self) -> f64 {
        match self {
            Self::Level(elevation) => *elevation,
            Self::Polyline(points) => mean_elevation(points),
        }
    }

    /// The name of its parameter.
    pub(super) fn key(&self) -> &'static str {
        match self {
            Self::Level(_) => "elevation",
            Self::Polyline(_) => "polyline",
        }
    }
}

/// A crack from face to face, or to a gallery or another crack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrackParameters {
    /// Where it runs.
    #[serde(flatten)]
    pub line: CrackLine,
    /// Coulomb's friction coefficient μ, of a bonded crack its peak.
    pub friction_coefficient: f64,
    /// The same once the crack has slipped or opened; `None` for no other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_friction_coefficient: Option<f64>,
    /// Cohesion of the bond, Pa.
    #[serde(default, skip_serializing_if = "is_default")]
    pub cohesion: f64,
    /// Tensile strength of the bond, Pa.
    #[serde(default, skip_serializing_if = "is_default")]
    pub tensile_strength: f64,
    /// tan ψ: rise over slip.
    #[serde(default, skip_serializing_if = "is_default")]
    pub dilation: f64,
    /// Slip, to and fro, after which nothing rises any more, m; `None` for never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dilation_slip: Option<f64>,
    /// Length of an element's side along it, m; `None` for that of the dam. With it the mesh is not one of rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element_size: Option<f64>,
    /// Where its contacts are.
    #[serde(default, skip_serializing_if = "is_default")]
    pub integration: Integration,
    /// Normal stiffness k_n, Pa/m.
    pub normal_stiffness: f64,
    /// Shear stiffness k_s, Pa/m.
    pub shear_stiffness: f64,
    /// Pressure of the water in it; `None` for no water.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uplift: Option<Uplift>,
}

/// The crack at the neck of Koyna Dam, at 66.5 m: friction coefficient 1, stiffnesses of 1e11 and 0.5e11 Pa/m, not bonded.
impl Default for CrackParameters {
    fn default() -> Self {
        Self::sliding(66.5, 1.0, 1e11, 0.5e11)
    }
}

impl CrackParameters {
    /// Whether its contacts are bonded before they slide or open.
    pub fn is_bonded(&self) -> bool {
        let weakens = self.residual_friction_coefficient.is_some_and(|mu| mu < self.friction_coefficient);
        self.cohesion > 0.0 || self.tensile_strength > 0.0 || weakens
    }

    /// Compares mean elevations.
    pub fn from_the_base_up(a: &Self, b: &Self) -> std::cmp::Ordering {
        a.line.elevation().total_cmp(&b.line.elevation())
    }

    /// A horizontal crack that slides by Coulomb's friction, not bonded.
    pub fn sliding(
        elevation: f64,
        friction_coefficient: f64,
        normal_stiffness: f64,
        shear_stiffness: f64,
    ) -> Self {
        Self {
            line: CrackLine::Level(elevation),
            friction_coefficient,
            residual_friction_coefficient: None,
            cohesion: 0.0,
            tensile_strength: 0.0,
            dilation: 0.0,
            dilation_slip: None,
            element_size: None,
            integration: Integration::Nodal,
            normal_stiffness,
            shear_stiffness,
            uplift: None,
        }
    }
}

impl CrackParameters {
    /// What is wrong with the crack of that `index` by itself.
    pub(super) fn problems(&self, index: usize) -> impl Iterator<Item = Problem> {
        let mu = self.friction_coefficient;
        let residual = self.residual_friction_coefficient.unwrap_or(mu);
        let positive = |value: f64| value >= 0.0;
        let checks = [
            require(mu >= 0.0, "friction_coefficient", mu, "zero or positive"),
            require(self.normal_stiffness > 0.0, "normal_stiffness", self.normal_stiffness, "positive"),
            require(self.shear_stiffness > 0.0, "shear_stiffness", self.shear_stiffness, "positive"),
            require(
                (0.0..=mu).contains(&residual),
                "residual_friction_coefficient",
                residual,
                "zero or more, and no more than the friction coefficient",
            ),
            require(positive(self.cohesion), "cohesion", self.cohesion, "zero or positive"),
            require(
                positive(self.tensile_strength),
                "tensile_strength",
                self.tensile_strength,
                "zero or positive",
            ),
            require(positive(self.dilation), "dilation", self.dilation, "zero or positive"),
            require(
                positive(self.dilation_slip.unwrap_or(0.0)),
                "dilation_slip",
                self.dilation_slip.unwrap_or(0.0),
                "zero or positive",
            ),
        ];
        checks.into_iter().filter_map(move |check| {
            let error = check.err()?;
            let mut keys = vec![format!("cracks.{index}.{}", error.parameter()?)];
            if keys[0].ends_with("residual_friction_coefficient") {
                keys.push(format!("cracks.{index}.friction_coefficient"));
            }
            Some(Problem { keys, error })
        })
    }
}
