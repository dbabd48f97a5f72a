//! What the water is stepped with: made, or taken from an earlier preparation.

use super::{Model, Reservoir};
use crate::added_mass::whole_added_mass;
use crate::convolution::{Convolution, Weights};
use crate::finite_elements::FiniteElements;
use crate::frequency_response::{convolution_weights, quadrature};
use crate::rational::{Quality, Recursion, recursion};
use crate::time_domain::TimeDomain;
use crate::{Fidelity, Method, ReservoirError, ReservoirParameters};
use serde::{Deserialize, Serialize};

/// What compressible water is stepped with, and takes long to make.
#[derive(Serialize, Deserialize)]
pub(super) enum Operator {
    Convolution(Weights),
    Recursion(Box<Recursion>, Quality),
}

/// An operator, and a description of it for the log.
#[derive(Serialize, Deserialize)]
pub(super) struct Prepared {
    pub(super) operator: Operator,
    pub(super) said: String,
}

/// The operator of compressible water, on the current rayon pool; none of water that is quickly made.
pub(super) fn prepared(parameters: &ReservoirParameters) -> Result<Option<Prepared>, ReservoirError> {
    if !Reservoir::is_prepared(parameters) {
        return Ok(None);
    }
    let fitted = match parameters.method {
        Method::Recursive => Some(recursion(parameters)?),
        Method::Automatic if parameters.may_be_fitted() => match recursion(parameters) {
            Ok(fitted) => Some(fitted).filter(|(_, quality)| !quality.is_doubtful()),
            Err(ReservoirError::NotFitted | ReservoirError::Recursion { .. }) => None,
            Err(error) => return Err(error),
        },
        _ => None,
    };
    let (operator, said) = if let Some((recursion, quality)) = fitted {
        (Operator::Recursion(Box::new(recursion), quality), quality.to_string())
    } else {
        // What a recursion would not have minded.
        ReservoirParameters { method: parameters.method.of_convolution(), ..parameters.clone() }
            .validate()?;
        let (weights, solved) = convolution_weights(parameters)?;
        let all = quadrature(parameters).frequencies();
        (Operator::Convolution(weights), format!("solved at {solved} frequencies instead of {all}"))
    };
    Ok(Some(Prepared { operator, said }))
}

/// The water's model, a description for the log, and the quality of a recursion; with what was prepared, if it was.
pub(super) fn made(
    parameters: &ReservoirParameters,
    given: Option<Prepared>,
) -> Result<(Model, String, Option<Quality>), ReservoirError> {
    let given = match given {
        Some(given) => Some(given),
        None => prepared(parameters)?,
    };
    let (water, said, quality): (Box<dyn TimeDomain>, _, _) = match (given, parameters.fidelity) {
        (Some(Prepared { operator: Operator::Convolution(weights), said }), _) => {
            (Box::new(Convolution::new(weights)), said, None)
        }
        (Some(Prepared { operator: Operator::Recursion(recursion, quality), said }), _) => {
            (recursion, said, Some(quality))
        }
        (None, Fidelity::Compressible) => {
            let elements = FiniteElements::new(parameters)?;
            let said = format!("{} finite elements", elements.triangles().len());
            (Box::new(elements), said, None)
        }
        (None, fidelity) => {
            let mass = whole_added_mass(parameters)?;
            let said = if fidelity.is_solved() { fidelity.label() } else { "added mass" };
            return Ok((Model::AddedMass(mass), said.to_owned(), None));
        }
    };
    Ok((Model::Memory(water), format!("{}; {said}", parameters.fidelity.label()), quality))
}
