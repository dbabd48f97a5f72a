use super::scalars::Scalar;
use super::variables::{role, value_text};
use super::{Package, Page, SizedVariable, Version};
use cofferdam_unit::{Causality, Packable, Variable};
use quick_xml::escape::escape;

const PAGE: &str = include_str!("page.html");

const BOTH: &str = " A parameter that both units have, such as gravity, is changed in one FMU only: change it in the other \
    as well, or pack both again.";
const OTHER_LENGTHS: &str =
    " Other lengths are refused, except by a reservoir whose water is stepped by a recursion.";
const TERMINAL: &str = "<p>The terminal <code>wet_face</code> groups the variables that dam and reservoir exchange: connect \
    members of the same name.</p>\n";
const ARRAYS: &str = " In a CSV file of inputs the values of an array stand in one cell, separated by spaces. FMPy 0.3 \
    takes several array inputs from one file only if they have the same size. The dam's <code>hydrostatic_pressure</code> is a \
    parameter: give it as a start value.";

/// FMI 2.0 has no variable for it.
const TIME_ROW: &str = "<tr><td><code>time</code></td><td>0</td><td>independent</td><td>1</td><td>s</td><td></td>\
    <td>simulated time</td></tr>\n";

/// The text of documentation/index.html: what the unit computes, and how to use it; with `scalars`, these are the variables.
pub fn page<U: Packable>(
    package: &Package<U>,
    variables: &[SizedVariable],
    scalars: Option<&[Scalar<'_>]>,
) -> String {
    let of_version = |two: &str, three: &str| match package.version {
        Version::Fmi2 => two.to_owned(),
        Version::Fmi3 => three.to_owned(),
    };
    let of_arrays = |text: &str| if scalars.is_some() { String::new() } else { text.to_owned() };
    let of_pair = |text: &str| if package.as_scalars { String::new() } else { text.to_owned() };
    let step = match U::capabilities_for(&package.contents.parameters).variable_communication_step {
        true => {
            "The length of a communication step may differ from that of the scene, and from step to step."
        }
        false => {
            "A communication step may also be a whole multiple of this length, of which the unit then takes several steps of \
             its own, while the ground's acceleration changes linearly."
        }
    };
    let values = vec![
        ("step", package.communication_step.to_string()),
        ("end", package.end().to_string()),
        ("points", package.interface_points().to_string()),
        ("step_length", step.to_owned() + &of_pair(OTHER_LENGTHS)),
        ("terminal", of_arrays(TERMINAL)),
        ("arrays", of_arrays(ARRAYS)),
        ("get_state", of_version("fmi2GetFMUstate", "fmi3GetFMUState")),
        ("set_state", of_version("fmi2SetFMUstate", "fmi3SetFMUState")),
    ];
    let part = |text: &str| filled(text.trim_end(), &values);
    let Page { about, usage, example, notes } = &package.page;
    let mesh: Vec<String> =
        package.mesh.iter().map(|(name, _)| format!("<code>resources/mesh/{name}</code>")).collect();
    let mut all = vec![
        ("unit", U::NAME.to_owned()),
        ("fmi", package.version.number().to_owned()),
        ("description", escape(U::DESCRIPTION).into_owned()),
        ("title", escape(&*package.title).into_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("mesh", if mesh.is_empty() { "none, this unit has no mesh".to_owned() } else { mesh.join(", ") }),
        ("about", part(about)),
        ("usage", part(usage)),
        ("example", part(example)),
        ("notes", part(notes)),
        ("both", of_pair(BOTH)),
        ("time", of_version("", TIME_ROW)),
        ("variables", scalars.map_or_else(|| table(variables), table_of_scalars)),
        ("parameters", scalars.map_or_else(|| parameters(variables), parameters_of_scalars)),
    ];
    all.extend(values);
    filled(PAGE, &all)
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

/// A row of the table of variables.
fn row(name: &str, reference: u32, causality: &str, size: usize, start: &str, of: &Variable) -> String {
    format!(
        "<tr><td><code>{name}</code></td><td>{reference}</td><td>{causality}</td><td>{size}</td><td>{}</td><td>{start}</td>\
         <td>{}</td></tr>\n",
        escape(of.unit),
        escape(of.description),
    )
}

/// The rows of the table of variables.
fn table(variables: &[SizedVariable]) -> String {
    let of = |sized: &SizedVariable| {
        let variable = sized.variable;
        let (causality, _) = role(variable);
        // Those of an array would fill the page.
        let shown = variable.causality == Causality::Parameter;
        let start = sized.start_text().filter(|_| shown).unwrap_or_default();
        row(variable.name, variable.value_reference, causality, sized.size, &start, variable)
    };
    variables.iter().map(of).collect()
}

/// The rows of the table of scalars.
fn table_of_scalars(scalars: &[Scalar<'_>]) -> String {
    let of = |scalar: &Scalar<'_>| {
        let (causality, _) = role(scalar.of.variable);
        let text = |value| value_text(scalar.of.variable.data_type, value);
        let start = scalar.start.filter(|_| causality == "parameter").map_or_else(String::new, text);
        row(&scalar.name, scalar.reference, causality, 1, &start, scalar.of.variable)
    };
    scalars.iter().map(of).collect()
}

/// Names of the parameters, separated by commas.
fn parameters(variables: &[SizedVariable]) -> String {
    let parameters = variables.iter().filter(|v| v.variable.causality == Causality::Parameter);
    parameters.map(|v| format!("<code>{}</code>", v.variable.name)).collect::<Vec<_>>().join(", ")
}

/// The same of scalars.
fn parameters_of_scalars(scalars: &[Scalar<'_>]) -> String {
    let parameters = scalars.iter().filter(|scalar| scalar.of.variable.causality == Causality::Parameter);
    let names: Vec<_> = parameters.map(|scalar| format!("<code>{}</code>", scalar.name)).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
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
