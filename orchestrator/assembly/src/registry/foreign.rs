//! Units of other programs in the place of built-in ones.

use super::{RegistryError, face_of_dam, face_of_water, prefix, side_of, specific_weights};
use crate::log::scene_of;
use crate::participant::{Foreign, Place};
use crate::participant::{Recorded, RecordedError, Recording};
use crate::units::DAM;
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_fmi::import::{Fmu, FmuUnitError, Import};
use cofferdam_log::Log;
use cofferdam_scene::{CommandScene, FmuScene, LogScene, Scene, Side, Source};
use cofferdam_shared_memory::{Brief, BriefPoints};
use interface::Role;

/// Who computes a unit.
pub fn source(id: UnitId, scene: &Scene) -> Source<'_> {
    match side_of(id) {
        None => scene.dam.as_ref().map_or(Source::BuiltIn, |dam| dam.source()),
        Some(side) => scene.water(side).map_or(Source::BuiltIn, |water| water.source()),
    }
}

/// What a unit is at its interface.
pub fn role(id: UnitId) -> Role {
    if id == DAM { Role::Structure } else { Role::Fluid }
}

/// Where a unit stands.
///
/// **Errors**: the wet face.
pub fn place(id: UnitId, scene: &Scene) -> Result<Place, RegistryError> {
    let side = side_of(id);
    let face = match side {
        None => face_of_dam(scene, Side::Upstream)?,
        Some(side) => face_of_water(scene, side)?,
    };
    let [upstream, downstream] = specific_weights(scene);
    let specific_weight = if side == Some(Side::Downstream) { downstream } else { upstream };
    Ok(Place { role: role(id), face, specific_weight, acceleration: source(id, scene).acceleration() })
}

/// Another program's unit in its place.
///
/// **Errors**: it does not fit there.
pub fn adapted(
    id: UnitId,
    scene: &Scene,
    unit: Box<dyn Participant>,
) -> Result<Box<dyn Participant>, RegistryError> {
    Ok(Box::new(Foreign::new(unit, &place(id, scene)?)?))
}

/// The FMU in the place of unit `id`.
pub(super) fn fmu(id: UnitId, scene: &Scene, fmu: &FmuScene) -> Result<Box<dyn Participant>, RegistryError> {
    let FmuScene { file, variables, parameters, .. } = fmu;
    let name = super::name(id);
    let step = scene.time.adaptive.is_none().then_some(scene.time.communication_step);
    let made = Fmu::new(name, role(id), Import { file, variables, parameters }, step);
    let made = made.map_err(|cause| {
        // What cannot be unpacked is named already.
        let participant = match cause {
            FmuUnitError::Unpack(_) => name.to_owned(),
            _ => format!("{name}: {}", file.display()),
        };
        ParticipantError::Unit { participant, cause: Box::new(cause) }
    })?;
    adapted(id, scene, Box::new(made))
}

/// What the process of a command is told.
///
/// **Errors**: the wet face.
pub fn brief(id: UnitId, scene: &Scene, command: &CommandScene) -> Result<Brief, RegistryError> {
    let Place { role, face, .. } = place(id, scene)?;
    let side = side_of(id).unwrap_or(Side::Upstream);
    Ok(Brief {
        role,
        points: BriefPoints::from(&face),
        depth: face.depth(),
        density: scene.water(side).map_or(0.0, |water| water.density),
        gravity: scene.gravity,
        communication_step: scene.time.communication_step,
        duration: scene.steps() as f64 * scene.time.communication_step,
        acceleration: command.acceleration,
        parameters: command.parameters.clone(),
    })
}

/// What `log` recorded of the other side of the interface of unit `id`.
pub(super) fn recorded(
    id: UnitId,
    scene: &Scene,
    log: &LogScene,
) -> Result<Box<dyn Participant>, RegistryError> {
    let name = super::name(id);
    let of_log = |cause: RecordedError| ParticipantError::Unit {
        participant: name.to_owned(),
        cause: Box::new(cause),
    };
    let log = Log::of_exchanges(&log.file).map_err(|cause| of_log(cause.into()))?;
    let side = side_of(id).unwrap_or(Side::Upstream);
    let face = face_of_dam(&scene_of(&log).map_err(|cause| of_log(cause.into()))?, side)?;
    let recording = Recording { unit: id, name, role: role(id), prefix: prefix(side), face };
    let end = scene.steps() as f64 * scene.time.communication_step;
    let recorded = Recorded::read(&log, recording).map_err(of_log)?;
    recorded.reaches(end, scene.time.communication_step).map_err(of_log)?;
    Ok(Box::new(recorded))
}
