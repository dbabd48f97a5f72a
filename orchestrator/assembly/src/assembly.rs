//! From a scene to its units, in this process.
//!
//! [`Assembly`] is the one type that maps scenes to solvers: parameters of the dam (`dam`) and of the waters (`water`), units of
//! other programs (`foreign`), what is known before a run (`previews`, `cracks`, `stability`), fingerprints (`fingerprint`), and the objections of the
//! units to a scene (`refusals`).

use crate::cache::Cache;
use crate::participant::{EmptyReservoir, Prescribed};
use crate::units::{DAM, RESERVOIR, TAILWATER, unit_name, variable_prefix, water_unit, wet_face_interface};
use cofferdam_coupling::participant::Participant;
use cofferdam_coupling::scheme::{Graph, Interface, Port, UnitId};
use cofferdam_scene::{CommandScene, Scene, Side, Source};
use std::num::NonZeroUsize;

mod cracks;
mod dam;
mod error;
mod fingerprint;
mod foreign;
mod paper;
mod previews;
mod refusals;
mod stability;
mod water;
mod water_field;

pub use cracks::{Equilibrium, UpliftEffect};
pub use dam::WaterMass;
pub use error::AssemblyError;
pub use refusals::read_scene;
pub use stability::{JointStability, Verdict};
pub(crate) use water::block_diagonal;

/// Makes the units of a scene, and tells what is known of them before they are made.
#[derive(Clone, Copy, Debug)]
pub struct Assembly<'a> {
    scene: &'a Scene,
    making: Making<'a>,
}

/// With what units are made; from a number of threads, without a cache.
#[derive(Clone, Copy, Debug)]
pub struct Making<'a> {
    /// Threads for what is prepared, and for large meshes of the dam; results do not depend on their number, bit for bit.
    pub threads: NonZeroUsize,
    /// Where operators of the water are kept for the next time.
    pub cache: Option<&'a Cache>,
}

impl From<NonZeroUsize> for Making<'_> {
    fn from(threads: NonZeroUsize) -> Self {
        Self { threads, cache: None }
    }
}

/// Where a unit runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Home<'a> {
    /// In the orchestrator, because it computes nothing.
    Here,
    /// In a process of this program, unless the user wants it here.
    Process,
    /// In a process of another program, always.
    Command(&'a CommandScene),
}

impl<'a> Assembly<'a> {
    /// Of `scene`; units are made on one thread and without a cache.
    pub fn of(scene: &'a Scene) -> Self {
        Self::with(scene, NonZeroUsize::MIN)
    }

    /// Of `scene`, with a number of threads or a whole [`Making`].
    pub fn with(scene: &'a Scene, making: impl Into<Making<'a>>) -> Self {
        Self { scene, making: making.into() }
    }

    /// The units, each at the place of its number: the dam, the reservoir and, if there is one, the tailwater.
    pub fn units(&self) -> Vec<UnitId> {
        std::iter::once(DAM).chain(self.scene.waters().map(|(side, _)| water_unit(side))).collect()
    }

    /// The interfaces of the dam with its waters.
    pub fn interfaces(&self) -> Vec<Interface> {
        // The inertia of the water column.
        let inertia = self.scene.reservoir.density * self.scene.depth();
        let interface = |(side, _)| {
            let structure = Port { unit: DAM, prefix: variable_prefix(side).to_owned() };
            wet_face_interface(structure, Port::of(water_unit(side)), inertia)
        };
        self.scene.waters().map(interface).collect()
    }

    /// The units in this process, connected.
    ///
    /// **Errors**: a unit that cannot be made.
    pub fn graph(&self) -> Result<Graph, AssemblyError> {
        let units = self.units().into_iter().map(|id| self.unit(id)).collect::<Result<_, _>>()?;
        Ok(Graph::new(units, self.interfaces())?)
    }

    /// Makes unit number `id` of a scene that has been loaded, in this process.
    ///
    /// **Errors**: those of the unit; [`AssemblyError::Process`] for one that is a process of another program.
    pub fn unit(&self, id: UnitId) -> Result<Box<dyn Participant>, AssemblyError> {
        let scene = self.scene;
        match self.source(id) {
            Source::BuiltIn => (),
            Source::Fmu(fmu) => return self.imported(id, fmu),
            Source::Log(log) => return self.recorded(id, log),
            Source::Command(_) | Source::Untold(_) => {
                return Err(AssemblyError::Process { unit: unit_name(id) });
            }
        }
        match (id, &scene.dam) {
            (DAM, Some(_)) => self.dam_participant(),
            (DAM, None) => Ok(Box::new(Prescribed::new(self.dam_face(Side::Upstream)?)?)),
            (RESERVOIR, _) if scene.reservoir.is_empty() => {
                Ok(Box::new(EmptyReservoir::new(self.dam_face(Side::Upstream)?)?))
            }
            (RESERVOIR, _) => self.water_participant(Side::Upstream),
            (TAILWATER, _) if scene.tailwater.is_some() => self.water_participant(Side::Downstream),
            (UnitId(number), _) => Err(AssemblyError::NoUnit { number }),
        }
    }

    /// Where a unit runs.
    pub fn home(&self, id: UnitId) -> Home<'a> {
        match self.source(id) {
            Source::Command(command) => Home::Command(command),
            Source::Log(_) => Home::Here,
            _ if id == RESERVOIR && self.scene.reservoir.is_empty() => Home::Here,
            _ => Home::Process,
        }
    }

    /// Whether unit number `id` can continue from a state of the same unit of the scene `before`, though it is another unit: it is
    /// the dam, and only the strength of its cracks differs.
    pub fn continues_state_of(&self, before: &Scene, id: UnitId) -> bool {
        let after = self.scene;
        let (Some(old), Some(new)) = (&before.dam, &after.dam) else { return false };
        let mut stronger = old.clone();
        for (crack, other) in stronger.cracks.iter_mut().zip(&new.cracks) {
            crack.friction_coefficient = other.friction_coefficient;
            crack.residual_friction_coefficient = other.residual_friction_coefficient;
            (crack.cohesion, crack.tensile_strength) = (other.cohesion, other.tensile_strength);
        }
        let dam_as_before = Scene {
            dam: before.dam.clone(),
            coupling: before.coupling.clone(),
            stop: before.stop.clone(),
            snapshots: before.snapshots,
            log: before.log,
            ..after.clone()
        };
        id == DAM && !new.fidelity.is_foreign() && stronger == *new && dam_as_before == *before
    }
}
