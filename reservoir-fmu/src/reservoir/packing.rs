//! The reservoir as a unit that is made from parameters alone.

use super::preparation::{Operator, Prepared, prepared};
use super::{Reservoir, UNIT};
use crate::{ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir as variables;
use cofferdam_unit::{Capabilities, Fingerprint, Packable, Shape, StateError, Variable, open, seal};
use std::num::NonZeroUsize;

impl Packable for Reservoir {
    type Parameters = ReservoirParameters;

    const NAME: &'static str = UNIT;
    const DESCRIPTION: &'static str = "Water of infinite extent upstream of a dam";
    const VARIABLES: &'static [Variable] = variables::ALL;

    fn from_parameters(
        parameters: ReservoirParameters,
        threads: NonZeroUsize,
    ) -> Result<Self, ReservoirError> {
        Self::new(parameters, threads)
    }

    /// The weights of a convolution, or a recursion.
    fn prepare(
        parameters: &ReservoirParameters,
        threads: NonZeroUsize,
    ) -> Result<Option<Vec<u8>>, ReservoirError> {
        parameters.validate()?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
        let prepared = pool.install(|| prepared(parameters))?;
        Ok(prepared.map(|prepared| seal(of_prepared(parameters)?, &prepared)).transpose()?)
    }

    fn from_prepared(
        parameters: ReservoirParameters,
        prepared: &[u8],
        threads: NonZeroUsize,
    ) -> Result<Self, ReservoirError> {
        let length = prepared.len();
        let prepared: Prepared = open(of_prepared(&parameters)?, prepared)?;
        let points = parameters.wet_face.len();
        let fits = match &prepared.operator {
            Operator::Convolution(weights) => weights.are_of(points, points + 2, parameters.steps()),
            Operator::Recursion(recursion, _) => recursion.is_of(points, points + 2),
        };
        if !fits {
            return Err(StateError::NotAState { length }.into());
        }
        Self::with_prepared(parameters, Some(prepared), threads)
    }

    /// What is prepared does not depend on how inputs change within a step.
    fn can_reuse_prepared(packed: &ReservoirParameters, parameters: &ReservoirParameters) -> bool {
        let packed = of_prepared(packed).ok();
        packed.is_some() && packed == of_prepared(parameters).ok()
    }

    fn size_for(parameters: &ReservoirParameters, variable: &Variable) -> usize {
        match variable.shape {
            Shape::InterfacePoints => parameters.wet_face.len(),
            shape => shape.fixed_size().unwrap_or(0),
        }
    }

    fn capabilities_for(parameters: &ReservoirParameters) -> Capabilities {
        let iterated = !parameters.explicit_coupling;
        let variable =
            parameters.fidelity.supports_variable_steps() || parameters.method.supports_variable_steps();
        Capabilities {
            variable_communication_step: iterated && variable,
            directional_derivative: iterated,
            saved_state: true,
        }
    }

    fn numbers<'a>(parameters: &'a mut ReservoirParameters, variable: &Variable) -> Vec<&'a mut f64> {
        // The dam has the mass of this water.
        if parameters.explicit_coupling { Vec::new() } else { parameters.numbers(variable) }
    }
}

/// Hash of what the prepared parts depend on.
fn of_prepared(parameters: &ReservoirParameters) -> Result<Fingerprint, StateError> {
    Fingerprint::of(UNIT, &ReservoirParameters { inputs_held: 0.0, ..parameters.clone() })
}
