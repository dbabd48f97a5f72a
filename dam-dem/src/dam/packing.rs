//! The dam as a unit that is made from parameters alone.

use cofferdam_unit::{Capabilities, Packable, Shape, Variable, variables::dam as variable};
use std::num::NonZeroUsize;

use super::Dam;
use crate::stress::stress_points;
use crate::{DamError, DamParameters};

impl Packable for Dam {
    type Parameters = DamParameters;

    const NAME: &'static str = "dam";
    const DESCRIPTION: &'static str = "Concrete gravity dam of blocks on rigid ground";
    const VARIABLES: &'static [Variable] = variable::ALL;

    fn from_parameters(parameters: DamParameters, threads: NonZeroUsize) -> Result<Self, DamError> {
        Self::new(parameters)?.on_threads(threads)
    }

    /// 0 for sizes that depend on the mesh, if the parameters are invalid and give no mesh.
    fn size_for(parameters: &DamParameters, variable: &Variable) -> usize {
        let mesh = || parameters.check().and_then(|()| parameters.mesh()).ok();
        if !parameters.has(variable) {
            return 0;
        }
        match variable.shape {
            Shape::Scalar | Shape::Plane | Shape::Modes => variable.shape.least_size(),
            Shape::InterfacePoints => parameters.wet_face().ok().flatten().map_or(0, |face| face.len()),
            Shape::TailwaterPoints => parameters.tailwater_face().ok().flatten().map_or(0, |face| face.len()),
            Shape::Cracks => parameters.cracks.len(),
            Shape::StressPoints => mesh().map_or(0, |mesh| stress_points(&parameters.section, &mesh).len()),
            Shape::Nodes => mesh().map_or(0, |mesh| mesh.nodes.len()),
            Shape::Triangles => mesh().map_or(0, |mesh| mesh.triangles().count()),
            Shape::Contacts => mesh().map_or(0, |mesh| parameters.contact_count(&mesh)),
        }
    }

    fn capabilities_for(_parameters: &DamParameters) -> Capabilities {
        Capabilities { variable_communication_step: true, directional_derivative: false, saved_state: true }
    }

    fn numbers<'a>(parameters: &'a mut DamParameters, variable: &Variable) -> Vec<&'a mut f64> {
        parameters.numbers(variable)
    }
}
