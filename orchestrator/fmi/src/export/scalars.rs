//! The variables of an FMU as scalars.

use super::SizedVariable;
use super::variables::number;
use super::xml::{Xml, around, empty};
use cofferdam_unit::export::element;
use cofferdam_unit::{Causality, Variability, Variable};
use std::collections::BTreeMap;
use std::io;

/// One value of a variable.
pub struct Scalar<'a> {
    /// Its name.
    pub name: String,
    /// Its value reference.
    pub reference: u32,
    /// Its variable.
    pub of: &'a SizedVariable,
    /// Its start value, of inputs and parameters.
    pub start: Option<f64>,
}

impl Scalar<'_> {
    /// Role in FMI 2.0, where an input that is fixed when initialisation ends is a parameter.
    pub fn role(&self) -> (&'static str, &'static str) {
        let Variable { causality, variability, .. } = self.of.variable;
        match (causality, variability) {
            (Causality::Input, Variability::Discrete) => ("parameter", "fixed"),
            _ => (causality.name(), variability.name()),
        }
    }
}

/// All values but those of fields for pictures, which would be too many; cracks have these names.
pub fn of<'a>(variables: &'a [SizedVariable], cracks: &[String]) -> Vec<Scalar<'a>> {
    let exchanged = variables.iter().filter(|sized| sized.variable.causality != Causality::Local);
    let few = exchanged.filter(|sized| !sized.variable.shape.is_of_mesh());
    few.flat_map(|sized| {
        (0..sized.size).map(move |index| Scalar {
            name: sized.variable.value_name(index, cracks),
            reference: element(sized.variable.value_reference, index),
            of: sized,
            start: sized.start.as_ref().and_then(|values| values.get(index).copied()),
        })
    })
    .collect()
}

/// Names of cracks as parts of structured names: letters, digits and underscores, each once; empty for one without a name.
pub fn crack_names<'a>(names: impl Iterator<Item = Option<&'a str>>) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for name in names {
        let letters = name.unwrap_or_default().chars();
        let plain: String =
            letters.map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect::<String>();
        let plain = if plain.starts_with(|c: char| c.is_ascii_digit()) { format!("_{plain}") } else { plain };
        let is_free = |name: &String| name.is_empty() || !found.contains(name);
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(is_free);
        found.push(free.unwrap_or_default());
    }
    found
}

/// The units of the scalars and of time with those that people read, in the order of their names.
pub fn units(xml: &mut Xml, scalars: &[Scalar<'_>]) -> io::Result<()> {
    let mut used = BTreeMap::from([("s", ([("s", 1)].as_slice(), BTreeMap::new()))]);
    for Scalar { of, .. } in scalars {
        let variable = of.variable;
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

    #[test]
    fn names_of_cracks_are_identifiers_and_differ() {
        let names =
            [Some("neck"), Some("lift joint (12 m)"), None, Some("neck"), Some("3"), Some("base-joint")];
        assert_eq!(
            crack_names(names.into_iter()),
            ["neck", "lift_joint__12_m_", "", "neck_2", "_3", "base_joint"]
        );
        let names = [Some("lift 1 2"), Some("lift 1"), Some("lift-1")];
        assert_eq!(crack_names(names.into_iter()), ["lift_1_2", "lift_1", "lift_1_3"]);
    }
}
