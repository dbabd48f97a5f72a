//! Units of other programs instead of built-in ones.

use super::{Assembly, AssemblyError};
use crate::log::scene_of;
use crate::participant::{Foreign, Place};
use crate::participant::{Recorded, RecordedError, Recording};
use crate::units::{unit_name, unit_role, variable_prefix, water_side};
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_fmi::import::{Fmu, FmuUnitError, Import};
use cofferdam_log::Log;
use cofferdam_scene::{CommandScene, FmuScene, LogScene, Side, Source};
use cofferdam_shared_memory::{Brief, BriefPoints};

impl<'a> Assembly<'a> {
    /// Who computes a unit.
    pub fn source(&self, id: UnitId) -> Source<'a> {
        let scene = self.scene;
        match water_side(id) {
            None => scene.dam.as_ref().map_or(Source::BuiltIn, |dam| dam.source()),
            Some(side) => scene.water(side).map_or(Source::BuiltIn, |water| water.source()),
        }
    }

    /// Where a unit stands.
    ///
    /// **Errors**: the wet face.
    pub fn place(&self, id: UnitId) -> Result<Place, AssemblyError> {
        let side = water_side(id);
        let face = match side {
            None => self.dam_face(Side::Upstream)?,
            Some(side) => self.water_face(side)?,
        };
        let specific_weight = self.specific_weight(side.unwrap_or(Side::Upstream));
        Ok(Place { role: unit_role(id), face, specific_weight, acceleration: self.source(id).acceleration() })
    }

    /// Another program's unit in its place.
    ///
    /// **Errors**: it does not fit there.
    pub fn adapted(
        &self,
        id: UnitId,
        unit: Box<dyn Participant>,
    ) -> Result<Box<dyn Participant>, AssemblyError> {
        Ok(Box::new(Foreign::new(unit, &self.place(id)?)?))
    }

    /// The FMU in place of unit `id`.
    pub(super) fn imported(&self, id: UnitId, fmu: &FmuScene) -> Result<Box<dyn Participant>, AssemblyError> {
        let FmuScene { file, variables, parameters, .. } = fmu;
        let name = unit_name(id);
        let stop_time = Some(self.scene.stepping().latest_end());
        let import = Import { file, variables, parameters, stop_time };
        let made = Fmu::new(name, unit_role(id), import, self.fixed_step());
        let made = made.map_err(|cause| {
            // What cannot be unpacked is named already.
            let participant = match cause {
                FmuUnitError::Unpack(_) => name.to_owned(),
                _ => format!("{name}: {}", file.display()),
            };
            ParticipantError::Unit { participant, cause: Box::new(cause) }
        })?;
        self.adapted(id, Box::new(made))
    }

    /// The length of all communication steps, s; `None` if they vary by error control.
    pub(super) fn fixed_step(&self) -> Option<f64> {
        let time = &self.scene.time;
        time.adaptive.is_none().then_some(time.communication_step)
    }

    /// What the process of a command is told.
    ///
    /// **Errors**: the wet face.
    pub fn brief(&self, id: UnitId, command: &CommandScene) -> Result<Brief, AssemblyError> {
        let scene = self.scene;
        let Place { role, face, .. } = self.place(id)?;
        let side = water_side(id).unwrap_or(Side::Upstream);
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
    pub(super) fn recorded(&self, id: UnitId, log: &LogScene) -> Result<Box<dyn Participant>, AssemblyError> {
        let name = unit_name(id);
        let of_log = |cause: RecordedError| ParticipantError::Unit {
            participant: name.to_owned(),
            cause: Box::new(cause),
        };
        let log = Log::of_exchanges(&log.file).map_err(|cause| of_log(cause.into()))?;
        let side = water_side(id).unwrap_or(Side::Upstream);
        let past = scene_of(&log).map_err(|cause| of_log(cause.into()))?;
        let face = Assembly::of(&past).dam_face(side)?;
        let recording =
            Recording { unit: id, name, role: unit_role(id), prefix: variable_prefix(side), face };
        let scene = self.scene;
        let end = scene.steps() as f64 * scene.time.communication_step;
        let recorded = Recorded::read(&log, recording).map_err(of_log)?;
        recorded.reaches(end, scene.time.communication_step).map_err(of_log)?;
        Ok(Box::new(recorded))
    }
}
