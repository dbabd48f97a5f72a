//! What is known of a scene's units before a run.

use super::water::cache_key;
use super::{Assembly, AssemblyError, Making, WaterMass};
use crate::units;
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_dam::{Dam, LimitingPart, Mesh, NaturalModes};
use cofferdam_scene::Side;
use nalgebra::Complex;
use std::time::Instant;

impl Assembly<'_> {
    /// The mesh of the dam, if this program computes it.
    ///
    /// **Errors**: those of the dam.
    pub fn dam_mesh(&self) -> Result<Option<Mesh>, AssemblyError> {
        self.scene.computed_dam().map(|dam| Ok(self.dry_dam(dam)?.mesh()?)).transpose()
    }

    /// What limits the time step of the dam (s), and its largest time step; `None` below the full model, and for a dam that this program
    /// does not compute.
    ///
    /// **Errors**: those of the dam.
    pub fn limiting_part(&self) -> Result<Option<(LimitingPart, f64)>, AssemblyError> {
        if !self.scene.dam.as_ref().is_some_and(|dam| dam.fidelity.has_elements()) {
            return Ok(None);
        }
        let dam = Dam::new(self.dam_parameters(self.scheme_mass())?)?;
        Ok(dam.limiting_part().map(|part| (*part, dam.time_step_limit())))
    }

    /// The `count` lowest natural modes of the dam on an empty reservoir, if this program computes it.
    ///
    /// **Errors**: those of the dam.
    pub fn natural_modes(&self, count: usize) -> Result<Option<NaturalModes>, AssemblyError> {
        self.scene.computed_dam().map(|dam| Ok(self.dry_dam(dam)?.natural_modes(count)?)).transpose()
    }

    /// The natural modes of the dam with the mass of the waters of the scene, those with a memory as if they were incompressible; none without water, or
    /// beside water that is another program's.
    ///
    /// **Errors**: those of the dam, and of the reservoir that the mass is taken from.
    pub fn natural_modes_in_water(&self, count: usize) -> Result<Option<NaturalModes>, AssemblyError> {
        if self.scene.computed_dam().is_none() || !self.has_computed_waters() {
            return Ok(None);
        }
        Ok(Some(self.dam_parameters(WaterMass::Still)?.natural_modes(count)?))
    }

    /// Whether there is water, and this program computes all of it.
    pub(super) fn has_computed_waters(&self) -> bool {
        self.scene.has_water() && !self.scene.has_foreign_water()
    }

    /// Estimated time of making the convolutions of a scene's waters on this machine, s: that of one frequency, times the number
    /// of frequencies that are usually needed; 0 of what is in the cache. None if no water is made that way: then it is a matter of
    /// a second.
    ///
    /// **Errors**: those of the reservoir.
    pub fn preparation_time(&self) -> Result<Option<f64>, AssemblyError> {
        let Making { threads, cache } = self.making;
        let mut sum = None;
        for side in Side::BOTH.into_iter().filter(|&side| self.computes_water(side)) {
            let parameters = self.water_parameters(side)?;
            let Some(frequencies) = cofferdam_reservoir::usual_frequencies(&parameters) else { continue };
            let sum = sum.get_or_insert(0.0);
            let key = cache_key(&parameters)?;
            if cache.is_some_and(|cache| cache.holds(&key)) {
                continue;
            }
            let system = cofferdam_reservoir::boundary_system(&parameters)?;
            let began = Instant::now();
            system.symbol(Complex::new(1.0, 1.0) / parameters.communication_step)?;
            *sum += began.elapsed().as_secs_f64() * frequencies as f64 / threads.get() as f64;
        }
        Ok(sum)
    }

    /// Hydrostatic pressure at the points of the dam's wet faces, ρg(h − y), Pa, with the name of the dam's variable: what the
    /// waters of a scene give its dam before the ground moves.
    ///
    /// **Errors**: the wet face.
    pub fn hydrostatic_pressure(&self) -> Result<Vec<(String, Vec<f64>)>, AssemblyError> {
        let mut found = Vec::new();
        for (side, _) in self.scene.waters() {
            let (face, specific_weight) = (self.dam_face(side)?, self.specific_weight(side));
            let pressure = face.points().iter().map(|[_, y]| specific_weight * (face.depth() - y)).collect();
            found.push((format!("{}hydrostatic_pressure", units::variable_prefix(side)), pressure));
        }
        Ok(found)
    }

    /// The inputs of `dam` at rest, with the same pressure at the points that it has itself.
    ///
    /// **Errors**: the dam does not tell its points.
    pub fn inputs_at_rest(&self, dam: &mut dyn Participant) -> Result<Vec<f64>, ParticipantError> {
        let mut inputs = vec![0.0; dam.description().inputs.size()];
        for (side, _) in self.scene.waters() {
            let specific_weight = self.specific_weight(side);
            let of_side = |name: &str| format!("{}{name}", units::variable_prefix(side));
            let Some(range) = dam.description().inputs.range(&of_side("hydrostatic_pressure")) else {
                continue;
            };
            let (depth, elevations) = (self.scene.depth_of(side), dam.read(&of_side("interface_y"))?);
            for (pressure, y) in inputs[range].iter_mut().zip(elevations) {
                *pressure = specific_weight * (depth - y);
            }
        }
        Ok(inputs)
    }
}
