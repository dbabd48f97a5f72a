use interface::variables::dam as variables;
use interface::{Variable, WetFace, mean_elevation};
use serde::{Deserialize, Serialize};

use crate::contact::Integration;
use crate::error::{DamError, Problem, require};
use crate::loads::Wet;
use crate::section::{ELEVATION_TOLERANCE, Section};
use crate::{
    Damping, Feature, Fidelity, Geometry, GeometryError, GivenMesh, Kinematics, Material, Materials, Mesh,
    Seam,
};

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
    /// Whether the dam keeps the envelopes of its stresses and its motion: the variables that begin with `envelope_`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub envelopes: bool,
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
            envelopes: false,
        }
    }
}

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
    fn problems(&self, index: usize, general: &Material) -> impl Iterator<Item = Problem> + use<> {
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
    fn key(&self) -> &'static str {
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
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The crack at the neck of Koyna Dam, at 66.5 m: friction coefficient 1, stiffnesses of 1e11 and 0.5e11 Pa/m, not bonded.
impl Default for CrackParameters {
    fn default() -> Self {
        Self::sliding(66.5, 1.0, 1e11, 0.5e11)
    }
}

impl CrackParameters {
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
        }
    }
}

impl CrackParameters {
    /// What is wrong with the crack of that `index` by itself.
    fn problems(&self, index: usize) -> impl Iterator<Item = Problem> {
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

impl DamParameters {
    /// Checks the parameters, and that the section can be meshed.
    ///
    /// **Errors**: the first of [`problems`](Self::problems).
    pub fn check(&self) -> Result<(), DamError> {
        self.problems().into_iter().next().map_or(Ok(()), |problem| Err(problem.error))
    }

    /// Everything that is wrong with the parameters; of a section that rows of cells cannot fill, what meshing it shows too.
    pub fn problems(&self) -> Vec<Problem> {
        let mut found = Vec::new();
        for (name, value, holds, requirement) in [
            ("element_size", self.element_size, self.element_size > 0.0, "positive"),
            ("gravity", self.gravity, self.gravity >= 0.0, "zero or positive"),
            (
                "time_step_safety",
                self.time_step_safety,
                self.time_step_safety > 0.0 && self.time_step_safety <= 1.0,
                "above 0 and at most 1",
            ),
        ] {
            found.extend(
                require(holds, name, value, requirement).err().map(|error| Problem::of([name], error)),
            );
        }
        for (index, crack) in self.cracks.iter().enumerate() {
            found.extend(crack.problems(index));
        }
        found.extend(self.material.problems());
        for (index, zone) in self.zones.iter().enumerate() {
            found.extend(zone.problems(index, &self.material));
        }
        found.extend(self.damping.problems());
        found.extend(self.fidelity.check(self.cracks.len()).err().map(|error| match error {
            DamError::RigidWithoutCrack => Problem::of(["fidelity", "cracks"], error),
            error => Problem::of(["modes"], error),
        }));
        if !self.fidelity.level().has_elements() && self.damping.local() > 0.0 {
            found.push(Problem::of(["damping.model", "fidelity"], DamError::LocalDampingOfModes));
        }
        let sound = |found: &[Problem]| {
            !found.iter().flat_map(|problem| &problem.keys).any(|key| key == "element_size")
        };
        if self.has_layers() {
            found.extend(self.levels());
        } else if sound(&found) {
            let of_mesh = self.of_mesh();
            let meshed = of_mesh.is_empty();
            found.extend(of_mesh);
            if meshed {
                found.extend(self.depths());
            }
        }
        found
    }

    /// Whether blocks of one material are stacked between horizontal cracks in a section that rows of cells can fill, all of one
    /// size.
    fn has_layers(&self) -> bool {
        let in_rows = |crack: &CrackParameters| {
            matches!(crack.line, CrackLine::Level(_)) && crack.element_size.is_none()
        };
        let rows = self.given_mesh.is_none() && self.zones.is_empty() && self.section.has_rows();
        rows && self.cracks.iter().all(in_rows)
    }

    /// What is wrong with the depths of the water.
    fn depths(&self) -> Vec<Problem> {
        let depths = [
            ("water_depth", self.water_depth, "section.upstream", &self.section.upstream),
            ("tailwater_depth", self.tailwater_depth, "section.downstream", &self.section.downstream),
        ];
        let problem = |(key, depth, section, side): (&str, f64, &str, &Vec<[f64; 2]>)| {
            let crest = side.last().map_or(0.0, |point| point[1]);
            let error = DamError::WaterDepth { depth, crest };
            (!(depth >= 0.0 && depth <= crest)).then(|| Problem::of([key, section], error))
        };
        depths.into_iter().filter_map(problem).collect()
    }

    /// What the mesh of a section without layers shows.
    fn of_mesh(&self) -> Vec<Problem> {
        let wet = |mesh: Mesh| {
            let faces = Wet::below(&mesh, self.water_levels())?.unwrap_or_default().faces;
            let missed = faces.iter().zip(self.water_levels()).find_map(|(face, depth)| {
                let reached = face.as_ref()?.depth();
                // beyond the crest the depth is refused
                (depth <= self.section.height()
                    && (depth - reached).abs() > ELEVATION_TOLERANCE * self.section.height())
                .then_some(DamError::NoPointAtLevel { depth, reached })
            });
            missed.map_or(Ok(()), Err)
        };
        match self.mesh().and_then(wet) {
            Ok(()) => Vec::new(),
            Err(DamError::GivenMesh(error)) => {
                let key = error
                    .crack()
                    .map_or_else(|| "mesh.file".to_owned(), |crack| format!("cracks.{crack}.name"));
                vec![Problem { keys: vec![key], error: error.into() }]
            }
            Err(DamError::Geometry(error)) => {
                let mut keys: Vec<String> =
                    error.features().into_iter().map(|feature| self.key_of(feature)).collect();
                if keys.is_empty() || matches!(error, GeometryError::TooManyCells { .. }) {
                    keys.push("element_size".to_owned());
                }
                vec![Problem { keys, error: error.into() }]
            }
            Err(error @ DamError::NoPointAtLevel { depth, .. }) => {
                let key = if depth == self.water_depth { "water_depth" } else { "tailwater_depth" };
                vec![Problem::of([key, "element_size"], error)]
            }
            Err(error) => vec![Problem::of(["section", "water_depth"], error)],
        }
    }

    /// The parameter of a part of the section.
    fn key_of(&self, feature: Feature) -> String {
        match feature {
            Feature::Base | Feature::Crest => "section".to_owned(),
            Feature::Upstream => "section.upstream".to_owned(),
            Feature::Downstream => "section.downstream".to_owned(),
            Feature::Gallery(index) => format!("section.galleries.{index}"),
            Feature::Zone(index) => format!("zones.{index}.polygon"),
            Feature::Crack(index) => {
                format!(
                    "cracks.{index}.{}",
                    self.cracks.get(index).map_or("polyline", |crack| crack.line.key())
                )
            }
        }
    }

    /// What is wrong with elevations and sizes within a section that is right.
    fn levels(&self) -> Vec<Problem> {
        const SECTION: &str = "section.upstream";
        let mut found = self.depths();
        let (crest, size) = (self.section.height(), self.element_size);
        let margin = ELEVATION_TOLERANCE * crest;
        for (index, crack) in self.cracks.iter().enumerate() {
            let CrackLine::Level(elevation) = crack.line else { continue };
            let key = format!("cracks.{index}.{}", crack.line.key());
            if !(elevation == 0.0 || elevation > margin && elevation < crest - margin) {
                found.push(Problem::of([&key, SECTION], DamError::CrackOutside { elevation, crest }));
            }
            let near = |crack: &CrackParameters| match crack.line {
                CrackLine::Level(other) if (other - elevation).abs() <= margin => Some(other),
                _ => None,
            };
            let others = self.cracks[..index].iter().enumerate();
            if let Some((at, other)) = others.filter_map(|(at, crack)| Some((at, near(crack)?))).next() {
                let error = DamError::DuplicateCrack { elevation, other };
                found.push(Problem::of([&key, &format!("cracks.{at}.elevation")], error));
            }
        }
        if size > crest {
            found.push(Problem::of(["element_size", SECTION], DamError::ElementTooLarge { size, crest }));
        }
        let elements = ELEMENTS_A_SQUARE * self.section.area() / (size * size);
        if elements > MOST_ELEMENTS {
            found.push(Problem::of(["element_size", "section"], DamError::TooManyElements { elements }));
        }
        found.extend(self.thin_rows());
        found
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
    /// if there is one.
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

    /// Levels of the water upstream and downstream, m.
    pub(crate) fn water_levels(&self) -> [f64; 2] {
        [self.water_depth, self.tailwater_depth]
    }

    /// Rows end at vertices, cracks and water levels: two of these close together make flat elements whose
    /// time step is next to nothing.
    fn thin_rows(&self) -> Vec<Problem> {
        let mut levels: Vec<(f64, String)> =
            self.section.vertex_elevations().map(|y| (y, "section".to_owned())).collect();
        levels.push((self.water_depth, "water_depth".to_owned()));
        if self.tailwater_depth > 0.0 {
            levels.push((self.tailwater_depth, "tailwater_depth".to_owned()));
        }
        let cracks = self.cracks.iter().enumerate();
        levels.extend(
            cracks.map(|(index, crack)| (crack.line.elevation(), format!("cracks.{index}.elevation"))),
        );
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let same = ELEVATION_TOLERANCE * self.section.height();
        let least = THINNEST_ROW * self.element_size;
        let thin = levels.windows(2).filter(|pair| (same..least).contains(&(pair[1].0 - pair[0].0)));
        let problem = |pair: &[(f64, String)]| {
            let [(lower, below), (upper, above)] = [&pair[0], &pair[1]];
            let keys = if above == "section" { [below, above] } else { [above, below] };
            let error = DamError::ThinRow { lower: *lower, upper: *upper, least };
            Problem::of([keys[0], keys[1], "element_size"], error)
        };
        thin.map(problem).collect()
    }
}

/// Least height of a row of elements over their nominal size.
const THINNEST_ROW: f64 = 0.1;

/// Triangles of a square of the nominal size, and the most that a dam may have.
const ELEMENTS_A_SQUARE: f64 = 4.0;
const MOST_ELEMENTS: f64 = 1e6;
