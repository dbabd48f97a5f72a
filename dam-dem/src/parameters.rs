use interface::variables::dam as variables;
use interface::{Variable, WetFace};
use serde::{Deserialize, Serialize};

use crate::contact::Integration;
use crate::error::{DamError, require};
use crate::loads::Wet;
use crate::{Damping, Fidelity, Material, Mesh};

/// Everything a dam is made from. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DamParameters {
    /// Outline of the cross-section.
    pub section: Section,
    /// Depth of the water at the heel, m; 0 means an empty reservoir and no wet face.
    pub water_depth: f64,
    /// Horizontal cracks through the whole section, in any order. Results come from the base up.
    pub cracks: Vec<CrackParameters>,
    /// The concrete.
    pub material: Material,
    /// Damping of concrete and contacts.
    pub damping: Damping,
    /// How much of the physics is computed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub fidelity: Fidelity,
    /// Small strain, or corotational with finite rotations; modes know small rotations only.
    pub kinematics: Kinematics,
    /// Nominal length of an element's side, m.
    pub element_size: f64,
    /// Gravitational acceleration g, m/s².
    pub gravity: f64,
    /// Time step over the longest stable one, in (0, 1].
    pub time_step_safety: f64,
    /// Added mass of water without memory, rows of points × points, Pa per m/s²: it becomes part of the mass
    /// matrix ([`AddedMass`](crate::AddedMass)), and `interface_pressure` what acts beside it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<Vec<Vec<f64>>>,
}

/// Outline of a cross-section by its two sides, each from base to crest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Vertices of the upstream side, m, the first one the origin.
    pub upstream: Vec<[f64; 2]>,
    /// Vertices of the downstream side, m.
    pub downstream: Vec<[f64; 2]>,
}

/// A horizontal crack through the whole section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrackParameters {
    /// Elevation above the base, m.
    pub elevation: f64,
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
    /// Where its contacts are.
    #[serde(default, skip_serializing_if = "is_default")]
    pub integration: Integration,
    /// Normal stiffness k_n, Pa/m.
    pub normal_stiffness: f64,
    /// Shear stiffness k_s, Pa/m.
    pub shear_stiffness: f64,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Measure of strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kinematics {
    /// Linear strain, for small displacements and rotations.
    Small,
    /// Biot strain `U − I` behind the exact rotation of every element.
    Corotational,
}

impl CrackParameters {
    /// A crack that slides by Coulomb's friction, not bonded.
    pub fn sliding(
        elevation: f64,
        friction_coefficient: f64,
        normal_stiffness: f64,
        shear_stiffness: f64,
    ) -> Self {
        Self {
            elevation,
            friction_coefficient,
            residual_friction_coefficient: None,
            cohesion: 0.0,
            tensile_strength: 0.0,
            dilation: 0.0,
            dilation_slip: None,
            integration: Integration::Nodal,
            normal_stiffness,
            shear_stiffness,
        }
    }
}

impl Section {
    /// A rectangle with its heel at the origin.
    pub fn rectangle(width: f64, height: f64) -> Self {
        Self { upstream: vec![[0.0, 0.0], [0.0, height]], downstream: vec![[width, 0.0], [width, height]] }
    }

    /// Elevation of the crest, m.
    pub fn height(&self) -> f64 {
        self.upstream.last().map_or(0.0, |p| p[1])
    }

    /// Area of the section, m².
    pub fn area(&self) -> f64 {
        let below = |side: &[[f64; 2]]| -> f64 {
            side.windows(2).map(|s| (s[0][0] + s[1][0]) / 2.0 * (s[1][1] - s[0][1])).sum()
        };
        below(&self.downstream) - below(&self.upstream)
    }

    /// x of both sides at elevation `y`, m.
    pub fn sides_at(&self, y: f64) -> [f64; 2] {
        [x_at(&self.upstream, y), x_at(&self.downstream, y)]
    }

    /// Elevations of all vertices, m, unsorted.
    pub fn vertex_elevations(&self) -> impl Iterator<Item = f64> + '_ {
        self.upstream.iter().chain(&self.downstream).map(|p| p[1])
    }

    /// Checks that the sides ascend from a level base to a level crest and do not cross.
    pub fn check(&self) -> Result<(), DamError> {
        for (side, points) in [("upstream", &self.upstream), ("downstream", &self.downstream)] {
            if points.len() < 2 {
                return Err(DamError::SideTooShort { side, found: points.len() });
            }
            for (index, &[x, y]) in points.iter().enumerate() {
                let ascending = index == 0 || y > points[index - 1][1];
                if !(x.is_finite() && y.is_finite() && ascending) {
                    return Err(DamError::SideNotAscending { side, index, x, y });
                }
            }
        }
        let [x, y] = self.upstream[0];
        if [x, y] != [0.0, 0.0] {
            return Err(DamError::HeelNotAtOrigin { x, y });
        }
        let toe = self.downstream[0][1];
        let crest = self.downstream.last().map_or(0.0, |p| p[1]);
        for (end, upstream, downstream) in [("base", y, toe), ("crest", self.height(), crest)] {
            if upstream != downstream {
                return Err(DamError::SidesNotLevel { end, upstream, downstream });
            }
        }
        for elevation in self.vertex_elevations() {
            let [left, right] = self.sides_at(elevation);
            if right <= left {
                return Err(DamError::SidesCross { elevation, width: right - left });
            }
        }
        Ok(())
    }
}

/// x of a side at elevation `y`; the side is extended beyond its ends.
fn x_at(side: &[[f64; 2]], y: f64) -> f64 {
    let above = side.partition_point(|p| p[1] < y).clamp(1, side.len() - 1);
    let ([x0, y0], [x1, y1]) = (side[above - 1], side[above]);
    if y == y1 { x1 } else { x0 + (x1 - x0) * (y - y0) / (y1 - y0) }
}

impl DamParameters {
    /// Checks everything that can be checked without a mesh.
    ///
    /// **Errors**: the [`DamError`] that names the parameter.
    pub fn check(&self) -> Result<(), DamError> {
        self.section.check()?;
        let crest = self.section.height();
        if !(self.water_depth >= 0.0 && self.water_depth <= crest) {
            return Err(DamError::WaterDepth { depth: self.water_depth, crest });
        }
        for (i, crack) in self.cracks.iter().enumerate() {
            let elevation = crack.elevation;
            let margin = ELEVATION_TOLERANCE * crest;
            if !(elevation > margin && elevation < crest - margin) {
                return Err(DamError::CrackOutside { elevation, crest });
            }
            if self.cracks[..i].iter().any(|other| (other.elevation - elevation).abs() <= margin) {
                return Err(DamError::DuplicateCrack { elevation });
            }
            let mu = crack.friction_coefficient;
            require(mu >= 0.0, "friction_coefficient", mu, "zero or positive")?;
            require(crack.normal_stiffness > 0.0, "normal_stiffness", crack.normal_stiffness, "positive")?;
            require(crack.shear_stiffness > 0.0, "shear_stiffness", crack.shear_stiffness, "positive")?;
            let residual = crack.residual_friction_coefficient.unwrap_or(mu);
            let requirement = "zero or more, and no more than the friction coefficient";
            require((0.0..=mu).contains(&residual), "residual_friction_coefficient", residual, requirement)?;
            for (name, value) in [
                ("cohesion", crack.cohesion),
                ("tensile_strength", crack.tensile_strength),
                ("dilation", crack.dilation),
                ("dilation_slip", crack.dilation_slip.unwrap_or(0.0)),
            ] {
                require(value >= 0.0, name, value, "zero or positive")?;
            }
        }
        self.material.check()?;
        self.damping.check()?;
        self.fidelity.check(self.cracks.len())?;
        if self.fidelity != Fidelity::Dem && self.damping.local() > 0.0 {
            return Err(DamError::LocalDampingOfModes);
        }
        require(self.element_size > 0.0, "element_size", self.element_size, "positive")?;
        self.check_rows()?;
        require(self.gravity >= 0.0, "gravity", self.gravity, "zero or positive")?;
        let safety = self.time_step_safety;
        require(safety > 0.0 && safety <= 1.0, "time_step_safety", safety, "above 0 and at most 1")
    }
}

impl DamParameters {
    /// The numbers behind a variable that an importer may change; those of cracks from the base up.
    pub(crate) fn numbers(&mut self, variable: &Variable) -> Vec<&mut f64> {
        let Material { young_modulus, poisson_ratio, density, .. } = &mut self.material;
        let mut cracks: Vec<&mut CrackParameters> = self.cracks.iter_mut().collect();
        cracks.sort_by(|a, b| a.elevation.total_cmp(&b.elevation));
        let cracks = cracks.into_iter();
        match *variable {
            variables::YOUNG_MODULUS => vec![young_modulus],
            variables::POISSON_RATIO => vec![poisson_ratio],
            variables::DENSITY => vec![density],
            variables::FRICTION_COEFFICIENT => cracks.map(|crack| &mut crack.friction_coefficient).collect(),
            variables::NORMAL_STIFFNESS => cracks.map(|crack| &mut crack.normal_stiffness).collect(),
            variables::SHEAR_STIFFNESS => cracks.map(|crack| &mut crack.shear_stiffness).collect(),
            variables::DAMPING_RATIO => self.damping.ratio_mut().into_iter().collect(),
            _ => Vec::new(),
        }
    }

    /// The mesh of the section: rows end at vertices, cracks and the water level.
    pub fn mesh(&self) -> Mesh {
        let mut elevations: Vec<f64> = self.cracks.iter().map(|crack| crack.elevation).collect();
        elevations.sort_by(f64::total_cmp);
        Mesh::new(&self.section, &elevations, &[self.water_depth], self.element_size)
    }

    /// Number of contacts in all cracks.
    pub(crate) fn contact_count(&self) -> usize {
        let nodes = self.mesh().blocks[0].top.len();
        let of_a_side = |crack: &CrackParameters| match crack.integration {
            Integration::Nodal => nodes,
            Integration::Gauss => 2 * (nodes - 1),
        };
        self.cracks.iter().map(|crack| 2 * of_a_side(crack)).sum()
    }

    /// The wet face of the dam that these parameters make, or `None` with an empty reservoir.
    ///
    /// **Errors**: as [`check`](Self::check), and [`DamError::WetFace`].
    pub fn wet_face(&self) -> Result<Option<WetFace>, DamError> {
        self.check()?;
        Ok(Wet::below(&self.mesh(), self.water_depth)?.map(|wet| wet.face))
    }

    /// Rows end at vertices, cracks and water level: two of these close together make flat elements whose
    /// time step is next to nothing.
    fn check_rows(&self) -> Result<(), DamError> {
        let cracks = self.cracks.iter().map(|crack| crack.elevation);
        let mut levels: Vec<f64> =
            self.section.vertex_elevations().chain(cracks).chain([self.water_depth]).collect();
        levels.sort_by(f64::total_cmp);
        let same = ELEVATION_TOLERANCE * self.section.height();
        let least = THINNEST_ROW * self.element_size;
        match levels.windows(2).find(|pair| pair[1] - pair[0] > same && pair[1] - pair[0] < least) {
            Some(pair) => Err(DamError::ThinRow { lower: pair[0], upper: pair[1], least }),
            None => Ok(()),
        }
    }
}

/// Least height of a row of elements over their nominal size.
const THINNEST_ROW: f64 = 0.1;

/// Elevations closer than this share of the height count as one.
pub(crate) const ELEVATION_TOLERANCE: f64 = 1e-6;
