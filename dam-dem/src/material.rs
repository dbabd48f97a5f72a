//! Isotropic linear elastic concrete.

use serde::{Deserialize, Serialize};

use crate::Mesh;
use crate::error::{Problem, require};

/// Plane condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Plane {
    /// Plane stress.
    #[default]
    Stress,
    /// Plane strain.
    Strain,
}

impl Plane {
    /// Both conditions, in the order of the enum.
    pub const ALL: [Self; 2] = [Self::Stress, Self::Strain];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Stress => "stress",
            Self::Strain => "strain",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Stress => "plane stress",
            Self::Strain => "plane strain",
        }
    }
}

/// Elastic constants and density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E, Pa.
    pub young_modulus: f64,
    /// Poisson's ratio ν, in (−1, 0.5).
    pub poisson_ratio: f64,
    /// Density ρ, kg/m³.
    pub density: f64,
    /// Plane stress, `σ_zz = 0`, or plane strain, `ε_zz = 0`.
    pub plane: Plane,
    /// Tensile strength, Pa, with which stresses are compared; `None` for no comparison. The concrete does not crack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tensile_strength: Option<f64>,
}

/// The concrete of Koyna Dam: E = 31 GPa, ν = 0.2, 2640 kg/m³, in plane stress, without a tensile strength.
impl Default for Material {
    fn default() -> Self {
        Self {
            young_modulus: 31e9,
            poisson_ratio: 0.2,
            density: 2640.0,
            plane: Plane::default(),
            tensile_strength: None,
        }
    }
}

impl Material {
    /// What is wrong: E, ρ and the tensile strength must be positive, ν in (−1, 0.5).
    pub(crate) fn problems(&self) -> impl Iterator<Item = Problem> + use<> {
        self.problems_of("material")
    }

    /// The same of the material at the key `table`.
    pub(crate) fn problems_of(&self, table: &str) -> impl Iterator<Item = Problem> + use<> {
        let table = table.to_owned();
        let nu = self.poisson_ratio;
        // No strength is nothing wrong.
        let strength = self.tensile_strength.unwrap_or(1.0);
        let checks = [
            (
                "young_modulus",
                require(self.young_modulus > 0.0, "young_modulus", self.young_modulus, "positive"),
            ),
            (
                "poisson_ratio",
                require(nu > -1.0 && nu < 0.5, "poisson_ratio", nu, "between -1 and 0.5, both excluded"),
            ),
            ("density", require(self.density > 0.0, "density", self.density, "positive")),
            ("tensile_strength", require(strength > 0.0, "tensile_strength", strength, "positive")),
        ];
        checks
            .into_iter()
            .filter_map(move |(key, check)| Some(Problem::of([&format!("{table}.{key}")], check.err()?)))
    }

    /// Shear modulus `G = E / 2(1+ν)`, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))
    }

    /// λ of `σ = λ tr(ε) I + 2G ε` in the plane, Pa: `Eν/(1−ν²)` in plane stress,
    /// `Eν/((1+ν)(1−2ν))` in plane strain.
    pub fn plane_lambda(&self) -> f64 {
        let (e, nu) = (self.young_modulus, self.poisson_ratio);
        match self.plane {
            Plane::Stress => e * nu / (1.0 - nu * nu),
            Plane::Strain => e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        }
    }
}

/// The materials of a dam.
#[derive(Clone, Debug, PartialEq)]
pub struct Materials {
    /// Where no zone is.
    pub general: Material,
    /// One for each zone.
    pub of_zones: Vec<Material>,
}

impl From<&Material> for Materials {
    fn from(material: &Material) -> Self {
        Self { general: *material, of_zones: Vec::new() }
    }
}

impl Materials {
    /// Tensile strength in a zone, Pa.
    pub(crate) fn tensile_strength(&self, zone: Option<usize>) -> Option<f64> {
        zone.and_then(|zone| self.of_zones.get(zone)).unwrap_or(&self.general).tensile_strength
    }

    /// The material of a cell.
    pub fn of_cell(&self, mesh: &Mesh, cell: usize) -> &Material {
        mesh.zone_of(cell).and_then(|zone| self.of_zones.get(zone)).unwrap_or(&self.general)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for plane in Plane::ALL {
            assert_eq!(serde_json::to_value(plane).unwrap(), plane.word());
        }
    }

    #[test]
    fn uniaxial_stress_gives_youngs_modulus() {
        let material = Material::default();
        let (lambda, g) = (material.plane_lambda(), material.shear_modulus());
        let (e11, e22) = (1e-4, -0.2e-4);
        assert!((lambda * (e11 + e22) + 2.0 * g * e22).abs() < 1e-9 * 31e5);
        assert!(((lambda * (e11 + e22) + 2.0 * g * e11) / 31e5 - 1.0).abs() < 1e-14);
    }
}
