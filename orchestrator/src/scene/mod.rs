//! Scenes: what a run computes, in one TOML file. Strict: unknown keys are errors.
//!
//! Text → `syntax` (sets aside what is no TOML) → `document` (a tree with places, `--set` put in) → `conform`
//! (holds it against the `shape` of the types below, mends what does not fit) → the types → `validate` (values)
//! → `warning` (doubts). Every mistake is found at once; `conform` and `validate` remember what was wrong, so that
//! nothing is said about what rests on it.

mod baseline;
mod conform;
mod document;
mod error;
mod ground_motion;
mod load;
mod record;
mod shape;
mod spectrum;
mod syntax;
mod validate;
mod warning;

pub use error::{Invalid, SceneError, SceneProblem};
pub use ground_motion::GroundMotion;
pub use load::LoadedScene;
pub use record::{Record, RecordError, STANDARD_GRAVITY};
pub use warning::{REST, SceneWarning, Warning};

use crate::acceleration::AccelerationKind;
use crate::convergence::Measure;
use crate::scheme::SchemeKind;
use crate::stepping::{Adaptive, Stepping};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One line for reports.
    pub title: String,
    /// Gravitational acceleration, m/s².
    #[serde(default = "defaults::gravity")]
    pub gravity: f64,
    /// Clock.
    #[serde(default)]
    pub time: Time,
    /// What moves the ground.
    #[serde(default)]
    pub ground_motion: GroundMotionScene,
    /// The water.
    pub reservoir: ReservoirScene,
    /// The dam, if it is computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dam: Option<DamScene>,
    /// The dam, if it moves as told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prescribed: Option<PrescribedScene>,
    /// How the two are coupled.
    #[serde(default)]
    pub coupling: CouplingScene,
    /// What ends a run before its time, or marks it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stop: Vec<StopScene>,
    /// Pictures of the dam while the run goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snapshots: Option<SnapshotsScene>,
}

/// `[snapshots]`
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnapshotsScene {
    /// Time from one to the next, s.
    pub interval: f64,
    /// None before this time, s.
    #[serde(default)]
    pub from: f64,
    /// None after this time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// `[[stop]]`
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopScene {
    /// What is watched, at every communication point.
    pub quantity: StopQuantity,
    /// Value, in SI units, above which its magnitude is too much.
    pub above: f64,
    /// What is done then.
    #[serde(default)]
    pub action: StopAction,
}

/// A quantity that a run is watched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StopQuantity {
    /// Sliding of any crack, m.
    Sliding,
    /// Opening of any crack, m.
    Opening,
    /// Rotation above any crack, rad.
    Rotation,
    /// Displacement of the crest, m.
    CrestDisplacement,
    /// Iterations of a communication step.
    Iterations,
    /// Energy balance error over the peak kinetic energy so far.
    EnergyError,
}

impl StopQuantity {
    /// The word in a scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::Opening => "opening",
            Self::Rotation => "rotation",
            Self::CrestDisplacement => "crest displacement",
            Self::Iterations => "iterations",
            Self::EnergyError => "energy error",
        }
    }

    /// Its unit, with a space before it.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Sliding | Self::Opening | Self::CrestDisplacement => " m",
            Self::Rotation => " rad",
            Self::Iterations | Self::EnergyError => "",
        }
    }

    /// The dam's output that tells it.
    pub fn variable(self) -> Option<&'static str> {
        match self {
            Self::Sliding => Some("crack_sliding"),
            Self::Opening => Some("crack_opening"),
            Self::Rotation => Some("crack_rotation"),
            Self::CrestDisplacement => Some("crest_displacement"),
            Self::EnergyError => Some("energy_balance_error"),
            Self::Iterations => None,
        }
    }
}

/// What is done when a quantity is too much.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StopAction {
    /// The run ends after this communication step.
    #[default]
    End,
    /// The run goes on; its results say so.
    Flag,
}

/// `[time]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Time {
    /// Length H of a communication step, s.
    pub communication_step: f64,
    /// Time without ground motion after the record, s.
    pub quiet: f64,
    /// Simulated time, s; by default the record and `quiet`. A scene that was read has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration: Option<f64>,
    /// Steps whose length follows an error estimate, from `communication_step` on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<AdaptiveScene>,
}

/// `[time.adaptive]`
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveScene {
    /// Largest estimate of the interpolation error, as a share of the largest pressure.
    pub tolerance: f64,
    /// Shortest communication step, s.
    pub shortest: f64,
    /// Longest communication step, s.
    pub longest: f64,
}

/// `[ground_motion]`: one of its two tables.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroundMotionScene {
    /// A record from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordScene>,
    /// A ramp that is then held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<RampScene>,
}

/// `[ground_motion.record]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordScene {
    /// `.csv` (time in s, acceleration in g) or PEER `.at2`, relative to the scene's file.
    pub file: PathBuf,
    /// Factor on the acceleration, 1e-6 to 1e6.
    #[serde(default = "defaults::one")]
    pub scale: f64,
    /// 1: positive accelerations point downstream; −1: upstream.
    #[serde(default = "defaults::polarity")]
    pub polarity: i64,
    /// Where in the record the run begins, s after its first sample.
    #[serde(default)]
    pub start: f64,
    /// Where in the record the motion ends, s after its first sample; by default its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
}

/// `[ground_motion.ramp]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampScene {
    /// Acceleration that is reached and held, m/s², positive downstream.
    pub acceleration: f64,
    /// Time in which it is reached, s.
    pub rise: f64,
}

/// Model of the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FidelityScene {
    /// Westergaard's added mass.
    Westergaard,
    /// Incompressible water by boundary elements: added mass of the real section.
    Incompressible,
    /// Compressible water.
    Compressible,
    /// An empty reservoir.
    #[serde(rename = "none")]
    Empty,
}

impl FidelityScene {
    /// Whether the pressure depends on more than the acceleration of the moment.
    pub fn has_memory(self) -> bool {
        self == Self::Compressible
    }

    /// Whether equations are solved in the water.
    pub fn is_solved(self) -> bool {
        matches!(self, Self::Incompressible | Self::Compressible)
    }

    /// The word in a scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::Westergaard => "westergaard",
            Self::Incompressible => "incompressible",
            Self::Compressible => "compressible",
            Self::Empty => "none",
        }
    }
}

/// Profile of Westergaard's added mass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProfileScene {
    /// ⅞ ρ √(h(h − y)).
    #[default]
    Parabola,
    /// The series of incompressible water before a vertical face, which the parabola approximates.
    Exact,
}

/// Shape functions of the reservoir's boundary elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ElementOrderScene {
    /// One node an element.
    Constant,
    /// Two nodes an element.
    #[default]
    Linear,
}

/// How compressible water is stepped in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MethodScene {
    /// Convolution quadrature by BDF2.
    Bdf2,
    /// Convolution quadrature by the trapezoidal rule.
    Trapezoid,
    /// Convolution quadrature by Radau IIA of two stages.
    #[default]
    Radau2,
    /// Convolution quadrature by Radau IIA of three stages.
    Radau3,
    /// A recursion fitted to the frequency response.
    Recursive,
    /// Finite elements with a Sommerfeld end.
    FiniteElements,
}

/// `[reservoir]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReservoirScene {
    /// Depth of the water, m; an empty reservoir needs none, and with one its wet face ends there all the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
    /// Model of the water.
    #[serde(default = "defaults::fidelity")]
    pub fidelity: FidelityScene,
    /// Profile of Westergaard's added mass.
    #[serde(default)]
    pub profile: ProfileScene,
    /// Density of the water, kg/m³.
    #[serde(default = "defaults::water_density")]
    pub density: f64,
    /// Speed of sound in the water, m/s.
    #[serde(default = "defaults::sound_speed")]
    pub sound_speed: f64,
    /// Wave reflection coefficient α of the bed, 0 to 1.
    #[serde(default = "defaults::one")]
    pub wave_reflection_coefficient: f64,
    /// Corners (x, y) of the bed, m, from the heel upstream; from the last one on it is level. By default level from
    /// the heel on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bed: Vec<[f64; 2]>,
    /// Gravity waves on the surface.
    #[serde(default)]
    pub surface_waves: bool,
    /// How compressible water is stepped in time.
    #[serde(default)]
    pub method: MethodScene,
    /// Largest length of the reservoir's own panels on the wet face, m; by default its points are the dam's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interface_size: Option<f64>,
    /// Largest length of a boundary element, m; by default depth / 16, and not above the panels'.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element_size: Option<f64>,
    /// Shape functions of the boundary elements.
    #[serde(default)]
    pub element_order: ElementOrderScene,
    /// Largest length of an element on bed, far end and meshed surface, m; by default `element_size`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bed_element_size: Option<f64>,
    /// Length of the elements at the corners, m, from where they grow; by default they are not refined.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_element_size: Option<f64>,
    /// Distance of the far end from the face's most upstream point, m; by default depth / 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far_end_distance: Option<f64>,
}

/// `[prescribed]`: a rigid dam that moves with the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedScene {
    /// Horizontal distance by which the wet face leans downstream from heel to water level, m.
    #[serde(default)]
    pub batter: f64,
    /// Number of panels of the wet face.
    #[schemars(range(min = 1, max = 1000))]
    pub panels: usize,
}

/// How much of the dam is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DamFidelityScene {
    /// Every element and every contact.
    #[default]
    Dem,
    /// Blocks of elastic modes between contacts.
    Reduced,
    /// Blocks that do not deform: unsafe.
    RigidBlocks,
    /// Without cracks, by modes.
    Intact,
}

impl DamFidelityScene {
    /// The word in a scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::Dem => "dem",
            Self::Reduced => "reduced",
            Self::RigidBlocks => "rigid-blocks",
            Self::Intact => "intact",
        }
    }

    /// Whether a number of modes means something.
    pub fn has_modes(self) -> bool {
        matches!(self, Self::Reduced | Self::Intact)
    }
}

/// Kind of damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DampingModelScene {
    /// Of mass and stiffness, one ratio at two frequencies.
    #[default]
    Rayleigh,
    /// Of mass, the ratio at the lower one.
    Mass,
    /// Of stiffness, the ratio at the lower one.
    Stiffness,
    /// A share of the force out of balance: about the ratio at all frequencies.
    Local,
}

/// Plane condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneScene {
    /// Plane stress.
    Stress,
    /// Plane strain.
    Strain,
}

/// Kinematics of the elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KinematicsScene {
    /// Small strain and rotation.
    Small,
    /// Small strain, rotation of any size.
    Corotational,
}

/// `[dam]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamScene {
    /// How much is computed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub fidelity: DamFidelityScene,
    /// Number of modes, of each block or of the intact dam; by default as many as an error estimate asks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub modes: Option<usize>,
    /// Nominal length of an element's side, m.
    pub element_size: f64,
    /// Kinematics of the elements.
    #[serde(default = "defaults::kinematics")]
    pub kinematics: KinematicsScene,
    /// Factor on the critical time step, 0 to 1.
    #[serde(default = "defaults::time_step_safety")]
    pub time_step_safety: f64,
    /// Outline.
    pub section: SectionScene,
    /// Concrete.
    pub material: MaterialScene,
    /// Damping; always named, because sliding depends on it more than on anything else.
    pub damping: DampingScene,
    /// Penetrated cracks, horizontal.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cracks: Vec<CrackScene>,
}

/// `[dam.section]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionScene {
    /// Upstream side, (x, y) from the heel (0, 0) up to the crest, m.
    pub upstream: Vec<[f64; 2]>,
    /// Downstream side, (x, y) from the toe up to the crest, m.
    pub downstream: Vec<[f64; 2]>,
}

/// `[dam.material]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialScene {
    /// Elastic modulus, Pa.
    pub young_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Plane condition.
    #[serde(default = "defaults::plane")]
    pub plane: PlaneScene,
}

/// `[dam.damping]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingScene {
    /// Kind.
    #[serde(default, skip_serializing_if = "is_default")]
    pub model: DampingModelScene,
    /// Damping ratio where it holds; 0 for none.
    pub ratio: f64,
    /// The two frequencies as multiples of ω₁ of the intact empty dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub multiples_of_first: Option<[f64; 2]>,
    /// The two frequencies, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radians_per_second: Option<[f64; 2]>,
}

/// Where along a crack the contacts are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntegrationScene {
    /// At the nodes.
    #[default]
    Nodal,
    /// At two Gauss points of each segment.
    Gauss,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// `[[dam.cracks]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackScene {
    /// Elevation above the heel, m.
    pub elevation: f64,
    /// Coulomb friction coefficient; of a bonded crack, or one with another residual friction, its peak.
    pub friction_coefficient: f64,
    /// The same once the crack has slipped or opened; by default no other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_friction_coefficient: Option<f64>,
    /// Cohesion, Pa, until it first slips or opens.
    #[serde(default, skip_serializing_if = "is_default")]
    pub cohesion: f64,
    /// Tensile strength, Pa, until it first slips or opens.
    #[serde(default, skip_serializing_if = "is_default")]
    pub tensile_strength: f64,
    /// Tangent of the dilation angle: rise over slip.
    #[serde(default, skip_serializing_if = "is_default")]
    pub dilation: f64,
    /// Slip, to and fro, after which nothing rises any more, m; by default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dilation_slip: Option<f64>,
    /// Where its contacts are.
    #[serde(default, skip_serializing_if = "is_default")]
    pub integration: IntegrationScene,
    /// Normal stiffness, Pa/m.
    pub normal_stiffness: f64,
    /// Shear stiffness, Pa/m.
    pub shear_stiffness: f64,
}

/// What is done when a communication step does not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnFailure {
    /// The run stops.
    Stop,
    /// The run goes on from the last iteration, and says so; not from a divergence.
    Continue,
    /// The step is begun anew with half its length.
    Halve,
}

/// `[coupling]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CouplingScene {
    /// Scheme; by default `added-mass` for a computed dam in water without memory, else `serial-implicit`. A scene that
    /// was read has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeKind>,
    /// Communication steps that are iterated together.
    #[schemars(range(min = 1, max = 10_000))]
    pub window: usize,
    /// Tolerance ε.
    pub tolerance: f64,
    /// What it is a tolerance of.
    pub measures: Vec<Measure>,
    /// Most iterations a step.
    #[schemars(range(min = 2, max = 100_000))]
    pub iteration_limit: u32,
    /// What is done when they run out, or are in vain.
    pub on_failure: OnFailure,
    /// Acceleration of the iteration.
    pub acceleration: AccelerationKind,
    /// First (Aitken) or constant relaxation factor.
    pub relaxation: f64,
    /// Order of the extrapolation of pressure to the first guess, 0 to 2.
    #[schemars(range(min = 0, max = 2))]
    pub predictor_order: usize,
}

impl Default for Time {
    fn default() -> Self {
        Self { communication_step: 0.0025, quiet: 5.0, duration: None, adaptive: None }
    }
}

impl Default for CouplingScene {
    fn default() -> Self {
        Self {
            scheme: None,
            window: 1,
            tolerance: 1e-6,
            measures: vec![Measure::Pressure],
            iteration_limit: 100,
            on_failure: OnFailure::Stop,
            acceleration: AccelerationKind::InterfaceJacobian,
            relaxation: 0.9,
            predictor_order: 2,
        }
    }
}

mod defaults {
    use super::{FidelityScene, KinematicsScene, PlaneScene};

    pub fn gravity() -> f64 {
        9.81
    }
    pub fn one() -> f64 {
        1.0
    }
    pub fn polarity() -> i64 {
        1
    }
    pub fn water_density() -> f64 {
        1000.0
    }
    pub fn sound_speed() -> f64 {
        1440.0
    }
    pub fn time_step_safety() -> f64 {
        0.9
    }
    pub fn fidelity() -> FidelityScene {
        FidelityScene::Compressible
    }
    pub fn kinematics() -> KinematicsScene {
        KinematicsScene::Corotational
    }
    pub fn plane() -> PlaneScene {
        PlaneScene::Stress
    }
}

impl Scene {
    /// Number of communication steps that reach the end of the simulated time, which a scene that was read has.
    pub fn steps(&self) -> u64 {
        validate::whole_steps(self.time.duration.unwrap_or(0.0) / self.time.communication_step) as u64
    }

    /// The communication steps.
    pub fn stepping(&self) -> Stepping {
        let adaptive = self.time.adaptive.map(|AdaptiveScene { tolerance, shortest, longest }| Adaptive {
            tolerance,
            shortest,
            longest,
        });
        Stepping {
            communication_step: self.time.communication_step,
            steps: self.steps(),
            window: self.coupling.window,
            halve: self.coupling.on_failure == OnFailure::Halve,
            adaptive,
        }
    }

    /// The coupling scheme.
    pub fn scheme(&self) -> SchemeKind {
        let fidelity = self.reservoir.fidelity;
        if fidelity == FidelityScene::Empty {
            // Nothing answers the dam, so nothing is repeated, and the first guess, zero, is right.
            return SchemeKind::SerialExplicit;
        }
        self.coupling.scheme.unwrap_or(match &self.dam {
            Some(_) if !fidelity.has_memory() => SchemeKind::AddedMass,
            _ => SchemeKind::SerialImplicit,
        })
    }

    /// Depth of the water, m; of an empty reservoir, up to where the upstream face is observed: to the crest, if the
    /// scene gives no depth.
    pub fn depth(&self) -> f64 {
        let crest = || self.dam.as_ref().and_then(|dam| dam.section.upstream.last()).map(|top| top[1]);
        self.reservoir.depth.or_else(crest).unwrap_or(f64::NAN)
    }

    /// Largest length of a boundary element of the reservoir, m.
    pub fn boundary_element_size(&self) -> f64 {
        let dam = self.dam.as_ref().map_or(f64::INFINITY, |dam| dam.element_size);
        let panel = self.reservoir.interface_size.unwrap_or(dam);
        self.reservoir.element_size.unwrap_or(panel.min(self.depth() / 16.0))
    }

    /// Distance of the reservoir's far end from the face's most upstream point, m.
    pub fn far_end_distance(&self) -> f64 {
        self.reservoir.far_end_distance.unwrap_or(self.depth() / 2.0)
    }

    /// Hydrostatic pressure ρ g h at the heel, Pa; 0 before an empty reservoir.
    pub fn hydrostatic_base_pressure(&self) -> f64 {
        match self.reservoir.fidelity {
            FidelityScene::Empty => 0.0,
            _ => self.reservoir.density * self.gravity * self.depth(),
        }
    }

    /// Height of the dam, m.
    pub fn height(&self) -> f64 {
        let crest = self.dam.as_ref().and_then(|d| d.section.upstream.last());
        crest.map_or_else(|| self.depth(), |p| p[1])
    }
}
