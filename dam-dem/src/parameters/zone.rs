use serde::{Deserialize, Serialize};

use crate::Material;
use crate::error::Problem;

/// Part of the section with a concrete of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZoneParameters {
    /// Its name.
    pub name: String,
    /// Its outline in either direction, m. What lies outside the section or in a gallery is no part of it.
    pub polygon: Vec<[f64; 2]>,
    /// Young's modulus E, Pa; `None` for that of the dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub young_modulus: Option<f64>,
    /// Poisson's ratio ν; `None` for that of the dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poisson_ratio: Option<f64>,
    /// Density ρ, kg/m³; `None` for that of the dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Tensile strength, Pa; `None` for that of the dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tensile_strength: Option<f64>,
}

impl ZoneParameters {
    /// Its material in a dam of the material `general`.
    pub fn material(&self, general: &Material) -> Material {
        Material {
            young_modulus: self.young_modulus.unwrap_or(general.young_modulus),
            poisson_ratio: self.poisson_ratio.unwrap_or(general.poisson_ratio),
            density: self.density.unwrap_or(general.density),
            plane: general.plane,
            tensile_strength: self.tensile_strength.or(general.tensile_strength),
        }
    }

    /// What is wrong with what the zone of that `index` has of its own.
    pub(super) fn problems(&self, index: usize, general: &Material) -> impl Iterator<Item = Problem> + use<> {
        let own = [
            ("young_modulus", self.young_modulus.is_some()),
            ("poisson_ratio", self.poisson_ratio.is_some()),
            ("density", self.density.is_some()),
            ("tensile_strength", self.tensile_strength.is_some()),
        ];
        let problems = self.material(general).problems_of(&format!("zones.{index}"));
        problems.filter(move |problem| {
            let has = |key: &String| own.iter().any(|(name, given)| *given && key.ends_with(name));
            problem.keys.iter().all(has)
        })
    }
}
