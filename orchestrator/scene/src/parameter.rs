//! Parameters of units, which an FMU's importer may change, as keys of a scene.

use super::shape::{Field, Shape};

/// The key of a scene behind a parameter of a unit of the contract.
fn key(unit: &str, parameter: &str) -> Option<&'static Field> {
    let path = match (unit, parameter) {
        ("dam", "young_modulus") => "dam.material.young_modulus",
        ("dam", "poisson_ratio") => "dam.material.poisson_ratio",
        ("dam", "density") => "dam.material.density",
        ("dam", "friction_coefficient") => "dam.cracks.friction_coefficient",
        ("dam", "normal_stiffness") => "dam.cracks.normal_stiffness",
        ("dam", "shear_stiffness") => "dam.cracks.shear_stiffness",
        ("dam", "damping_ratio") => "dam.damping.ratio",
        ("reservoir", "water_density") => "reservoir.density",
        ("reservoir", "sound_speed") => "reservoir.sound_speed",
        ("reservoir", "wave_reflection_coefficient") => "reservoir.wave_reflection_coefficient",
        ("reservoir", "gravity") => "gravity",
        ("reservoir", "element_size") => "reservoir.element_size",
        ("reservoir", "far_end_distance") => "reservoir.far_end_distance",
        ("reservoir", "horizon") => "time.duration",
        ("coupled", _) => return key("dam", parameter).or_else(|| key("reservoir", parameter)),
        _ => return None,
    };
    Shape::field(path)
}

/// Least and largest value that a parameter of a unit may have, where its key bounds it; the least may be excluded.
pub fn bounds(unit: &str, parameter: &str) -> [Option<f64>; 2] {
    if (unit, parameter) == ("coupled", "coupling_tolerance") {
        // 0 stands for the balanced tolerance.
        return [Some(0.0), Some(0.1)];
    }
    match key(unit, parameter).map(|field| &field.shape) {
        Some(Shape::Number(range)) => {
            [range.least, range.most].map(|bound| Some(bound).filter(|b| b.abs() < f64::MAX))
        }
        _ => [None, None],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::{Causality, variables};

    #[test]
    fn every_parameter_has_a_key_of_its_unit() {
        let of_fmu = ["use_record", "record_scale", "coupling_tolerance", "inputs_held"];
        for (unit, all) in [
            ("dam", variables::dam::ALL),
            ("reservoir", variables::reservoir::ALL),
            ("coupled", variables::coupled::ALL),
        ] {
            let parameters = all.iter().filter(|variable| variable.causality == Causality::Parameter);
            for variable in parameters.filter(|variable| !of_fmu.contains(&variable.name)) {
                let field = key(unit, variable.name).unwrap_or_else(|| panic!("{unit}: {}", variable.name));
                let si = field.unit.replace('²', "2").replace('³', "3");
                assert_eq!(if si.is_empty() { "1" } else { &si }, variable.unit, "{unit}: {}", variable.name);
                assert!(matches!(field.shape, Shape::Number(_)), "{unit}: {}", variable.name);
            }
        }
    }
}
