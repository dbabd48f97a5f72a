//! What units are made from, without making them: no operator is assembled.

use super::{
    RegistryError, WaterMass, dry_dam, face_of_dam, is_empty, parameters_of_water, place, side_of, source,
};
use super::{filled, name, reservoir_parameters, wet_face};
use crate::participant::Place;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::{CouplingScene, Scene, Side, Source};
use interface::Fingerprint;

/// Hash of what unit number `id` of a scene is made from: scenes with the same make the same unit.
///
/// **Errors**: those of the unit's parameters.
pub fn made_from(id: UnitId, scene: &Scene) -> Result<Fingerprint, RegistryError> {
    match source(id, scene) {
        Source::BuiltIn => built_in(id, scene),
        Source::Fmu(fmu) => {
            let Place { face, specific_weight, acceleration, .. } = place(id, scene)?;
            let step = scene.time.adaptive.is_none().then_some(scene.time.communication_step);
            Ok(Fingerprint::of("fmu", &(fmu, face, specific_weight, acceleration, step))?)
        }
        // It is told all of the scene, and what it reads is not known; the coupling is no matter of a unit.
        Source::Command(_) => {
            let told = Scene {
                coupling: CouplingScene::default(),
                stop: Vec::new(),
                snapshots: None,
                ..scene.clone()
            };
            Ok(Fingerprint::of("command", &told)?)
        }
        Source::Log(log) => {
            let steps = (scene.steps(), scene.time.communication_step);
            Ok(Fingerprint::of("log", &(log, place(id, scene)?.face, steps))?)
        }
        Source::Untold(_) => Err(RegistryError::Process { unit: name(id) }),
    }
}

fn built_in(id: UnitId, scene: &Scene) -> Result<Fingerprint, RegistryError> {
    match (side_of(id), &scene.dam) {
        (None, Some(dam)) => {
            let mut waters = Vec::new();
            if WaterMass::of(scene) == WaterMass::Exact {
                for side in Side::BOTH.into_iter().filter(|&side| filled(scene, side).is_some()) {
                    waters.push(reservoir_parameters(scene, face_of_dam(scene, side)?)?);
                }
            }
            Ok(Fingerprint::of("dam", &(dry_dam(dam, scene)?, waters))?)
        }
        (None, None) => Ok(Fingerprint::of("prescribed", &wet_face(scene)?)?),
        (Some(Side::Upstream), _) if is_empty(scene) => Ok(Fingerprint::of("empty", &wet_face(scene)?)?),
        (Some(side), _) => Ok(Fingerprint::of("water", &parameters_of_water(scene, side)?)?),
    }
}
