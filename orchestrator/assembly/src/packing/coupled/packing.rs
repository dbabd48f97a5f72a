//! The coupled unit as one that is made from parameters alone.

use super::{Coupled, CoupledError, CoupledParameters, variables};
use cofferdam_coupling::scheme::SchemeKind;
use cofferdam_dam::Dam;
use cofferdam_reservoir::Reservoir;
use cofferdam_unit::{Capabilities, Causality, Fingerprint, Packable, Shape, Variable, open, seal};
use std::num::NonZeroUsize;
use std::sync::Arc;

impl Packable for Coupled {
    type Parameters = CoupledParameters;

    const NAME: &'static str = "coupled";
    const DESCRIPTION: &'static str = "Concrete gravity dam and its reservoir, coupled";
    const VARIABLES: &'static [Variable] = variables::ALL;

    fn from_parameters(parameters: CoupledParameters, threads: NonZeroUsize) -> Result<Self, CoupledError> {
        Self::new(parameters, Arc::default(), threads)
    }

    /// What the waters prepare.
    fn prepare(
        parameters: &CoupledParameters,
        threads: NonZeroUsize,
    ) -> Result<Option<Vec<u8>>, CoupledError> {
        let prepared = parameters.waters.iter().map(|water| Reservoir::prepare(water, threads));
        let prepared: Vec<Option<Vec<u8>>> = prepared.collect::<Result<_, _>>()?;
        if prepared.iter().all(Option::is_none) {
            return Ok(None);
        }
        Ok(Some(seal(Fingerprint::of(Self::NAME, &parameters.waters)?, &prepared)?))
    }

    fn from_prepared(
        parameters: CoupledParameters,
        prepared: &[u8],
        threads: NonZeroUsize,
    ) -> Result<Self, CoupledError> {
        let prepared: Vec<Option<Vec<u8>>> =
            open(Fingerprint::of(Self::NAME, &parameters.waters)?, prepared)?;
        Self::new(parameters, Arc::new(prepared), threads)
    }

    /// What is prepared depends on the waters alone.
    fn can_reuse_prepared(packed: &CoupledParameters, parameters: &CoupledParameters) -> bool {
        let hash = |parameters: &CoupledParameters| Fingerprint::of(Self::NAME, &parameters.waters).ok();
        hash(packed) == hash(parameters)
    }

    fn size_for(parameters: &CoupledParameters, variable: &Variable) -> usize {
        match variable.shape {
            _ if *variable == variables::GROUND_ACCELERATION_VERTICAL => {
                usize::from(parameters.vertical.is_some())
            }
            Shape::InterfacePoints => parameters.waters.first().map_or(0, |water| water.wet_face.len()),
            _ => match of_dam(variable) {
                Some(own) => Dam::size_for(&parameters.dam, own),
                None => variable.shape.fixed_size().unwrap_or(0),
            },
        }
    }

    fn capabilities_for(_: &CoupledParameters) -> Capabilities {
        Capabilities { variable_communication_step: false, directional_derivative: false, saved_state: true }
    }

    fn numbers<'a>(parameters: &'a mut CoupledParameters, variable: &Variable) -> Vec<&'a mut f64> {
        match *variable {
            variables::USE_RECORD => return vec![&mut parameters.use_record],
            variables::RECORD_SCALE => return vec![&mut parameters.record_scale],
            variables::INPUTS_HELD => return vec![&mut parameters.inputs_held],
            variables::COUPLING_TOLERANCE => return vec![&mut parameters.coupling_tolerance],
            _ => {}
        }
        if let Some(own) = of_dam(variable) {
            return Dam::numbers(&mut parameters.dam, own);
        }
        let own = Reservoir::VARIABLES.iter().find(|own| own.name == variable.name);
        // The dam's mass matrix has the water of the scene.
        let is_free = parameters.scene.scheme() != SchemeKind::OneWay;
        match (own, parameters.waters.first_mut()) {
            (Some(own), Some(water)) if is_free => Reservoir::numbers(water, own),
            _ => Vec::new(),
        }
    }
}

/// The dam's variable of the same name and role.
fn of_dam(variable: &Variable) -> Option<&'static Variable> {
    let same = |own: &&Variable| own.name == variable.name && own.causality == variable.causality;
    Dam::VARIABLES.iter().filter(|_| variable.causality != Causality::Input).find(same)
}
