//! The waters of a scene, and the faces that they share with the dam.

use super::{Assembly, AssemblyError, Making};
use cofferdam_coupling::participant::{InProcess, Messages, Participant};
use cofferdam_reservoir::{Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters, added_mass};
use cofferdam_scene::{ReservoirScene, Side};
use cofferdam_unit::{Fingerprint, Packable, WetFace};
use nalgebra::DMatrix;

impl Assembly<'_> {
    /// The parameters of the water on a side, at its own points.
    ///
    /// **Errors**: [`AssemblyError::Empty`], [`AssemblyError::Foreign`], and the wet face.
    pub fn water_parameters(&self, side: Side) -> Result<ReservoirParameters, AssemblyError> {
        self.parameters_at(self.water_face(side)?)
    }

    /// The parameters of the water on a side at the dam's points, also if it has its own.
    ///
    /// **Errors**: those of [`water_parameters`](Self::water_parameters).
    pub(crate) fn water_parameters_at_dam(&self, side: Side) -> Result<ReservoirParameters, AssemblyError> {
        self.parameters_at(self.dam_face(side)?)
    }

    /// The parameters of the water before `wet_face`: of the tailwater, if that is downstream.
    ///
    /// **Errors**: [`AssemblyError::Empty`].
    pub(super) fn parameters_at(&self, wet_face: WetFace) -> Result<ReservoirParameters, AssemblyError> {
        let scene = self.scene;
        let side = if wet_face.is_downstream() { Side::Downstream } else { Side::Upstream };
        let water = scene.water(side).ok_or(AssemblyError::Empty)?;
        let communication_step = scene.time.communication_step;
        let fidelity = match water.solver() {
            Some(fidelity) => fidelity,
            None if water.is_empty() => return Err(AssemblyError::Empty),
            None => return Err(AssemblyError::Foreign { fidelity: water.fidelity.word() }),
        };
        let ReservoirScene {
            density,
            sound_speed,
            wave_reflection_coefficient,
            bed,
            surface_waves,
            method,
            element_order,
            bed_element_size,
            corner_element_size,
            // The wet face, the model and the sizes, which depend on other tables too.
            depth: _,
            fidelity: _,
            profile: _,
            interface_size: _,
            element_size: _,
            far_end_distance: _,
            // Other programs' water.
            fmu: _,
            command: _,
            log: _,
        } = water;
        // A formula knows neither waves nor a bed.
        let solved = fidelity.is_solved();
        Ok(ReservoirParameters {
            density: *density,
            sound_speed: *sound_speed,
            wave_reflection_coefficient: *wave_reflection_coefficient,
            gravity: scene.gravity,
            fidelity,
            surface_waves: solved && *surface_waves,
            bed: if solved { bed.clone() } else { Vec::new() },
            element_order: *element_order,
            element_size: scene.boundary_element_size(side),
            bed_element_size: *bed_element_size,
            corner_element_size: *corner_element_size,
            far_end_distance: scene.far_end_distance(side),
            communication_step,
            horizon: scene.steps() as f64 * communication_step,
            method: match method {
                Method::Automatic if scene.has_varying_steps() => Method::Recursive,
                method => *method,
            },
            ..ReservoirParameters::before(wet_face)
        })
    }

    /// The wet face of the water on a side: the dam's, divided again if the scene gives the water panels of its own.
    pub fn water_face(&self, side: Side) -> Result<WetFace, AssemblyError> {
        let face = self.dam_face(side)?;
        Ok(match self.scene.water(side).and_then(|water| water.interface_size) {
            Some(size) => face.respaced(size)?,
            None => face,
        })
    }

    /// The dam's wet face on a side.
    ///
    /// **Errors**: [`AssemblyError::Empty`] for a side without water, and the wet face.
    pub fn dam_face(&self, side: Side) -> Result<WetFace, AssemblyError> {
        let scene = self.scene;
        if side == Side::Downstream {
            let dam = scene.dam.as_ref().ok_or(AssemblyError::Empty)?;
            return self.dry_dam(dam)?.tailwater_face()?.ok_or(AssemblyError::Empty);
        }
        let depth = scene.depth();
        let straight = |batter, panels| WetFace::straight([batter, depth], panels);
        Ok(match (&scene.dam, &scene.prescribed) {
            (Some(dam), _) => self.dry_dam(dam)?.wet_face()?.map_or_else(|| straight(0.0, 1), Ok)?,
            (None, Some(prescribed)) => straight(prescribed.batter, prescribed.panels)?,
            (None, None) => straight(0.0, 1)?,
        })
    }

    /// ρ g of the water on a side, N/m³; 0 without water.
    pub(super) fn specific_weight(&self, side: Side) -> f64 {
        self.filled(side).map_or(0.0, |water| water.density * self.scene.gravity)
    }

    /// The water on a side, if there is any.
    pub(super) fn filled(&self, side: Side) -> Option<&ReservoirScene> {
        self.scene.water(side).filter(|water| !water.is_empty())
    }

    /// Whether this program computes water on a side.
    pub(super) fn computes_water(&self, side: Side) -> bool {
        self.scene.water(side).is_some_and(|water| water.solver().is_some())
    }

    /// Makes the reservoir.
    ///
    /// **Errors**: [`AssemblyError::Empty`], and those of the reservoir.
    pub fn reservoir(&self) -> Result<Reservoir, AssemblyError> {
        Ok(self.prepared(self.water_parameters(Side::Upstream)?)?)
    }

    /// The water on a side as a participant.
    pub(super) fn water_participant(&self, side: Side) -> Result<Box<dyn Participant>, AssemblyError> {
        let messages = Messages::default();
        let parameters = self.water_parameters(side)?;
        let points = parameters.wet_face.len();
        let named = |error| match side {
            Side::Upstream => AssemblyError::Reservoir(error),
            Side::Downstream => AssemblyError::Tailwater(error),
        };
        let reservoir = messages.listen(|| self.prepared(parameters)).map_err(named)?;
        let model = reservoir.label();
        let solver = format!("{model} {}: {points} interface points", env!("CARGO_PKG_VERSION"));
        Ok(Box::new(InProcess::new(reservoir, &solver, messages)))
    }

    /// A reservoir whose operator is taken from the cache, or kept there.
    fn prepared(&self, parameters: ReservoirParameters) -> Result<Reservoir, ReservoirError> {
        let Making { threads, cache } = self.making;
        let Some(cache) = cache.filter(|_| Reservoir::is_prepared(&parameters)) else {
            return Reservoir::new(parameters, threads);
        };
        let key = cache_key(&parameters)?;
        let read = |bytes: &[u8]| Reservoir::from_prepared(parameters.clone(), bytes, threads);
        let make = || Ok(Reservoir::prepare(&parameters, threads)?.unwrap_or_default());
        cache.prepared(&key, read, make)
    }

    /// The added mass of the waters at the dam's own points, whatever the waters' are, a row for each; `still` is
    /// for water that has a memory, as if it were incompressible and without waves. Waters know of each other by the dam's motion
    /// only: the mass has a block for each.
    pub(super) fn water_mass(&self, still: bool) -> Result<Vec<Vec<f64>>, AssemblyError> {
        let mut blocks = Vec::new();
        for (side, _) in self.scene.waters() {
            let face = self.dam_face(side)?;
            if self.filled(side).is_none() {
                blocks.push(DMatrix::zeros(face.len(), face.len()));
                continue;
            }
            let mut water = self.parameters_at(face)?;
            if still && water.fidelity.has_memory() {
                water =
                    ReservoirParameters { fidelity: Fidelity::Incompressible, surface_waves: false, ..water };
            }
            blocks.push(added_mass(&water)?);
        }
        Ok(block_diagonal(&blocks))
    }
}

/// The rows of the matrix with these square `blocks` on its diagonal, zero elsewhere.
pub(crate) fn block_diagonal(blocks: &[DMatrix<f64>]) -> Vec<Vec<f64>> {
    let points: usize = blocks.iter().map(DMatrix::nrows).sum();
    let (mut rows, mut first) = (Vec::with_capacity(points), 0);
    for block in blocks {
        for values in block.row_iter() {
            let mut row = vec![0.0; points];
            row[first..first + values.len()].iter_mut().zip(&values).for_each(|(to, value)| *to = *value);
            rows.push(row);
        }
        first += block.nrows();
    }
    rows
}

/// The name of an operator in the cache.
pub(super) fn cache_key(parameters: &ReservoirParameters) -> Result<String, ReservoirError> {
    Ok(Fingerprint::of(Reservoir::NAME, parameters)?.to_string())
}
