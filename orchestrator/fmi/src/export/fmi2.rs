//! The description of a unit by FMI 2.0.
//!
//! **Source**: Functional Mock-up Interface specification 2.0.4, section 2.2.

use super::FmuError;
use super::definitions::{DeclaredType, types, units};
use super::model_description::Description;
use super::scalars::Scalar;
use super::variables::{dependencies, number, role, value_text};
use super::xml::{Xml, around, document, empty, section};
use cofferdam_unit::export::LOG_CATEGORIES;
use cofferdam_unit::{Causality, DataType};
use std::io;

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
        let variables = || scalars.iter().map(|scalar| scalar.of.variable);
        section(xml, "UnitDefinitions", |xml| units(xml, variables()))?;
        section(xml, "TypeDefinitions", |xml| {
            types(variables()).iter().try_for_each(|declared| {
                let attributes = declared.attributes();
                let attributes: Vec<_> =
                    attributes.iter().map(|(name, value)| (*name, value.as_str())).collect();
                around(xml, ("SimpleType", &[("name", declared.name)]), ("Real", &attributes))
            })
        })?;
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
        // The independent variable, which FMI leaves out by default, would need a start value by some importers and may have none.
        section(xml, "ModelVariables", |xml| scalars.iter().try_for_each(|scalar| one(xml, scalar)))?;
        section(xml, "ModelStructure", |xml| structure(xml, of, scalars))
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

fn one(xml: &mut Xml, scalar: &Scalar<'_>) -> io::Result<()> {
    let variable = scalar.of.variable;
    let (causality, variability) = role(variable);
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
    let declared = DeclaredType::of(variable);
    let mut values: Vec<_> = declared.iter().map(|declared| ("declaredType", declared.name)).collect();
    if variable.data_type == DataType::Real {
        values.push(("unit", variable.unit));
        values.extend(variable.display_unit().map(|(unit, _)| ("displayUnit", unit)));
    }
    let start = scalar.start.map(|value| value_text(variable.data_type, value));
    values.extend(start.as_deref().map(|start| ("start", start)));
    let bounds = scalar.of.bound_texts();
    values.extend(bounds.iter().map(|(name, bound)| (*name, bound.as_str())));
    around(xml, ("ScalarVariable", &attributes), (variable.data_type.fmi2_name(), &values))
}

fn structure(xml: &mut Xml, of: &Description<'_>, scalars: &[Scalar<'_>]) -> io::Result<()> {
    // Counted from 1.
    let numbered = || (1..).zip(scalars);
    let with = |causalities: &'static [Causality]| {
        numbered().filter(|(_, scalar)| causalities.contains(&scalar.of.variable.causality))
    };
    let unknown = |xml: &mut Xml, number: usize, inputs: Option<&str>| {
        let number = number.to_string();
        let mut attributes = vec![("index", &*number)];
        attributes.extend(inputs.map(|inputs| ("dependencies", inputs)));
        empty(xml, "Unknown", &attributes)
    };
    if with(&[Causality::Output]).next().is_some() {
        section(xml, "Outputs", |xml| {
            with(&[Causality::Output]).try_for_each(|(number, scalar)| {
                let on = dependencies(scalar.of.variable, of.capabilities);
                let inputs = numbered().filter(|(_, s)| on.contains(&s.of.variable.value_reference));
                let inputs: Vec<String> = inputs.map(|(number, _)| number.to_string()).collect();
                unknown(xml, number, Some(&inputs.join(" ")))
            })
        })?;
    }
    let initial: &[Causality] = &[Causality::Output, Causality::CalculatedParameter];
    if with(initial).next().is_none() {
        return Ok(());
    }
    section(xml, "InitialUnknowns", |xml| {
        with(initial).try_for_each(|(number, _)| unknown(xml, number, None))
    })
}
