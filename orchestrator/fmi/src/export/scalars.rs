//! The variables of an FMU as scalars, and their description by FMI 2.0.
//!
//! **Source**: Functional Mock-up Interface specification 2.0.4, section 2.2.

use super::model_description::{Description, Xml, around, document, empty, section};
use super::variables::number;
use super::{FmuError, SizedVariable};
use cofferdam_unit::export::{LOG_CATEGORIES, element};
use cofferdam_unit::variables::TIME;
use cofferdam_unit::{Causality, Variability, Variable};
use std::collections::{BTreeMap, BTreeSet};
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
    fn role(&self) -> (&'static str, &'static str) {
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
        let same = found.iter().filter(|other| **other == plain && !plain.is_empty()).count();
        found.push(if same == 0 { plain } else { format!("{plain}_{}", found.len() + 1) });
    }
    found
}

/// The text of modelDescription.xml of FMI 2.0.
pub fn write(of: &Description<'_>, scalars: &[Scalar<'_>]) -> Result<String, FmuError> {
    let tool = format!("cofferdam {}", env!("CARGO_PKG_VERSION"));
    let mut attributes = vec![
        ("fmiVersion", "2.0"),
        ("modelName", of.name),
        ("guid", of.token),
        ("description", of.text),
        ("generationTool", &tool),
        ("variableNamingConvention", "structured"),
        ("numberOfEventIndicators", "0"),
    ];
    if let Some((version, licence)) = of.release {
        attributes.extend([("version", version), ("license", licence)]);
    }
    let content = |xml: &mut Xml| {
        co_simulation(xml, of)?;
        section(xml, "UnitDefinitions", |xml| units(xml, scalars))?;
        section(xml, "LogCategories", |xml| {
            LOG_CATEGORIES.iter().try_for_each(|(name, description)| {
                empty(xml, "Category", &[("name", name), ("description", description)])
            })
        })?;
        if let Some(times) = &of.scene {
            let experiment = [
                ("startTime", "0.0"),
                ("stopTime", &*number(times.end)),
                ("stepSize", &*number(times.communication_step)),
            ];
            empty(xml, "DefaultExperiment", &experiment)?;
        }
        section(xml, "ModelVariables", |xml| {
            let time = [
                ("name", "time"),
                ("valueReference", &*TIME.to_string()),
                ("description", "simulated time"),
                ("causality", "independent"),
                ("variability", "continuous"),
            ];
            around(xml, ("ScalarVariable", &time), ("Real", &[("unit", "s")]))?;
            scalars.iter().try_for_each(|scalar| one(xml, scalar))
        })?;
        section(xml, "ModelStructure", |xml| structure(xml, scalars))
    };
    document(|xml| {
        let root = xml.create_element("fmiModelDescription").with_attributes(attributes);
        root.write_inner_content(content).map(drop)
    })
}

fn co_simulation(xml: &mut Xml, of: &Description<'_>) -> io::Result<()> {
    let truth = |value: bool| if value { "true" } else { "false" };
    let attributes = [
        ("modelIdentifier", of.name),
        ("needsExecutionTool", "false"),
        ("canHandleVariableCommunicationStepSize", truth(of.capabilities.variable_communication_step)),
        ("canInterpolateInputs", "true"),
        ("maxOutputDerivativeOrder", "0"),
        ("canRunAsynchronuously", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canNotUseMemoryManagementFunctions", "true"),
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
        ("providesDirectionalDerivative", truth(of.capabilities.directional_derivative)),
    ];
    empty(xml, "CoSimulation", &attributes)
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

fn one(xml: &mut Xml, scalar: &Scalar<'_>) -> io::Result<()> {
    let SizedVariable { variable, bounds, .. } = scalar.of;
    let (causality, variability) = scalar.role();
    let reference = scalar.reference.to_string();
    let mut attributes = vec![
        ("name", &*scalar.name),
        ("valueReference", &*reference),
        ("description", variable.description),
        ("causality", causality),
        ("variability", variability),
    ];
    match causality {
        "parameter" => attributes.push(("initial", "exact")),
        "calculatedParameter" | "output" => attributes.push(("initial", "calculated")),
        _ => {}
    }
    let mut real = vec![("unit", variable.unit)];
    real.extend(variable.display_unit().map(|(unit, _)| ("displayUnit", unit)));
    let [start, least, most] = [scalar.start, bounds[0], bounds[1]].map(|value| value.map(number));
    for (name, value) in [("min", &least), ("max", &most), ("start", &start)] {
        real.extend(value.as_deref().map(|value| (name, value)));
    }
    around(xml, ("ScalarVariable", &attributes), ("Real", &real))
}

fn structure(xml: &mut Xml, scalars: &[Scalar<'_>]) -> io::Result<()> {
    // Counted from 1; the first is time.
    let numbered =
        || scalars.iter().enumerate().map(|(number, scalar)| (number + 2, scalar.of.variable.causality));
    let outputs: BTreeSet<usize> = numbered()
        .filter(|(_, causality)| *causality == Causality::Output)
        .map(|(number, _)| number)
        .collect();
    if !outputs.is_empty() {
        // Outputs follow from a step, not from inputs that are set between steps.
        section(xml, "Outputs", |xml| {
            outputs.iter().try_for_each(|number| {
                empty(xml, "Unknown", &[("index", &*number.to_string()), ("dependencies", "")])
            })
        })?;
    }
    let unknown = |causality| matches!(causality, Causality::Output | Causality::CalculatedParameter);
    let unknowns: Vec<usize> =
        numbered().filter(|(_, causality)| unknown(*causality)).map(|(number, _)| number).collect();
    if unknowns.is_empty() {
        return Ok(());
    }
    section(xml, "InitialUnknowns", |xml| {
        unknowns.iter().try_for_each(|number| empty(xml, "Unknown", &[("index", &*number.to_string())]))
    })
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
            ["neck", "lift_joint__12_m_", "", "neck_4", "_3", "base_joint"]
        );
    }
}
