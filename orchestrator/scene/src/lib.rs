//! Scenes: what a run computes, in one TOML file. Strict: unknown keys are errors.
//!
//! Text → `syntax` (sets aside what is no TOML) → `document` (a tree with places, `--set` put in) → `conform`
//! (holds it against the `shape` of the types below, mends what does not fit) → the types → `validate` (what the keys
//! mean together) → `warning` (doubts). Every mistake is found at once; `conform` and `validate` remember what was wrong,
//! so that nothing is said about what rests on it.
//!
//! A key stands once, on its type: one file a table. Unit (`unit`), range (`range`, `exclusiveMinimum`), default and
//! meaning are read from there by the checks, the messages, the [`reference()`] in `scenes/README.md` and the FMUs.
//!
//! ```
//! use cofferdam_scene::{LoadedScene, UnitChecks};
//! use std::path::Path;
//!
//! // `cofferdam_assembly::read_scene` also asks the solvers.
//! let checks = UnitChecks { dam: |_| Vec::new(), reservoir: |_| Vec::new() };
//! let read = |set: &str| LoadedScene::read(Path::new("../../scenes/rigid-dam-ramp"), &[set.to_owned()], &checks);
//!
//! let loaded = read("reservoir.depth=90.0")?;
//! assert_eq!(loaded.scene.depth(), 90.0);
//! assert_eq!(loaded.scene.steps(), 800); // 2 s in steps of 2.5 ms
//! assert_eq!(loaded.scene.hydrostatic_base_pressure(cofferdam_scene::Side::Upstream), 1000.0 * 9.81 * 90.0);
//!
//! let mistake = read("reservoir.depht=90.0").unwrap_err();
//! assert!(format!("{mistake:?}").contains("depth"), "{mistake:?}"); // with its place and the key that is meant
//! # Ok::<(), cofferdam_scene::SceneError>(())
//! ```

mod conform;
mod coupling;
mod dam;
mod document;
mod error;
mod foreign;
mod ground;
mod load;
mod loads;
mod mesh;
pub mod mesh_file;
mod observation;
mod parameter;
mod reference;
mod report;
mod shape;
mod stability;
mod syntax;
mod time;
mod validate;
mod version;
mod warning;
mod water;

pub use cofferdam_dam::contact::Integration;
pub use cofferdam_dam::{DampingModel, Kinematics, Plane};
pub use cofferdam_reservoir::{ElementOrder, Method, Profile};
pub use coupling::{CouplingScene, OnFailure};
pub use dam::{
    CrackScene, DamFidelityScene, DamScene, DampingScene, DrainsScene, MaterialScene, PrescribedScene,
    SectionScene, UpliftRuleScene, UpliftScene, ZoneScene,
};
pub use error::{Invalid, SceneError, SceneProblem};
pub use foreign::{CommandScene, FmuScene, LogScene, Source};
pub use ground::{GroundMotionScene, RampScene, RecordScene, Shock, ShockScene, VerticalScene};
pub use load::LoadedScene;
pub use loads::{AnchorScene, IceScene, LoadsScene, SiltScene, StillTailwaterScene, SurchargeScene};
pub use mesh::MeshScene;
pub use observation::{AccuracyScene, SnapshotsScene, StopAction, StopQuantity, StopScene};
pub use parameter::bounds;
pub use reference::reference;
pub use report::{LimitsScene, ReportScene};
pub use stability::{CombinationScene, RequiredScene, StabilityScene};
pub use time::{AdaptiveScene, Time};
pub use validate::{Refusal, UnitChecks};
pub use version::VERSION;
pub use warning::{
    ELEMENTS_OF_THE_RESERVOIR, REST, SceneWarning, Uplift, Warning, down, shear_wave_velocity, takes_water,
    uplift,
};
pub use water::{FidelityScene, ReservoirScene, Side};

use cofferdam_coupling::scheme::SchemeKind;
use cofferdam_coupling::stepping::{Adaptive, Stepping};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One line for reports.
    pub title: String,
    /// Version of the defaults that the scene was written for. Where a default has changed since, the results say so.
    #[serde(default = "version")]
    #[schemars(range(min = 1, max = VERSION))]
    pub scene_version: u32,
    /// Gravitational acceleration.
    #[serde(default = "gravity")]
    #[schemars(range(min = 0.1, max = 1e4), extend("unit" = "m/s²"))]
    pub gravity: f64,
    /// The clock.
    #[serde(default)]
    pub time: Time,
    /// What moves the ground: either a record or a ramp.
    #[serde(default)]
    pub ground_motion: GroundMotionScene,
    /// The water.
    pub reservoir: ReservoirScene,
    /// Water on the downstream face of the dam. It is computed in the mirror: its depth is measured at the toe, and the
    /// corners of its `bed` are counted from the toe with negative x, as those of the reservoir from the heel. It needs a
    /// `depth` and a `[dam]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("like" = "reservoir"))]
    pub tailwater: Option<ReservoirScene>,
    /// The dam that is computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dam: Option<DamScene>,
    /// Static loads beside weight and water.
    #[serde(default, skip_serializing_if = "is_default")]
    pub loads: LoadsScene,
    /// A rigid dam that moves with the ground, in place of `[dam]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prescribed: Option<PrescribedScene>,
    /// The combinations of loads and the criteria of `cofferdam stability` and the report.
    #[serde(default, skip_serializing_if = "is_default")]
    pub stability: StabilityScene,
    /// What the report says about the project, and the limits that it judges the results by.
    #[serde(default, skip_serializing_if = "is_default")]
    pub report: ReportScene,
    /// How the units are coupled.
    #[serde(default)]
    pub coupling: CouplingScene,
    /// The accuracy for which `run` chooses the numerics, as with `--accuracy`; other commands take the scene as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyScene>,
    /// Limits that end a run before its time, or mark it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stop: Vec<StopScene>,
    /// Pictures of the dam's fields during the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snapshots: Option<SnapshotsScene>,
    /// What the log holds besides the exchanges.
    #[serde(default)]
    pub log: cofferdam_log::Content,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn version() -> u32 {
    VERSION
}

fn gravity() -> f64 {
    9.81
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

    /// Whether a run may take communication steps of other lengths.
    pub fn has_varying_steps(&self) -> bool {
        self.time.adaptive.is_some() || self.coupling.on_failure == OnFailure::Halve
    }

    /// The coupling scheme.
    pub fn scheme(&self) -> SchemeKind {
        if !self.has_water() || self.is_open_loop() {
            // Nothing answers the dam, or what answers is known beforehand: nothing is repeated.
            return SchemeKind::SerialExplicit;
        }
        let memory = self.waters().any(|(_, water)| water.fidelity.has_memory());
        self.coupling.scheme.unwrap_or(match &self.dam {
            Some(dam) if !memory && !dam.fidelity.is_foreign() && !self.bed_presses() => SchemeKind::OneWay,
            _ => SchemeKind::SerialImplicit,
        })
    }

    /// Whether the bed moves into water without memory, as it does under vertical motion or where it slopes: the pressure −A_g a_g on
    /// the dam is not that of a mass of the dam, so that the scheme `added-mass` lacks it.
    pub fn bed_presses(&self) -> bool {
        let vertical = self.ground_motion.has_vertical();
        let moved = |water: &ReservoirScene| {
            water.fidelity.is_memoryless()
                && water.fidelity.is_solved()
                && (vertical || !water.bed.is_empty())
        };
        self.waters().any(|(_, water)| !water.is_empty() && moved(water))
    }

    /// Who computes the units, in their order.
    pub fn sources(&self) -> Vec<Source<'_>> {
        let dam = self.dam.as_ref().map_or(Source::BuiltIn, |dam| dam.source());
        std::iter::once(dam).chain(self.waters().map(|(_, water)| water.source())).collect()
    }

    /// Whether one of the units is a run of the past, so that the loop is open.
    pub fn is_open_loop(&self) -> bool {
        let dam = self.dam.as_ref().is_some_and(|dam| dam.fidelity.is_recorded());
        dam || self.waters().any(|(_, water)| water.fidelity.is_recorded())
    }

    /// The dam that this program computes: it is neither prescribed nor another program's.
    pub fn computed_dam(&self) -> Option<&DamScene> {
        self.dam.as_ref().filter(|dam| !dam.fidelity.is_foreign())
    }

    /// Whether this program does not compute one of the waters.
    pub fn has_foreign_water(&self) -> bool {
        self.waters().any(|(_, water)| water.fidelity.is_foreign())
    }

    /// The water on a side of the dam, filled or not.
    pub fn water(&self, side: Side) -> Option<&ReservoirScene> {
        match side {
            Side::Upstream => Some(&self.reservoir),
            Side::Downstream => self.tailwater.as_ref(),
        }
    }

    /// The reservoir, filled or not, and the tailwater, if there is one.
    pub fn waters(&self) -> impl Iterator<Item = (Side, &ReservoirScene)> {
        Side::BOTH.into_iter().filter_map(|side| Some((side, self.water(side)?)))
    }

    /// Whether there is water on any side.
    pub fn has_water(&self) -> bool {
        self.waters().any(|(_, water)| !water.is_empty())
    }

    /// Depth of the water, m; of an empty reservoir, up to where the upstream face is observed: to the crest, if the
    /// scene gives no depth.
    pub fn depth(&self) -> f64 {
        let crest = || self.dam.as_ref().and_then(|dam| dam.section.upstream.last()).map(|top| top[1]);
        self.reservoir.depth.or_else(crest).unwrap_or(f64::NAN)
    }

    /// Depth of the water on a side, m; NaN where there is none.
    pub fn depth_of(&self, side: Side) -> f64 {
        match side {
            Side::Upstream => self.depth(),
            Side::Downstream => self.tailwater.as_ref().and_then(|water| water.depth).unwrap_or(f64::NAN),
        }
    }

    /// Largest length of a boundary element of the water on a side, m.
    pub fn boundary_element_size(&self, side: Side) -> f64 {
        let depth = self.depth_of(side);
        let water = self.water(side);
        let panel_of_dam = match (&self.dam, &self.prescribed) {
            (Some(dam), _) => dam.element_size,
            (None, Some(prescribed)) => prescribed.batter.hypot(depth) / prescribed.panels as f64,
            (None, None) => f64::INFINITY,
        };
        let panel = water.and_then(|water| water.interface_size).unwrap_or(panel_of_dam);
        water.and_then(|water| water.element_size).unwrap_or(panel.min(depth / 16.0))
    }

    /// Distance of the far end of the water on a side from the face's most distant point, m.
    pub fn far_end_distance(&self, side: Side) -> f64 {
        let given = self.water(side).and_then(|water| water.far_end_distance);
        given.unwrap_or(self.depth_of(side) / 2.0)
    }

    /// Hydrostatic pressure ρ g h at the base of the water on a side, Pa; 0 without water.
    pub fn hydrostatic_base_pressure(&self, side: Side) -> f64 {
        match self.water(side) {
            Some(water) if !water.is_empty() => water.density * self.gravity * self.depth_of(side),
            _ => 0.0,
        }
    }

    /// The larger hydrostatic pressure of both waters, Pa.
    pub fn largest_hydrostatic_pressure(&self) -> f64 {
        Side::BOTH.into_iter().map(|side| self.hydrostatic_base_pressure(side)).fold(0.0, f64::max)
    }

    /// Height of the dam, m.
    pub fn height(&self) -> f64 {
        let crest = self.dam.as_ref().and_then(|d| d.section.upstream.last());
        crest.map_or_else(|| self.depth(), |p| p[1])
    }
}
