//! `[reservoir]` and `[tailwater]`: the water.

use super::foreign::{CommandScene, FmuScene, LogScene, Source};
use cofferdam_reservoir::{ElementOrder, Fidelity, Method, Profile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The water.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReservoirScene {
    /// Depth of the water, not above the crest. An empty reservoir needs none: the wet face, whose motion is reported,
    /// then reaches the crest. If a depth is given, the wet face and a row of elements end at that level.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e4), extend("unit" = "m", "otherwise" = "required"))]
    pub depth: Option<f64>,
    /// Model of the water.
    #[serde(default)]
    pub fidelity: FidelityScene,
    /// Profile of Westergaard's added mass.
    #[serde(default)]
    pub profile: Profile,
    /// Density of the water.
    #[serde(default = "density")]
    #[schemars(range(min = 100, max = 1e5), extend("unit" = "kg/m³"))]
    pub density: f64,
    /// Speed of sound in the water.
    #[serde(default = "sound_speed")]
    #[schemars(range(min = 1, max = 1e5), extend("unit" = "m/s"))]
    pub sound_speed: f64,
    /// Wave reflection coefficient α of the bed: 0 absorbs, 1 is rigid.
    #[serde(default = "rigid")]
    #[schemars(range(min = 0, max = 1))]
    pub wave_reflection_coefficient: f64,
    /// Corners (x, y) of the bed from the heel upstream, without the heel itself. From the last one on the bed is level.
    /// `[[-80.0, 15.0]]` rises by 15 m over the first 80 m.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("unit" = "m", "otherwise" = "level"))]
    pub bed: Vec<[f64; 2]>,
    /// Gravity waves on the surface; without them its pressure is 0. Not with `"incompressible"`.
    #[serde(default)]
    pub surface_waves: bool,
    /// How compressible water is stepped in time.
    #[serde(default)]
    pub method: Method,
    /// Largest length of the reservoir's own panels on the wet face, not above the depth. Kinks and cracks are kept. An
    /// FMU of the reservoir has these points too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4), extend("unit" = "m", "otherwise" = "the dam's points"))]
    pub interface_size: Option<f64>,
    /// Largest length of a boundary element on the wet face.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4), extend(
        "unit" = "m",
        "otherwise" = "depth / 16, not above `interface_size` or the dam's panels"
    ))]
    pub element_size: Option<f64>,
    /// Shape functions of the boundary elements.
    #[serde(default)]
    pub element_order: ElementOrder,
    /// Largest length of an element on bed, far end and, with waves, surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4), extend("unit" = "m", "otherwise" = "`element_size`"))]
    pub bed_element_size: Option<f64>,
    /// Length of the elements at the corners of face and bed. From there each element is at most twice as long as the one
    /// before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4), extend("unit" = "m", "otherwise" = "not refined"))]
    pub corner_element_size: Option<f64>,
    /// Distance of the far end from the most upstream point of face and bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e6), extend("unit" = "m", "otherwise" = "depth / 2"))]
    pub far_end_distance: Option<f64>,
    /// An FMU that computes the water; with `fidelity = "fmu"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fmu: Option<FmuScene>,
    /// A process that computes the water; with `fidelity = "command"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<CommandScene>,
    /// An earlier run whose pressure loads the dam; with `fidelity = "log"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<LogScene>,
}

impl ReservoirScene {
    /// Who computes the water.
    pub fn source(&self) -> Source<'_> {
        Source::of(&self.fidelity.word(), (&self.fmu, &self.command, &self.log))
    }

    /// Whether there is no water.
    pub fn is_empty(&self) -> bool {
        self.fidelity.is_empty()
    }

    /// The solver's model; `None` without water, and for water of another program or of a past run.
    pub fn solver(&self) -> Option<Fidelity> {
        self.fidelity.solver(self.profile)
    }

    /// Whether it is stepped by a recursion, or may be.
    pub fn may_be_recursive(&self) -> bool {
        self.fidelity.is_compressible()
            && (self.method == Method::Automatic || self.method.supports_variable_steps())
    }

    /// Whether all communication steps must have the same length. Other programs say themselves what they can.
    pub fn needs_equal_steps(&self) -> bool {
        self.fidelity.is_compressible() && !self.may_be_recursive()
    }
}

/// The side of the dam that water is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The reservoir.
    Upstream,
    /// The tailwater.
    Downstream,
}

impl Side {
    /// Both, in the order of their units.
    pub const BOTH: [Self; 2] = [Self::Upstream, Self::Downstream];

    /// The water's table in a scene, which is also the name of its unit.
    pub fn table(self) -> &'static str {
        match self {
            Self::Upstream => "reservoir",
            Self::Downstream => "tailwater",
        }
    }

    /// The path of a key of the water's table.
    pub fn key(self, name: &str) -> String {
        format!("{}.{name}", self.table())
    }
}

/// Model of the water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FidelityScene {
    /// Westergaard's added mass, without memory.
    Westergaard,
    /// Incompressible water by boundary elements: the added mass of the real section, without memory.
    Incompressible,
    /// Compressible water.
    #[default]
    Compressible,
    /// An empty reservoir: the dam alone, with one dam step per communication step, regardless of `[coupling]`.
    #[serde(rename = "none")]
    Empty,
    /// An FMU from another program: `[reservoir.fmu]`. Depth, density and wet face stay those of the scene.
    Fmu,
    /// A process of another program: `[reservoir.command]`.
    Command,
    /// The pressure recorded in the log of an earlier run, as its dam received it: `[reservoir.log]`; never iterated.
    Log,
}

impl FidelityScene {
    /// The word in a scene.
    pub fn word(self) -> String {
        super::shape::word(&self)
    }

    /// The solver's model, of Westergaard's added mass with this profile; `None` without water, and for water of another
    /// program or of a past run.
    pub fn solver(self, profile: Profile) -> Option<Fidelity> {
        match self {
            Self::Westergaard => Some(Fidelity::westergaard(profile)),
            Self::Incompressible => Some(Fidelity::Incompressible),
            Self::Compressible => Some(Fidelity::Compressible),
            Self::Empty | Self::Fmu | Self::Command | Self::Log => None,
        }
    }

    /// The solver's model, whatever the profile.
    fn computed(self) -> Option<Fidelity> {
        self.solver(Profile::default())
    }

    /// Whether the pressure depends on more than the acceleration of the moment, or may do so.
    pub fn has_memory(self) -> bool {
        self.computed().map_or(self.is_foreign(), Fidelity::has_memory)
    }

    /// Whether there is no water.
    pub fn is_empty(self) -> bool {
        self == Self::Empty
    }

    /// Whether this program computes compressible water.
    pub fn is_compressible(self) -> bool {
        self.computed() == Some(Fidelity::Compressible)
    }

    /// Whether this program computes water without memory.
    pub fn is_memoryless(self) -> bool {
        self.computed().is_some_and(|model| !model.has_memory())
    }

    /// Whether it is the formula of Westergaard's added mass.
    pub fn is_formula(self) -> bool {
        self.computed().is_some_and(|model| !model.is_solved())
    }

    /// Whether it is that of a past run.
    pub fn is_recorded(self) -> bool {
        self == Self::Log
    }

    /// Whether this program does not compute it.
    pub fn is_foreign(self) -> bool {
        !self.is_empty() && self.computed().is_none()
    }

    /// Whether equations are solved in the water.
    pub fn is_solved(self) -> bool {
        self.computed().is_some_and(Fidelity::is_solved)
    }
}

pub(super) fn density() -> f64 {
    1000.0
}

pub(super) fn sound_speed() -> f64 {
    1440.0
}

fn rigid() -> f64 {
    1.0
}
