//! The variables of the FMUs: those of the contract that a unit of one's own needs, and parameters of the dam.

use crate::export::SizedVariable;
use cofferdam_unit::{Causality, DataType, Shape, Variability, Variable, variables};

/// A parameter of the dam.
const fn parameter(
    name: &'static str,
    value_reference: u32,
    unit: &'static str,
    description: &'static str,
) -> Variable {
    Variable {
        name,
        value_reference,
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        shape: Shape::Scalar,
        data_type: DataType::Real,
        unit,
        description,
        dependencies: &[],
    }
}

const AT_END: &str = "total acceleration (relative plus ground) of the wet face along n, the unit normal from the water into \
                      the dam; at the end of the step";
const AS_THE_SOURCE_SAYS: &str = "total acceleration (relative plus ground) of the wet face along n, the unit normal from \
                                  the water into the dam; at the end of the step, or its mean over it, as the source says";

static WATER: [Variable; 12] = {
    use variables::reservoir::*;
    [
        Variable { description: AS_THE_SOURCE_SAYS, ..INTERFACE_ACCELERATION },
        GROUND_ACCELERATION,
        INTERFACE_PRESSURE,
        HYDROSTATIC_PRESSURE,
        INTERFACE_X,
        INTERFACE_Y,
        INTERFACE_NORMAL_X,
        INTERFACE_NORMAL_Y,
        INTERFACE_LENGTH,
        WATER_DEPTH,
        WATER_DENSITY,
        GRAVITY,
    ]
};

static DAM: [Variable; 18] = {
    use variables::dam::*;
    [
        INTERFACE_PRESSURE,
        HYDROSTATIC_PRESSURE,
        GROUND_ACCELERATION,
        INTERFACE_DISPLACEMENT,
        INTERFACE_VELOCITY,
        INTERFACE_ACCELERATION,
        Variable { description: AT_END, ..INTERFACE_ACCELERATION_END },
        CREST_DISPLACEMENT,
        CREST_STATIC_DISPLACEMENT,
        INTERFACE_X,
        INTERFACE_Y,
        INTERFACE_NORMAL_X,
        INTERFACE_NORMAL_Y,
        INTERFACE_LENGTH,
        // Their sources know real variables only.
        Variable { data_type: DataType::Real, ..ADDED_MASS_INCLUDED },
        parameter("mass", 100, "kg/m", "mass that sways, per metre of dam"),
        parameter("stiffness", 101, "Pa", "force per metre of dam over sway"),
        parameter("damping_ratio", 56, "1", "damping ratio of the sway"),
    ]
};

/// The variables of a reservoir before `points` points, in water of this density (kg/m³) and gravity (m/s²).
pub fn water(points: usize, [density, gravity]: [f64; 2]) -> Vec<SizedVariable> {
    sized(&WATER, points, &[("water_density", density), ("gravity", gravity)])
}

/// The variables of a dam with `points` points and these parameters.
pub fn dam(points: usize, parameters: &[(&str, f64)]) -> Vec<SizedVariable> {
    sized(&DAM, points, parameters)
}

fn sized(variables: &'static [Variable], points: usize, parameters: &[(&str, f64)]) -> Vec<SizedVariable> {
    let one = |variable: &'static Variable| {
        let size = variable.shape.fixed_size().unwrap_or(points);
        let start = match variable.causality {
            Causality::Input => Some(vec![0.0; size]),
            _ => {
                let value = parameters.iter().find(|(name, _)| *name == variable.name);
                value.map(|(_, value)| vec![*value])
            }
        };
        SizedVariable { variable, size, start, bounds: [None; 2] }
    };
    variables.iter().map(one).collect()
}
