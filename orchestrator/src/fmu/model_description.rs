use super::variables::{causality, number};
use super::{FmuError, Package, SizedVariable};
use interface::{Causality, Packable, Shape, Variability, Variable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::collections::BTreeSet;
use std::io;

/// Text that grows by elements.
pub type Xml = Writer<Vec<u8>>;

/// The log's categories and what is said in each.
const LOG_CATEGORIES: [(&str, &str); 3] = [
    ("logStatusError", "errors: a call that cannot be answered, and why"),
    ("logStatusWarning", "results that are doubtful, and why"),
    ("logEvents", "what the unit says while it computes"),
];

/// A document: `content` within the XML declaration.
pub fn document(content: impl FnOnce(&mut Xml) -> io::Result<()>) -> Result<String, FmuError> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let written = xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    written.and_then(|()| content(&mut xml)).map_err(FmuError::Xml)?;
    let text = String::from_utf8(xml.into_inner()).map_err(|cause| FmuError::Xml(io::Error::other(cause)))?;
    Ok(text + "\n")
}

/// modelDescription.xml of the package, with these variables.
pub fn write<U: Packable>(package: &Package<U>, variables: &[SizedVariable]) -> Result<String, FmuError> {
    let token = package.contents.token::<U>()?;
    let description = format!("{}: {}", U::DESCRIPTION, package.title);
    let tool = format!("cofferdam {}", env!("CARGO_PKG_VERSION"));
    let attributes = [
        ("fmiVersion", "3.0"),
        ("modelName", U::NAME),
        ("instantiationToken", &token),
        ("description", &description),
        ("version", env!("CARGO_PKG_VERSION")),
        ("license", env!("CARGO_PKG_LICENSE")),
        ("generationTool", &tool),
        ("variableNamingConvention", "structured"),
    ];
    let content = |xml: &mut Xml| {
        co_simulation(xml, package)?;
        section(xml, "UnitDefinitions", |xml| units(xml, variables))?;
        section(xml, "LogCategories", |xml| {
            for (name, description) in LOG_CATEGORIES {
                empty(xml, "Category", &[("name", name), ("description", description)])?;
            }
            Ok(())
        })?;
        let experiment = [
            ("startTime", "0.0"),
            ("stopTime", &number(package.end())),
            ("stepSize", &number(package.communication_step)),
        ];
        empty(xml, "DefaultExperiment", &experiment)?;
        section(xml, "ModelVariables", |xml| {
            let time = [
                ("name", "time"),
                ("valueReference", "0"),
                ("causality", "independent"),
                ("variability", "continuous"),
                ("unit", "s"),
                ("description", "simulated time"),
            ];
            empty(xml, "Float64", &time)?;
            variables.iter().try_for_each(|variable| one(xml, variable))
        })?;
        section(xml, "ModelStructure", |xml| structure(xml, variables))
    };
    document(|xml| {
        let root = xml.create_element("fmiModelDescription").with_attributes(attributes);
        root.write_inner_content(content).map(drop)
    })
}

fn section(xml: &mut Xml, name: &str, content: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
    xml.create_element(name).write_inner_content(content).map(drop)
}

/// An element without content.
pub fn empty(xml: &mut Xml, name: &str, attributes: &[(&str, &str)]) -> io::Result<()> {
    xml.create_element(name).with_attributes(attributes.iter().copied()).write_empty().map(drop)
}

fn co_simulation<U: Packable>(xml: &mut Xml, package: &Package<U>) -> io::Result<()> {
    let capabilities = U::capabilities_for(&package.contents.parameters);
    let said = |value: bool| if value { "true" } else { "false" };
    let step = number(package.communication_step);
    let mut attributes = vec![
        ("modelIdentifier", U::NAME),
        ("needsExecutionTool", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canGetAndSetFMUState", "true"),
        ("canSerializeFMUState", "true"),
        ("providesDirectionalDerivatives", said(capabilities.directional_derivative)),
        ("canHandleVariableCommunicationStepSize", said(capabilities.variable_communication_step)),
    ];
    if !capabilities.variable_communication_step {
        attributes.push(("fixedInternalStepSize", &step));
    }
    empty(xml, "CoSimulation", &attributes)
}

/// The units that the variables have, by name.
fn units(xml: &mut Xml, variables: &[SizedVariable]) -> io::Result<()> {
    // The time has one too.
    let used: BTreeSet<&str> = variables.iter().map(|v| v.variable.unit).chain(["s"]).collect();
    for unit in used {
        let base: Vec<_> = base_units(unit).iter().map(|(name, power)| (*name, power.to_string())).collect();
        let base: Vec<_> = base.iter().map(|(name, power)| (*name, power.as_str())).collect();
        let element = xml.create_element("Unit").with_attribute(("name", unit));
        element.write_inner_content(|xml| empty(xml, "BaseUnit", &base))?;
    }
    Ok(())
}

/// Powers of the SI's base units in a unit of the contract.
fn base_units(unit: &str) -> &'static [(&'static str, i32)] {
    match unit {
        "J/m" | "N.m/m" => &[("kg", 1), ("m", 1), ("s", -2)],
        "N/m" => &[("kg", 1), ("s", -2)],
        "Pa" => &[("kg", 1), ("m", -1), ("s", -2)],
        "Pa/m" => &[("kg", 1), ("m", -2), ("s", -2)],
        "kg/m3" => &[("kg", 1), ("m", -3)],
        "m" => &[("m", 1)],
        "m/s" => &[("m", 1), ("s", -1)],
        "m/s2" => &[("m", 1), ("s", -2)],
        "rad" => &[("rad", 1)],
        "rad/s" => &[("rad", 1), ("s", -1)],
        "s" => &[("s", 1)],
        _ => &[],
    }
}

fn one(xml: &mut Xml, sized: &SizedVariable) -> io::Result<()> {
    let Variable { name, unit, description, shape, .. } = *sized.variable;
    let (reference, start) = (sized.variable.value_reference.to_string(), sized.start_text());
    let variability = match sized.variable.variability {
        Variability::Fixed => "fixed",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let mut attributes = vec![
        ("name", name),
        ("valueReference", &reference),
        ("causality", causality(sized.variable.causality)),
        ("variability", variability),
        ("unit", unit),
    ];
    attributes.extend(start.as_deref().map(|start| ("start", start)));
    attributes.push(("description", description));
    if shape == Shape::Scalar {
        return empty(xml, "Float64", &attributes);
    }
    let dimension = sized.size.to_string();
    let element = xml.create_element("Float64").with_attributes(attributes);
    element.write_inner_content(|xml| empty(xml, "Dimension", &[("start", &dimension)])).map(drop)
}

fn structure(xml: &mut Xml, variables: &[SizedVariable]) -> io::Result<()> {
    let here = |reference: &&u32| variables.iter().any(|v| v.variable.value_reference == **reference);
    let outputs = || variables.iter().map(|v| v.variable).filter(|v| v.causality == Causality::Output);
    for output in outputs() {
        let inputs: Vec<String> = output.dependencies.iter().filter(here).map(u32::to_string).collect();
        let (reference, inputs) = (output.value_reference.to_string(), inputs.join(" "));
        empty(xml, "Output", &[("valueReference", &reference), ("dependencies", &inputs)])?;
    }
    let unknown = |v: &&Variable| matches!(v.causality, Causality::Output | Causality::CalculatedParameter);
    for variable in variables.iter().map(|v| v.variable).filter(unknown) {
        empty(xml, "InitialUnknown", &[("valueReference", &variable.value_reference.to_string())])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use interface::variables::{dam, reservoir};

    #[test]
    fn every_unit_of_the_contract_is_known() {
        for variable in dam::ALL.iter().chain(reservoir::ALL) {
            assert_eq!(base_units(variable.unit).is_empty(), variable.unit == "1", "{}", variable.name);
        }
    }
}
