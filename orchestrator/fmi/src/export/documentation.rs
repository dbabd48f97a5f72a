use super::{Package, SizedVariable};
use cofferdam_unit::{Causality, Packable};
use quick_xml::escape::escape;
use std::fmt::Write;

const PAGE: &str = include_str!("page.html");

/// The text of documentation/index.html: what the unit computes, and how to use it.
pub fn page<U: Packable>(package: &Package<U>, variables: &[SizedVariable]) -> String {
    let numbers = [
        ("step", package.communication_step.to_string()),
        ("end", package.end().to_string()),
        ("points", package.interface_points().to_string()),
    ];
    let step = match U::capabilities_for(&package.contents.parameters).variable_communication_step {
        true => {
            "The length of a communication step may differ from that of the scene, and from step to step."
        }
        false => {
            "A communication step may also be a whole multiple of this length, of which the unit then takes several steps of \
             its own: the face's acceleration is constant over the step, the ground's linear. Other lengths are refused, unless the water turns out to be stepped by a recursion."
        }
    };
    let mesh: Vec<String> =
        package.mesh.iter().map(|(name, _)| format!("<code>resources/mesh/{name}</code>")).collect();
    let mut values = vec![
        ("unit", U::NAME.to_owned()),
        ("description", escape(U::DESCRIPTION).into_owned()),
        ("title", escape(&*package.title).into_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("step_length", step.to_owned()),
        ("mesh", if mesh.is_empty() { "none, this unit has no mesh".to_owned() } else { mesh.join(", ") }),
        ("about", filled(package.about.trim_end(), &numbers)),
        ("example", filled(package.example.trim_end(), &numbers)),
        ("variables", table(variables)),
        ("parameters", parameters(variables)),
    ];
    values.extend(numbers);
    filled(PAGE, &values)
}

/// The text of documentation/licenses/license.txt.
pub fn licences() -> String {
    format!(
        "Licensed under the MIT licence or the Apache licence 2.0, at your choice. The library contains third-party \
         crates under their own licences, most of them one of these two. In the sources of cofferdam {}, \
         `cargo tree --edges normal --format '{{p}} {{l}}'` lists them.\n\n{}\n\n{}",
        env!("CARGO_PKG_VERSION"),
        include_str!("../../LICENSE-MIT"),
        include_str!("../../LICENSE-APACHE")
    )
}

/// The template with every known `{name}` replaced by its value. Other braces, and braces in values, stay unchanged.
fn filled(template: &str, values: &[(&str, String)]) -> String {
    let (mut text, mut rest) = (String::new(), template);
    while let Some(open) = rest.find('{') {
        let (before, after) = rest.split_at(open);
        text.push_str(before);
        let named = after[1..].split_once('}').and_then(|(name, rest)| {
            values.iter().find(|(known, _)| *known == name).map(|(_, value)| (value, rest))
        });
        match named {
            Some((value, after)) => {
                text.push_str(value);
                rest = after;
            }
            None => {
                text.push('{');
                rest = &after[1..];
            }
        }
    }
    text + rest
}

/// The rows of the table of variables.
fn table(variables: &[SizedVariable]) -> String {
    let mut rows = String::new();
    for sized in variables {
        let variable = sized.variable;
        let start = match variable.causality {
            Causality::Parameter => sized.start_text().unwrap_or_default(),
            _ => String::new(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            rows,
            "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            variable.name,
            variable.value_reference,
            variable.causality.name(),
            sized.size,
            escape(variable.unit),
            start,
            escape(variable.description),
        );
    }
    rows
}

/// Names of the parameters, separated by commas.
fn parameters(variables: &[SizedVariable]) -> String {
    let parameters = variables.iter().filter(|v| v.variable.causality == Causality::Parameter);
    parameters.map(|v| format!("<code>{}</code>", v.variable.name)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_known_names_are_replaced_and_values_stay_as_they_are() {
        let values = [("a", "{b}".to_owned()), ("b", "1".to_owned())];
        assert_eq!(filled("p { c: {a}; } {b}{d} {", &values), "p { c: {b}; } 1{d} {");
    }
}
