/// Powers of the SI base units in a unit: name of a base unit as FMI 3.0 spells it, and its power.
pub type BaseUnits = &'static [(&'static str, i32)];

/// The units of the contract's variables, and that of the mass of a dam that somebody else writes.
const UNITS: [(&str, BaseUnits); 14] = [
    ("1", &[]),
    ("J/m", &[("kg", 1), ("m", 1), ("s", -2)]),
    ("N.m/m", &[("kg", 1), ("m", 1), ("s", -2)]),
    ("N/m", &[("kg", 1), ("s", -2)]),
    ("Pa", &[("kg", 1), ("m", -1), ("s", -2)]),
    ("Pa/m", &[("kg", 1), ("m", -2), ("s", -2)]),
    (MASS, &[("kg", 1), ("m", -1)]),
    ("kg/m3", &[("kg", 1), ("m", -3)]),
    ("m", &[("m", 1)]),
    ("m/s", &[("m", 1), ("s", -1)]),
    ("m/s2", &[("m", 1), ("s", -2)]),
    ("rad", &[("rad", 1)]),
    ("rad/s", &[("rad", 1), ("s", -1)]),
    ("s", &[("s", 1)]),
];

const MASS: &str = "kg/m";

/// Powers of the SI base units in `unit`, empty for the pure number `1`; none for a unit that the contract does not use.
pub fn base_units(unit: &str) -> Option<BaseUnits> {
    UNITS.iter().find(|(name, _)| *name == unit).map(|(_, powers)| *powers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::{coupled, dam, reservoir};

    #[test]
    fn every_unit_of_the_contract_is_in_the_table() {
        for variable in dam::ALL.iter().chain(reservoir::ALL).chain(coupled::ALL) {
            assert!(base_units(variable.unit).is_some(), "{}: {}", variable.name, variable.unit);
        }
        for (unit, _) in UNITS {
            let used = dam::ALL.iter().chain(reservoir::ALL).any(|variable| variable.unit == unit);
            assert!(used || unit == MASS, "{unit} is used by no variable");
        }
    }
}
