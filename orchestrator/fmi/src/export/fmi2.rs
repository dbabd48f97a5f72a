//! The description of a unit by FMI 2.0.
//!
//! **Source**: Functional Mock-up Interface specification 2.0.4, section 2.2.

use super::model_description::Description;
use super::scalars::{Scalar, units};
use super::variables::number;
use super::xml::{Xml, around, document, empty, section};
use super::{FmuError, SizedVariable};
use cofferdam_unit::Causality;
use cofferdam_unit::export::LOG_CATEGORIES;
use cofferdam_unit::variables::TIME;
use std::collections::BTreeSet;
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
