//! The variables of an FMU as scalars.

use super::SizedVariable;
use cofferdam_unit::Causality;
use cofferdam_unit::export::element;

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
