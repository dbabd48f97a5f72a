//! `[dam]`: the dam that is computed, and `[prescribed]`: one that moves as told.

use super::foreign::{CommandScene, FmuScene, LogScene, Source};
use super::mesh::MeshScene;
use cofferdam_dam::contact::Integration;
use cofferdam_dam::uplift::{Drains, Uplift, UpliftRule};
use cofferdam_dam::{
    CrackLine, CrackParameters, Damping, DampingFrequencies, DampingModel, FidelityLevel, Kinematics,
    Material, Plane, Section, ZoneParameters,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid dam that moves with the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedScene {
    /// Horizontal distance by which the wet face leans downstream from heel to water level.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1e3), extend("unit" = "m"))]
    pub batter: f64,
    /// Number of panels of the wet face.
    #[schemars(range(min = 1, max = 1000))]
    pub panels: usize,
}

/// The dam that is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamScene {
    /// How much of the dam is computed.
    #[serde(default)]
    pub fidelity: DamFidelityScene,
    /// Number of modes inside each block (`"reduced"`) or of the dam (`"intact"`); with these two alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000), extend("otherwise" = "by an error estimate"))]
    pub modes: Option<usize>,
    /// Nominal length of an element's side. With `[dam.mesh]` it is not given: √(area / number of cells).
    #[schemars(range(min = 1e-3, max = 1e4), extend("unit" = "m"))]
    pub element_size: f64,
    /// Kinematics of the elements, and of reduced blocks.
    #[serde(default)]
    pub kinematics: Kinematics,
    /// Factor on the critical time step. With cracks the time step is limited to 0.25 × 2/ω, or 0.18 × 2/ω without stiffness damping, where ω is the highest frequency
    /// of the mesh (for reduced blocks 2.9 times as much while all contacts stick).
    /// `cofferdam range` halves the time step.
    #[serde(default = "time_step_safety")]
    #[schemars(range(min = 1e-3, max = 1))]
    pub time_step_safety: f64,
    /// Whether the envelopes of stresses and motion over the run are kept, and written to `envelopes.vtu` at its end.
    #[serde(default = "yes")]
    pub envelopes: bool,
    /// Outline of the section. With `[dam.mesh]` it is not given.
    pub section: SectionScene,
    /// A mesh from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshScene>,
    /// The concrete.
    pub material: MaterialScene,
    /// Parts of the section with a concrete of their own, such as a core, a facing or older lifts. The mesh is then
    /// unstructured and follows their outlines. Where zones overlap, the last one applies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<ZoneScene>,
    /// Damping. The table is required, because sliding depends on it more than on anything else.
    pub damping: DampingScene,
    /// Water in cracks below a water level during the earthquake; `[dam.cracks.uplift]` says more of one crack. Before the
    /// earthquake the pressure falls linearly along a crack from the reservoir's to the tailwater's, and a part that opens takes
    /// the full pressure at its mouth.
    #[serde(default)]
    pub uplift: UpliftRuleScene,
    /// Cracks. Results come in the order of mean elevations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cracks: Vec<CrackScene>,
    /// An FMU that computes the dam; with `fidelity = "fmu"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("like" = "reservoir.fmu"))]
    pub fmu: Option<FmuScene>,
    /// A process that computes the dam; with `fidelity = "command"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("like" = "reservoir.command"))]
    pub command: Option<CommandScene>,
    /// An earlier run whose dam moves the water; with `fidelity = "log"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("like" = "reservoir.log"))]
    pub log: Option<LogScene>,
}

impl DamScene {
    /// Who computes the dam.
    pub fn source(&self) -> Source<'_> {
        Source::of(&self.fidelity.word(), (&self.fmu, &self.command, &self.log))
    }
}

/// How much of the dam is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DamFidelityScene {
    /// Every element and every contact.
    #[default]
    Dem,
    /// Blocks of elastic modes between the same contacts, at a quarter of the cost at 5 m and a tenth at 2.5 m.
    Reduced,
    /// Blocks that do not deform: **unsafe**, the dam's own amplification is missing.
    RigidBlocks,
    /// The dam without its cracks, linear, by modes.
    Intact,
    /// An FMU from another program: `[dam.fmu]`. Section and `element_size` still say where the wet face and its points are;
    /// material, zones, damping and cracks are the other program's own.
    Fmu,
    /// A process of another program: `[dam.command]`.
    Command,
    /// The motion recorded in the log of an earlier run: `[dam.log]`; never iterated.
    Log,
}

impl DamFidelityScene {
    /// The word in a scene.
    pub fn word(self) -> String {
        super::shape::word(&self)
    }

    /// Whether this program does not compute it.
    pub fn is_foreign(self) -> bool {
        self.level().is_none()
    }

    /// Whether it is that of a past run.
    pub fn is_recorded(self) -> bool {
        self == Self::Log
    }

    /// The level that this program computes; `None` for a dam of another program or of a past run.
    pub fn level(self) -> Option<FidelityLevel> {
        match self {
            Self::Dem => Some(FidelityLevel::Dem),
            Self::Reduced => Some(FidelityLevel::Reduced),
            Self::RigidBlocks => Some(FidelityLevel::RigidBlocks),
            Self::Intact => Some(FidelityLevel::Intact),
            Self::Fmu | Self::Command | Self::Log => None,
        }
    }

    /// Whether a number of modes means something.
    pub fn has_modes(self) -> bool {
        self.level().is_some_and(FidelityLevel::has_modes)
    }

    /// Whether every element is computed.
    pub fn has_elements(self) -> bool {
        self.level().is_some_and(FidelityLevel::has_elements)
    }

    /// Whether the cracks of the scene are left out.
    pub fn is_intact(self) -> bool {
        self.level().is_some_and(|level| !level.is_cracked())
    }

    /// Whether blocks do not deform.
    pub fn is_rigid(self) -> bool {
        self.level().is_some_and(|level| !level.is_deformable())
    }
}

/// Water in a crack during the earthquake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UpliftRuleScene {
    /// No water enters, neither before nor during the earthquake.
    None,
    /// The pressure stays as before the earthquake, also where the crack opens (USACE 1995, FERC).
    #[default]
    Unchanged,
    /// No pressure where the crack is open (USBR 1987).
    ZeroWhereOpen,
    /// Full pressure of the water at the mouth where the crack is open (ICOLD 1986): the safe side.
    FullWhereOpen,
}

impl UpliftRuleScene {
    /// The rule as the dam has it; `None` without water.
    pub fn rule(self) -> Option<UpliftRule> {
        match self {
            Self::None => None,
            Self::Unchanged => Some(UpliftRule::Unchanged),
            Self::ZeroWhereOpen => Some(UpliftRule::ZeroWhereOpen),
            Self::FullWhereOpen => Some(UpliftRule::FullWhereOpen),
        }
    }
}

/// Water in one crack.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpliftScene {
    /// The rule for this crack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "`dam.uplift`"))]
    pub rule: Option<UpliftRuleScene>,
    /// A line of drains across the crack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drains: Option<DrainsScene>,
    /// Pressure along the closed crack in place of that from the water levels: (distance from the upstream end in m, pressure in Pa)
    /// from 0 on, linear between the points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Vec<[f64; 2]>>,
    /// Factor on the pressure over time: (time in s, factor), linear between the points and constant outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Vec<[f64; 2]>>,
}

/// Drains. The head at their line is H2 + (1 − E) (H1 − H2) (L − x)/L, with the heads H1 upstream and H2 downstream above a crack of
/// length L; a gallery above the tailwater takes the place of H2. A crack that opens beyond them makes them ineffective.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrainsScene {
    /// Distance x from the upstream end along the crack.
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0))]
    pub position: f64,
    /// Efficiency E: 0 without effect, 1 for drains that take all of the head above the tailwater.
    #[schemars(range(min = 0, max = 1))]
    pub efficiency: f64,
    /// Elevation of the gallery into which they drain, above the heel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "otherwise" = "not above the tailwater"))]
    pub gallery_elevation: Option<f64>,
}

/// Outline of the section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionScene {
    /// Upstream side, (x, y) from the heel (0, 0) up to the crest.
    #[schemars(extend("unit" = "m"))]
    pub upstream: Vec<[f64; 2]>,
    /// Downstream side, (x, y) from the toe up to the crest. Base and crest are the straight lines between the ends of both
    /// sides. Sides may overhang.
    #[schemars(extend("unit" = "m"))]
    pub downstream: Vec<[f64; 2]>,
    /// Outlines of galleries, each a closed list of points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("unit" = "m"))]
    pub galleries: Vec<Vec<[f64; 2]>>,
}

impl From<&SectionScene> for Section {
    fn from(section: &SectionScene) -> Self {
        let SectionScene { upstream, downstream, galleries } = section.clone();
        Self { upstream, downstream, galleries }
    }
}

/// The concrete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialScene {
    /// Elastic modulus E.
    #[schemars(range(min = 1e6, max = 1e13), extend("unit" = "Pa"))]
    pub young_modulus: f64,
    /// Poisson's ratio ν.
    #[schemars(range(min = 0, max = 0.499))]
    pub poisson_ratio: f64,
    /// Density.
    #[schemars(range(min = 100, max = 1e5), extend("unit" = "kg/m³"))]
    pub density: f64,
    /// Plane condition.
    #[serde(default)]
    pub plane: Plane,
    /// Tensile strength with which the largest principal stress is compared: demand-capacity ratio, time above it and overstressed area
    /// of the section. The concrete does not crack. For earthquakes the dynamic strength is commonly used, about 1.5 times the static one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e3, max = 1e9), extend("unit" = "Pa", "otherwise" = "no comparison"))]
    pub tensile_strength: Option<f64>,
}

impl From<&MaterialScene> for Material {
    fn from(material: &MaterialScene) -> Self {
        let MaterialScene { young_modulus, poisson_ratio, density, plane, tensile_strength } = *material;
        Self { young_modulus, poisson_ratio, density, plane, tensile_strength }
    }
}

/// A part of the section with a concrete of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ZoneScene {
    /// Its name.
    pub name: String,
    /// Its outline, a closed list of points. What lies outside the section or in a gallery is cut off.
    #[schemars(extend("unit" = "m"))]
    pub polygon: Vec<[f64; 2]>,
    /// Elastic modulus E.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e6, max = 1e13), extend("unit" = "Pa", "otherwise" = "that of `dam.material`"))]
    pub young_modulus: Option<f64>,
    /// Poisson's ratio ν.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 0.499), extend("otherwise" = "that of `dam.material`"))]
    pub poisson_ratio: Option<f64>,
    /// Density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100, max = 1e5), extend("unit" = "kg/m³", "otherwise" = "that of `dam.material`"))]
    pub density: Option<f64>,
    /// Tensile strength with which stresses are compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e3, max = 1e9), extend("unit" = "Pa", "otherwise" = "that of `dam.material`"))]
    pub tensile_strength: Option<f64>,
}

impl ZoneScene {
    /// Its material in a dam of the material `general`.
    pub fn material(&self, general: &MaterialScene) -> MaterialScene {
        MaterialScene {
            young_modulus: self.young_modulus.unwrap_or(general.young_modulus),
            poisson_ratio: self.poisson_ratio.unwrap_or(general.poisson_ratio),
            density: self.density.unwrap_or(general.density),
            plane: general.plane,
            tensile_strength: self.tensile_strength.or(general.tensile_strength),
        }
    }
}

impl From<&ZoneScene> for ZoneParameters {
    fn from(zone: &ZoneScene) -> Self {
        let ZoneScene { name, polygon, young_modulus, poisson_ratio, density, tensile_strength } =
            zone.clone();
        Self { name, polygon, young_modulus, poisson_ratio, density, tensile_strength }
    }
}

/// Damping of the dam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingScene {
    /// Kind of damping. Sliding depends on it more than on anything else.
    #[serde(default)]
    pub model: DampingModel,
    /// Damping ratio where it holds; 0 for none.
    #[schemars(range(min = 0, max = 0.999))]
    pub ratio: f64,
    /// The two frequencies at which the ratio holds, as multiples of ω₁ of the intact empty dam. `"mass"` and
    /// `"stiffness"` need two as well, but use only the lower; `"local"` and a ratio of 0 need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "one of the two is required"))]
    pub multiples_of_first: Option<[f64; 2]>,
    /// Whether the mass part also resists blocks that slide or rock, as C = αM does in most published runs; for comparison
    /// with these. Without it a block slides as freely as friction and water let it.
    #[serde(default)]
    pub drags_blocks: bool,
    /// The two frequencies themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "rad/s", "otherwise" = "one of the two is required"))]
    pub radians_per_second: Option<[f64; 2]>,
}

impl From<&DampingScene> for Damping {
    fn from(damping: &DampingScene) -> Self {
        // `drags_blocks` is a parameter of the dam next to its damping.
        let DampingScene { model, ratio, multiples_of_first, drags_blocks: _, radians_per_second } = *damping;
        let multiples = multiples_of_first.map(DampingFrequencies::MultiplesOfFirst);
        let frequencies = multiples.or(radians_per_second.map(DampingFrequencies::RadiansPerSecond));
        model.with_ratio(ratio, frequencies)
    }
}

/// A crack from face to face, or to a gallery or another crack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackScene {
    /// Its name in reports, and that of its physical curve in `[dam.mesh]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "its elevation"))]
    pub name: Option<String>,
    /// Elevation of a horizontal crack through the whole section above the heel; 0 for the joint between dam and ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "otherwise" = "`polyline`"))]
    pub elevation: Option<f64>,
    /// The points of any other crack, which may slope, step, end on a gallery or on another crack, or cross one. It must not end
    /// inside the concrete; what reaches beyond the section is cut off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "otherwise" = "`elevation`"))]
    pub polyline: Option<Vec<[f64; 2]>>,
    /// Coulomb friction coefficient, the tangent of the friction angle. For a bonded crack, or one with a different
    /// residual friction, it is the peak value.
    #[schemars(range(min = 0, max = 5))]
    pub friction_coefficient: f64,
    /// Friction coefficient at every point of the crack that has slipped or opened once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 5), extend("otherwise" = "`friction_coefficient`"))]
    pub residual_friction_coefficient: Option<f64>,
    /// Cohesion of the bond, at every point until it first slips or opens.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1e12), extend("unit" = "Pa"))]
    pub cohesion: f64,
    /// Tensile strength of the bond, at every point until it first slips or opens.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1e12), extend("unit" = "Pa"))]
    pub tensile_strength: f64,
    /// Tangent of the dilation angle: the crack opens by this share of the slip, in both directions.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub dilation: f64,
    /// Slip, added up over both directions, after which the crack opens no more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1e3), extend("unit" = "m", "otherwise" = "no end"))]
    pub dilation_slip: Option<f64>,
    /// Length of an element's side along the crack. The mesh is then unstructured, even if all cracks are horizontal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4), extend("unit" = "m", "otherwise" = "`dam.element_size`"))]
    pub element_size: Option<f64>,
    /// Where the contacts along the crack are. The outermost Gauss points lie a fifth of a segment inside, and a block rocks
    /// about them; nodes include the corners.
    #[serde(default)]
    pub integration: Integration,
    /// Normal stiffness. A crack that is soft compared with the concrete makes the dam more flexible, a stiff one
    /// shortens the time step. 1e11 Pa/m is as stiff as 0.3 m of concrete; doubling or halving it changes the crest displacement of a
    /// sliding dam by 1 % and its sliding by up to 20 %.
    #[schemars(range(min = 1e3, max = 1e15), extend("unit" = "Pa/m"))]
    pub normal_stiffness: f64,
    /// Shear stiffness.
    #[schemars(range(min = 1e3, max = 1e15), extend("unit" = "Pa/m"))]
    pub shear_stiffness: f64,
    /// Water in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uplift: Option<UpliftScene>,
    /// Its number in the file, by which keys name it.
    #[serde(skip)]
    pub number: usize,
}

impl CrackScene {
    /// Mean elevation over its length, m; NaN for a crack that is nowhere.
    pub fn mean_elevation(&self) -> f64 {
        match (&self.elevation, &self.polyline) {
            (Some(elevation), _) => *elevation,
            (None, Some(points)) => cofferdam_unit::mean_elevation(points),
            (None, None) => f64::NAN,
        }
    }

    /// Where it runs; `None` if the scene does not say, which validation reports.
    pub fn line(&self) -> Option<CrackLine> {
        let level = self.elevation.map(CrackLine::Level);
        level.or_else(|| self.polyline.clone().map(CrackLine::Polyline))
    }

    /// The rule for the water in it, with that of the dam.
    pub fn uplift_rule(&self, of_dam: UpliftRuleScene) -> UpliftRuleScene {
        self.uplift.as_ref().and_then(|uplift| uplift.rule).unwrap_or(of_dam)
    }

    /// The crack as the dam has it, with the dam's rule for uplift.
    pub fn parameters(&self, of_dam: UpliftRuleScene) -> CrackParameters {
        let UpliftScene { rule: _, drains, profile, factor } = self.uplift.clone().unwrap_or_default();
        let drains = drains.map(|DrainsScene { position, efficiency, gallery_elevation }| Drains {
            position,
            efficiency,
            gallery_elevation,
        });
        let uplift = |rule| Uplift { drains, profile, rule, factor };
        CrackParameters { uplift: self.uplift_rule(of_dam).rule().map(uplift), ..self.into() }
    }

    /// What reports call it.
    pub fn label(&self) -> String {
        match &self.name {
            Some(name) => name.clone(),
            None => format!("{} m", (self.mean_elevation() * 1e3).round() / 1e3),
        }
    }

    /// What a sentence calls it: `the crack at 66.5 m`, or `the crack "neck"`.
    pub fn phrase(&self) -> String {
        match &self.name {
            Some(name) => format!("the crack \"{name}\""),
            None => format!("the crack at {}", self.label()),
        }
    }
}

/// Without its water. A crack that is nowhere becomes one without points, which the dam refuses.
impl From<&CrackScene> for CrackParameters {
    fn from(crack: &CrackScene) -> Self {
        let CrackScene {
            name: _,
            // Both are the line.
            elevation: _,
            polyline: _,
            friction_coefficient,
            residual_friction_coefficient,
            cohesion,
            tensile_strength,
            dilation,
            dilation_slip,
            element_size,
            integration,
            normal_stiffness,
            shear_stiffness,
            uplift: _,
            number: _,
        } = *crack;
        Self {
            line: crack.line().unwrap_or_else(|| CrackLine::Polyline(Vec::new())),
            friction_coefficient,
            residual_friction_coefficient,
            cohesion,
            tensile_strength,
            dilation,
            dilation_slip,
            element_size,
            integration,
            normal_stiffness,
            shear_stiffness,
            uplift: None,
        }
    }
}

fn yes() -> bool {
    true
}

fn time_step_safety() -> f64 {
    0.9
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tables and the solver's parameters say the same things: only the crack's name is the scene's own.
    #[test]
    fn tables_and_parameters_have_the_same_keys_and_words() {
        let text = r#"
            name = "neck"
            polyline = [[0.0, 66.5], [10.0, 67.5]]
            friction_coefficient = 1.0
            residual_friction_coefficient = 0.5
            cohesion = 1e5
            tensile_strength = 2e5
            dilation = 0.1
            dilation_slip = 0.01
            element_size = 2.5
            integration = "gauss"
            normal_stiffness = 1e11
            shear_stiffness = 5e10
        "#;
        let crack: CrackScene = toml::from_str(text).expect("a crack");
        let mut given: toml::Table = toml::from_str(text).expect("a table");
        given.remove("name");
        assert_eq!(toml::Table::try_from(CrackParameters::from(&crack)).expect("a table"), given);
        let text = r#"
            young_modulus = 31e9
            poisson_ratio = 0.2
            density = 2640.0
            plane = "strain"
            tensile_strength = 3e6
        "#;
        let material: MaterialScene = toml::from_str(text).expect("a material");
        let given: toml::Table = toml::from_str(text).expect("a table");
        assert_eq!(toml::Table::try_from(Material::from(&material)).expect("a table"), given);
    }
}
