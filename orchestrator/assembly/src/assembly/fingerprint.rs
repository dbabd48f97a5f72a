//! What units are made from, without making them: no operator is assembled.

use super::{Assembly, AssemblyError, WaterMass};
use crate::participant::Place;
use crate::units::{unit_name, water_side};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::{CouplingScene, Scene, Side, Source};
use cofferdam_unit::Fingerprint;

impl Assembly<'_> {
    /// Hash of what unit number `id` of a scene is made from: scenes with the same make the same unit.
    ///
    /// **Errors**: those of the unit's parameters.
    pub fn fingerprint(&self, id: UnitId) -> Result<Fingerprint, AssemblyError> {
        let scene = self.scene;
        match self.source(id) {
            Source::BuiltIn => self.built_in(id),
            Source::Fmu(fmu) => {
                let Place { face, specific_weight, acceleration, .. } = self.place(id)?;
                let step = self.fixed_step();
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
                Ok(Fingerprint::of("log", &(log, self.place(id)?.face, steps))?)
            }
            Source::Untold(_) => Err(AssemblyError::Process { unit: unit_name(id) }),
        }
    }

    /// Of a unit that this program computes.
    fn built_in(&self, id: UnitId) -> Result<Fingerprint, AssemblyError> {
        let scene = self.scene;
        match (water_side(id), &scene.dam) {
            (None, Some(dam)) => {
                let mut waters = Vec::new();
                if self.scheme_mass() == WaterMass::Exact {
                    for side in Side::BOTH.into_iter().filter(|&side| self.filled(side).is_some()) {
                        waters.push(self.parameters_at(self.dam_face(side)?)?);
                    }
                }
                Ok(Fingerprint::of("dam", &(self.dry_dam(dam)?, waters))?)
            }
            (None, None) => Ok(Fingerprint::of("prescribed", &self.dam_face(Side::Upstream)?)?),
            (Some(Side::Upstream), _) if scene.reservoir.is_empty() => {
                Ok(Fingerprint::of("empty", &self.dam_face(Side::Upstream)?)?)
            }
            (Some(side), _) => Ok(Fingerprint::of("water", &self.water_parameters(side)?)?),
        }
    }
}
