//! Units and types that descriptions define.

use super::variables::number;
use super::xml::{Xml, around, empty};
use cofferdam_unit::{DataType, Variable};
use std::collections::BTreeMap;
use std::io;

/// The declared type of a real variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DeclaredType {
    /// Its name, which is that of its quantity.
    pub name: &'static str,
    unit: &'static str,
    /// Unit in which people read it.
    display_unit: Option<&'static str>,
    /// Usual size, a power of ten in `unit`.
    exponent: i32,
}

impl DeclaredType {
    /// The type of `variable`; none of one that is not real.
    pub fn of(variable: &Variable) -> Option<Self> {
        let display_unit = variable.display_unit().map(|(unit, _)| unit);
        let (name, exponent) = match (variable.unit, display_unit) {
            _ if variable.data_type != DataType::Real => return None,
            ("1", _) => ("Ratio", 0),
            ("J/m", _) => ("EnergyPerLength", 5),
            ("N.m/m", _) => ("MomentPerLength", 7),
            ("N/m", _) => ("ForcePerLength", 6),
            ("Pa", Some("GPa")) => ("ElasticModulus", 10),
            ("Pa", _) if variable.name.contains("stress") => ("Stress", 6),
            ("Pa", _) => ("Pressure", 5),
            ("Pa/m", _) => ("StiffnessPerArea", 10),
            ("kg/m", _) => ("MassPerLength", 6),
            ("kg/m3", _) => ("Density", 3),
            ("m", Some(_)) => ("Displacement", -2),
            ("m", None) => ("Length", 2),
            ("m/s", _) if variable.name == "sound_speed" => ("SoundSpeed", 3),
            ("m/s", _) => ("Velocity", 0),
            ("m/s2", _) => ("Acceleration", 0),
            ("rad", _) => ("Angle", -3),
            ("rad/s", _) => ("AngularFrequency", 2),
            ("s", _) => ("Time", 0),
            _ => return None,
        };
        Some(Self { name, unit: variable.unit, display_unit, exponent })
    }

    /// Its attributes but for its name.
    pub fn attributes(&self) -> Vec<(&'static str, String)> {
        let mut attributes = vec![("quantity", self.name.to_owned()), ("unit", self.unit.to_owned())];
        attributes.extend(self.display_unit.map(|unit| ("displayUnit", unit.to_owned())));
        if self.exponent != 0 {
            attributes.push(("nominal", number(10f64.powi(self.exponent))));
        }
        attributes
    }
}

/// The types of the variables, in the order of their names.
pub fn types<'a>(variables: impl Iterator<Item = &'a Variable>) -> Vec<DeclaredType> {
    let mut used: Vec<_> = variables.filter_map(DeclaredType::of).collect();
    used.sort_unstable();
    used.dedup();
    used
}

/// The units of the real variables and of time with those that people read, in the order of their names.
pub fn units<'a>(xml: &mut Xml, variables: impl Iterator<Item = &'a Variable>) -> io::Result<()> {
    let mut used = BTreeMap::from([("s", ([("s", 1)].as_slice(), BTreeMap::new()))]);
    for variable in variables.filter(|variable| variable.data_type == DataType::Real) {
        let (_, displayed) =
            used.entry(variable.unit).or_insert_with(|| (variable.base_units(), BTreeMap::new()));
        displayed.extend(variable.display_unit().map(|(unit, factor)| (unit, number(factor))));
    }
    for (unit, (powers, displayed)) in used {
        let powers: Vec<_> = powers.iter().map(|(name, power)| (*name, power.to_string())).collect();
        let powers: Vec<_> = powers.iter().map(|(name, power)| (*name, power.as_str())).collect();
        if displayed.is_empty() {
            around(xml, ("Unit", &[("name", unit)]), ("BaseUnit", &powers))?;
            continue;
        }
        let element = xml.create_element("Unit").with_attribute(("name", unit));
        element.write_inner_content(|xml| {
            empty(xml, "BaseUnit", &powers)?;
            displayed.iter().try_for_each(|(unit, factor)| {
                empty(xml, "DisplayUnit", &[("name", unit), ("factor", factor)])
            })
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::variables::{coupled, dam, reservoir};

    #[test]
    fn every_real_variable_has_a_type_and_equal_names_are_equal_types() {
        let all = || dam::ALL.iter().chain(reservoir::ALL).chain(coupled::ALL);
        for variable in all() {
            let declared = DeclaredType::of(variable);
            assert_eq!(declared.is_some(), variable.data_type == DataType::Real, "{}", variable.name);
        }
        let types = types(all());
        for pair in types.windows(2) {
            assert_ne!(pair[0].name, pair[1].name);
        }
    }
}
