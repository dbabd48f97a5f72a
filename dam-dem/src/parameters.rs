mod crack;
mod problems;
mod zone;

pub use crack::{CrackLine, CrackParameters};
pub use zone::ZoneParameters;

use cofferdam_unit::variables::dam as variables;
use cofferdam_unit::{Variable, WetFace};
use serde::{Deserialize, Serialize};

use crate::contact::Integration;
use crate::error::DamError;
use crate::loads::StaticLoad;
use crate::section::Section;
use crate::wet::Wet;
use crate::{Damping, Fidelity, Geometry, GivenMesh, Kinematics, Material, Materials, Mesh, Seam};

/// Everything a dam is made from. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DamParameters {
    /// Outline of the cross-section.
    pub section: Section,
    /// Depth of the water at the heel, m; 0 means an empty reservoir and no wet face.
    pub water_depth: f64,
    /// Depth of the water at the toe, m; 0 means no tailwater and no wet face downstream.
    #[serde(default, skip_serializing_if = "is_default")]
    pub tailwater_depth: f64,
    /// Cracks, in any order. Results come from the base up.
    pub cracks: Vec<CrackParameters>,
    /// The concrete, where no zone is.
    pub material: Material,
    /// Where the concrete is another. Of zones that overlap the last one counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<ZoneParameters>,
    /// Damping of concrete and contacts.
    pub damping: Damping,
    /// Whether mass damping also drags blocks that slide or rock (`C = α M`).
    pub drags_blocks: bool,
    /// How much of the physics is computed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub fidelity: Fidelity,
    /// Small strain, or corotational with finite rotations; modes know small rotations only.
    pub kinematics: Kinematics,
    /// Nominal length of an element's side, m.
    pub element_size: f64,
    /// A mesh that was made elsewhere, of the same section and with the same cracks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given_mesh: Option<GivenMesh>,
    /// Gravitational acceleration g, m/s².
    pub gravity: f64,
    /// Time step over the longest stable one, in (0, 1].
    pub time_step_safety: f64,
    /// Added mass of water without memory, rows of points × points, Pa per m/s²: it becomes part of the mass
    /// matrix ([`AddedMass`](crate::AddedMass)), and `interface_pressure` what acts beside it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<Vec<Vec<f64>>>,
    /// Densities of the water in joints from the reservoir and from the tailwater, kg/m³; used by uplift alone.
    #[serde(default = "fresh_water", skip_serializing_if = "is_fresh_water")]
    pub water_densities: [f64; 2],
    /// Loads that do not vary, beside weight and water.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub static_loads: Vec<StaticLoad>,
    /// Whether the dam keeps the envelopes of its stresses and its motion: the variables that begin with `envelope_`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub envelopes: bool,
    /// 1 if pressure and ground acceleration have the values that are set over the whole next step; 0 if they change linearly within
    /// it. A number, as importers of FMUs change it.
    #[serde(default, skip_serializing_if = "is_default")]
    pub inputs_held: f64,
}

/// Koyna Dam with its reservoir full, a sliding crack at the neck, 5 % Rayleigh damping at once and five times its first
/// frequency, and elements of 5 m; no tailwater, no zones, no envelopes.
impl Default for DamParameters {
    fn default() -> Self {
        Self {
            section: Section::default(),
            water_depth: 91.75,
            tailwater_depth: 0.0,
            cracks: vec![CrackParameters::default()],
            material: Material::default(),
            zones: Vec::new(),
            damping: Damping::default(),
            drags_blocks: false,
            fidelity: Fidelity::default(),
            kinematics: Kinematics::default(),
            element_size: 5.0,
            given_mesh: None,
            gravity: 9.81,
            time_step_safety: 0.9,
            added_mass: None,
            water_densities: fresh_water(),
            static_loads: Vec::new(),
            envelopes: false,
            inputs_held: 0.0,
        }
    }
}

fn fresh_water() -> [f64; 2] {
    [1000.0; 2]
}

fn is_fresh_water(densities: &[f64; 2]) -> bool {
    *densities == fresh_water()
}

impl DamParameters {
    /// Whether blocks of one material are stacked between horizontal cracks in a section that rows of cells can fill, all of one
    /// size.
    fn has_layers(&self) -> bool {
        let in_rows = |crack: &CrackParameters| {
            matches!(crack.line, CrackLine::Level(_)) && crack.element_size.is_none()
        };
        let rows = self.given_mesh.is_none() && self.zones.is_empty() && self.section.has_rows();
        rows && self.cracks.iter().all(in_rows)
    }
}

impl DamParameters {
    /// The numbers behind a variable that an importer may change; those of cracks from the base up.
    pub(crate) fn numbers(&mut self, variable: &Variable) -> Vec<&mut f64> {
        let Material { young_modulus, poisson_ratio, density, .. } = &mut self.material;
        let mut cracks: Vec<&mut CrackParameters> = self.cracks.iter_mut().collect();
        cracks.sort_by(|a, b| CrackParameters::from_the_base_up(a, b));
        let cracks = cracks.into_iter();
        match *variable {
            variables::YOUNG_MODULUS => vec![young_modulus],
            variables::POISSON_RATIO => vec![poisson_ratio],
            variables::DENSITY => vec![density],
            variables::FRICTION_COEFFICIENT => cracks.map(|crack| &mut crack.friction_coefficient).collect(),
            variables::NORMAL_STIFFNESS => cracks.map(|crack| &mut crack.normal_stiffness).collect(),
            variables::SHEAR_STIFFNESS => cracks.map(|crack| &mut crack.shear_stiffness).collect(),
            variables::DAMPING_RATIO => self.damping.ratio_mut().into_iter().collect(),
            variables::INPUTS_HELD => vec![&mut self.inputs_held],
            _ => Vec::new(),
        }
    }

    /// The mesh of the section: rows end at vertices, cracks and the water levels.
    ///
    /// **Errors**: those of [`problems`](Self::problems) that only the mesh shows.
    pub fn mesh(&self) -> Result<Mesh, DamError> {
        if self.has_layers() {
            let mut elevations: Vec<f64> = self.cracks.iter().map(|crack| crack.line.elevation()).collect();
            elevations.sort_by(f64::total_cmp);
            let on_joint = elevations.first() == Some(&0.0);
            let inside = &elevations[usize::from(on_joint)..];
            return Ok(Mesh::layered(
                &self.section,
                on_joint,
                inside,
                &self.water_levels(),
                self.element_size,
            ));
        }
        let mut mesh = self.unordered()?;
        // cracks by their elevation
        let order = self.cracks_from_the_base_up();
        let mut places = vec![0; order.len()];
        order.into_iter().enumerate().for_each(|(place, crack)| places[crack] = place);
        mesh.seams.iter_mut().for_each(|seam| seam.crack = places[seam.crack]);
        mesh.seams.sort_by_key(|seam| seam.crack);
        Ok(mesh)
    }

    /// The mesh of what is no stack of blocks, with the cracks in their order here.
    fn unordered(&self) -> Result<Mesh, DamError> {
        let zones: Vec<Vec<[f64; 2]>> = self.zones.iter().map(|zone| zone.polygon.clone()).collect();
        if let Some(given) = &self.given_mesh {
            return Ok(Mesh::of_given(given, &zones, self.water_levels(), self.element_size)?);
        }
        let Section { upstream, downstream, galleries } = &self.section;
        let lines: Vec<Vec<[f64; 2]>> = self.cracks.iter().map(|crack| self.points_of(&crack.line)).collect();
        let sizes: Vec<Option<f64>> = self.cracks.iter().map(|crack| crack.element_size).collect();
        let level = |depth: f64| if depth > 0.0 { vec![depth] } else { Vec::new() };
        Ok(Mesh::of_section(&Geometry {
            upstream,
            downstream,
            galleries,
            cracks: &lines,
            zones: &zones,
            upstream_levels: &level(self.water_depth),
            downstream_levels: &level(self.tailwater_depth),
            element_size: self.element_size,
            crack_sizes: &sizes,
        })?)
    }

    /// Whether a dam of these parameters has `variable`: envelopes are there if they are kept, and what needs a tensile strength
    /// if there is one; the force of uplift if a crack has it.
    pub(crate) fn has(&self, variable: &Variable) -> bool {
        match *variable {
            variables::ENVELOPE_OVERSTRESS_DURATION | variables::ENVELOPE_DEMAND_CAPACITY_RATIO => {
                let strengths = self.zones.iter().map(|zone| zone.tensile_strength);
                self.envelopes && strengths.chain([self.material.tensile_strength]).flatten().next().is_some()
            }
            variables::ENVELOPE_END
            | variables::ENVELOPE_MAJOR_PRINCIPAL_STRESS
            | variables::ENVELOPE_MAJOR_PRINCIPAL_STRESS_TIME
            | variables::ENVELOPE_MINOR_PRINCIPAL_STRESS
            | variables::ENVELOPE_MINOR_PRINCIPAL_STRESS_TIME
            | variables::ENVELOPE_DISPLACEMENT_X_LEAST
            | variables::ENVELOPE_DISPLACEMENT_X_MOST
            | variables::ENVELOPE_DISPLACEMENT_Y_LEAST
            | variables::ENVELOPE_DISPLACEMENT_Y_MOST
            | variables::ENVELOPE_DISPLACEMENT_MAGNITUDE
            | variables::ENVELOPE_CONTACT_OPENING
            | variables::ENVELOPE_CONTACT_SLIP_LEAST
            | variables::ENVELOPE_CONTACT_SLIP_MOST => self.envelopes,
            variables::CRACK_UPLIFT_FORCE => self.cracks.iter().any(|crack| crack.uplift.is_some()),
            variables::CRACK_BONDED_SHARE => self.cracks.iter().any(CrackParameters::is_bonded),
            _ => true,
        }
    }

    /// The materials of dam and zones.
    pub fn materials(&self) -> Materials {
        let of_zones = self.zones.iter().map(|zone| zone.material(&self.material)).collect();
        Materials { general: self.material, of_zones }
    }

    /// Indices of the cracks by their elevation.
    pub fn cracks_from_the_base_up(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.cracks.len()).collect();
        order.sort_by(|&a, &b| CrackParameters::from_the_base_up(&self.cracks[a], &self.cracks[b]));
        order
    }

    /// Points of a crack, which may lie beyond the section.
    fn points_of(&self, line: &CrackLine) -> Vec<[f64; 2]> {
        match line {
            CrackLine::Polyline(points) => points.clone(),
            // along the base from heel to toe, and otherwise as far as there can be concrete
            CrackLine::Level(0.0) => {
                let ends = [&self.section.upstream, &self.section.downstream];
                ends.into_iter().filter_map(|side| side.first().copied()).collect()
            }
            CrackLine::Level(elevation) => {
                let x = self.section.upstream.iter().chain(&self.section.downstream).map(|point| point[0]);
                let (first, last) =
                    x.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
                vec![[first - 1.0, *elevation], [last + 1.0, *elevation]]
            }
        }
    }

    /// Number of contacts in all cracks on `mesh`.
    pub(crate) fn contact_count(&self, mesh: &Mesh) -> usize {
        let order = self.cracks_from_the_base_up();
        let of_side = |side: &[usize], integration| match integration {
            Integration::Nodal => side.len(),
            Integration::Gauss => 2 * (side.len() - 1),
        };
        let of_seam = |seam: &Seam| {
            let integration = self.cracks[order[seam.crack]].integration;
            let below = if mesh.is_ground(seam.below) { 0 } else { of_side(&seam.lower, integration) };
            below + of_side(&seam.upper, integration)
        };
        mesh.seams.iter().map(of_seam).sum()
    }

    /// The wet face of the dam that these parameters make, or `None` with an empty reservoir.
    ///
    /// **Errors**: as [`check`](Self::check), and [`DamError::WetFace`].
    pub fn wet_face(&self) -> Result<Option<WetFace>, DamError> {
        Ok(self.wet_faces()?[0].take())
    }

    /// The wet face of the tailwater, or `None` without it.
    ///
    /// **Errors**: as [`wet_face`](Self::wet_face).
    pub fn tailwater_face(&self) -> Result<Option<WetFace>, DamError> {
        Ok(self.wet_faces()?[1].take())
    }

    fn wet_faces(&self) -> Result<[Option<WetFace>; 2], DamError> {
        self.check()?;
        Ok(Wet::below(&self.mesh()?, self.water_levels())?.unwrap_or_default().faces)
    }

    /// Levels of the water with a wet face upstream and downstream, m.
    pub(crate) fn water_levels(&self) -> [f64; 2] {
        [self.water_depth, self.tailwater_depth]
    }

    /// Levels (m) and specific weights (N/m³) of the water that enters joints upstream and downstream.
    pub(crate) fn water_at_joints(&self) -> ([f64; 2], [f64; 2]) {
        let still = self.static_loads.iter().find_map(|load| match load {
            StaticLoad::Tailwater(water) => Some(water),
            _ => None,
        });
        let [upstream, mut downstream] = self.water_densities;
        let mut levels = self.water_levels();
        if let Some(still) = still {
            (levels[1], downstream) = (still.depth, still.density);
        }
        (levels, [upstream, downstream].map(|density| density * self.gravity))
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
