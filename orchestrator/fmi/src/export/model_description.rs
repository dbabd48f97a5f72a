use super::definitions::{DeclaredType, types, units};
use super::scalars::Scalar;
use super::variables::{dependencies, number, role, value_text};
use super::xml::{Xml, around, document, empty, section};
use super::{FmuError, SizedVariable};
use cofferdam_unit::export::LOG_CATEGORIES;
use cofferdam_unit::variables::TIME;
use cofferdam_unit::{Capabilities, Causality, DataType, Shape, Variable};
use std::io;

/// What a modelDescription.xml says, of a packed FMU or of the contract.
pub struct Description<'a> {
    /// Name of the unit, and of its library.
    pub name: &'static str,
    /// Version and licence of the unit, where it is one of this program's.
    pub release: Option<(&'static str, &'static str)>,
    /// Instantiation token.
    pub token: &'a str,
    /// The unit in one line.
    pub text: &'a str,
    /// What the unit can do.
    pub capabilities: Capabilities,
    /// The variables with their sizes.
    pub variables: &'a [SizedVariable],
    /// The times of a packed FMU's scene. The contract has none; there, structural parameters stand for the sizes.
    pub scene: Option<Times>,
}

/// Times of a scene, s.
pub struct Times {
    /// Length of a communication step.
    pub communication_step: f64,
    /// Simulated time.
    pub end: f64,
}

/// The text of modelDescription.xml; with `scalars`, these are the variables in place of arrays.
pub fn write(of: &Description<'_>, scalars: Option<&[Scalar<'_>]>) -> Result<String, FmuError> {
    let tool = format!("cofferdam {}", env!("CARGO_PKG_VERSION"));
    let mut attributes = vec![
        ("fmiVersion", "3.0"),
        ("modelName", of.name),
        ("instantiationToken", of.token),
        ("description", of.text),
    ];
    if let Some((version, licence)) = of.release {
        attributes.extend([("version", version), ("license", licence)]);
    }
    if of.scene.is_some() {
        attributes.push(("generationTool", &tool));
    }
    attributes.push(("variableNamingConvention", "structured"));
    let content = |xml: &mut Xml| {
        co_simulation(xml, of)?;
        let variables = || match scalars {
            Some(scalars) => scalars.iter().map(|scalar| scalar.of.variable).collect(),
            None => of.variables.iter().map(|sized| sized.variable).collect::<Vec<_>>(),
        };
        section(xml, "UnitDefinitions", |xml| units(xml, variables().into_iter()))?;
        section(xml, "TypeDefinitions", |xml| {
            types(variables().into_iter()).iter().try_for_each(|declared| {
                let attributes = declared.attributes();
                let mut all = vec![("name", declared.name)];
                all.extend(attributes.iter().map(|(name, value)| (*name, value.as_str())));
                empty(xml, "Float64Type", &all)
            })
        })?;
        if let Some(times) = &of.scene {
            section(xml, "LogCategories", |xml| {
                LOG_CATEGORIES.iter().try_for_each(|(name, description)| {
                    empty(xml, "Category", &[("name", name), ("description", description)])
                })
            })?;
            let experiment = [
                ("startTime", "0.0"),
                ("stopTime", &number(times.end)),
                ("stepSize", &number(times.communication_step)),
            ];
            empty(xml, "DefaultExperiment", &experiment)?;
        }
        section(xml, "ModelVariables", |xml| {
            let time = [
                ("name", "time"),
                ("valueReference", &TIME.to_string()),
                ("causality", "independent"),
                ("variability", "continuous"),
                ("unit", "s"),
                ("description", "simulated time"),
            ];
            empty(xml, "Float64", &time)?;
            if of.scene.is_none() {
                structural_parameters(xml, of.variables)?;
            }
            match scalars {
                Some(scalars) => scalars.iter().try_for_each(|scalar| single(xml, scalar)),
                None => of.variables.iter().try_for_each(|variable| one(xml, variable, of.scene.is_none())),
            }
        })?;
        section(xml, "ModelStructure", |xml| match scalars {
            Some(scalars) => structure_of_scalars(xml, scalars),
            None => structure(xml, of),
        })
    };
    document(|xml| {
        let root = xml.create_element("fmiModelDescription").with_attributes(attributes);
        root.write_inner_content(content).map(drop)
    })
}

fn co_simulation(xml: &mut Xml, of: &Description<'_>) -> io::Result<()> {
    let truth = |value: bool| if value { "true" } else { "false" };
    let mut attributes = vec![
        ("modelIdentifier", of.name),
        ("needsExecutionTool", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canGetAndSetFMUState", "true"),
        ("canSerializeFMUState", "true"),
        ("providesDirectionalDerivatives", truth(of.capabilities.directional_derivative)),
        ("canHandleVariableCommunicationStepSize", truth(of.capabilities.variable_communication_step)),
    ];
    let step = of.scene.as_ref().map(|times| number(times.communication_step));
    if !of.capabilities.variable_communication_step {
        attributes.extend(step.as_deref().map(|step| ("fixedInternalStepSize", step)));
    }
    empty(xml, "CoSimulation", &attributes)
}

/// The numbers of values on which the shapes of the variables depend.
fn structural_parameters(xml: &mut Xml, variables: &[SizedVariable]) -> io::Result<()> {
    let used = Shape::ALL.into_iter().filter(|shape| variables.iter().any(|v| v.variable.shape == *shape));
    for parameter in used.filter_map(Shape::structural_parameter) {
        let attributes = [
            ("name", parameter.name),
            ("valueReference", &parameter.value_reference.to_string()),
            ("causality", "structuralParameter"),
            ("variability", "fixed"),
            ("start", &parameter.least.to_string()),
            ("description", parameter.description),
        ];
        empty(xml, "UInt64", &attributes)?;
    }
    Ok(())
}

/// A variable; with `structural`, its dimension names a structural parameter where it depends on the scene.
fn one(xml: &mut Xml, sized: &SizedVariable, structural: bool) -> io::Result<()> {
    let Variable { name, shape, data_type, .. } = *sized.variable;
    let reference = sized.variable.value_reference;
    let attributes = attributes(name, reference, sized, sized.start_text());
    let attributes: Vec<_> = attributes.iter().map(|(name, value)| (*name, value.as_str())).collect();
    // Importers set a single value without a list.
    if shape == Shape::Scalar || (sized.size == 1 && !structural) {
        return empty(xml, data_type.fmi3_name(), &attributes);
    }
    let (dimension, value) = match shape.structural_parameter().filter(|_| structural) {
        Some(parameter) => ("valueReference", parameter.value_reference.to_string()),
        None => ("start", sized.size.to_string()),
    };
    around(xml, (data_type.fmi3_name(), &attributes), ("Dimension", &[(dimension, &value)]))
}

/// A scalar.
fn single(xml: &mut Xml, scalar: &Scalar<'_>) -> io::Result<()> {
    let data_type = scalar.of.variable.data_type;
    let start = scalar.start.map(|value| value_text(data_type, value));
    let attributes = attributes(&scalar.name, scalar.reference, scalar.of, start);
    let attributes: Vec<_> = attributes.iter().map(|(name, value)| (*name, value.as_str())).collect();
    empty(xml, data_type.fmi3_name(), &attributes)
}

/// The attributes of a variable, or of one of its values.
fn attributes(
    name: &str,
    reference: u32,
    sized: &SizedVariable,
    start: Option<String>,
) -> Vec<(&'static str, String)> {
    let variable = sized.variable;
    let (causality, variability) = role(variable);
    let mut attributes = vec![
        ("name", name.to_owned()),
        ("valueReference", reference.to_string()),
        ("causality", causality.to_owned()),
        ("variability", variability.to_owned()),
    ];
    attributes.extend(DeclaredType::of(variable).map(|declared| ("declaredType", declared.name.to_owned())));
    if variable.data_type == DataType::Real {
        attributes.push(("unit", variable.unit.to_owned()));
        attributes.extend(variable.display_unit().map(|(unit, _)| ("displayUnit", unit.to_owned())));
    }
    attributes.extend(sized.bound_texts());
    attributes.extend(start.map(|start| ("start", start)));
    attributes.push(("description", variable.description.to_owned()));
    attributes
}

fn structure_of_scalars(xml: &mut Xml, scalars: &[Scalar<'_>]) -> io::Result<()> {
    let of = |causality| scalars.iter().filter(move |scalar| scalar.of.variable.causality == causality);
    for output in of(Causality::Output) {
        // Outputs follow from a step, not from inputs that are set between steps.
        empty(xml, "Output", &[("valueReference", &*output.reference.to_string()), ("dependencies", "")])?;
    }
    of(Causality::Output).chain(of(Causality::CalculatedParameter)).try_for_each(|scalar| {
        empty(xml, "InitialUnknown", &[("valueReference", &scalar.reference.to_string())])
    })
}

fn structure(xml: &mut Xml, of: &Description<'_>) -> io::Result<()> {
    let variables = of.variables;
    let exists = |reference: &&u32| variables.iter().any(|v| v.variable.value_reference == **reference);
    let outputs = || variables.iter().map(|v| v.variable).filter(|v| v.causality == Causality::Output);
    for output in outputs() {
        let inputs = dependencies(output, of.capabilities).iter().filter(exists);
        let (reference, inputs) = (output.value_reference.to_string(), inputs.map(u32::to_string));
        let inputs = inputs.collect::<Vec<_>>().join(" ");
        empty(xml, "Output", &[("valueReference", &reference), ("dependencies", &inputs)])?;
    }
    let unknown = |v: &&Variable| matches!(v.causality, Causality::Output | Causality::CalculatedParameter);
    for variable in variables.iter().map(|v| v.variable).filter(unknown) {
        empty(xml, "InitialUnknown", &[("valueReference", &variable.value_reference.to_string())])?;
    }
    Ok(())
}
