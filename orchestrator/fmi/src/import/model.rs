//! What the modelDescription.xml of an FMU says, the same for FMI 2.0 and 3.0.

use super::error::FmuUnitError;
use super::text::decode;
use super::unpacked::Unpacked;
use cofferdam_unit::Shape;
use fmi_rs::model_description::{DefaultExperiment, FMIMajorVersion, ModelDescriptionError, fmi2, fmi3};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::collections::BTreeMap;
use std::path::Path;

/// The parts of a description that an importer needs.
#[derive(Debug)]
pub struct Model {
    pub version: FMIMajorVersion,
    pub name: String,
    pub tool: String,
    pub identifier: String,
    /// Instantiation token, or GUID.
    pub token: String,
    pub saved_state: bool,
    /// Whether it gives its state as bytes.
    pub state_as_bytes: bool,
    pub variable_step: bool,
    /// Length of its own steps, s.
    pub fixed_step: Option<f64>,
    /// Whether the importer gives it memory (FMI 2.0).
    pub wants_memory: bool,
    pub only_once: bool,
    /// Whether it runs only where its tool is installed.
    pub needs_tool: bool,
    /// Stop time of its default experiment, s.
    pub stop_time: Option<f64>,
    /// After [`join_arrays`](Self::join_arrays), scalars `p[1]`, `p[2]`, … count as one array `p`.
    pub variables: Vec<ModelVariable>,
    /// The members of its terminal `wet_face`: variables by member names.
    pub terminal: BTreeMap<String, String>,
}

/// A variable.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelVariable {
    pub name: String,
    /// One of an array of FMI 3.0, or one for each value.
    pub references: Vec<u32>,
    pub kind: Kind,
    pub causality: Causality,
    pub unit: String,
    /// Number of values.
    pub size: usize,
    pub array: bool,
}

/// The type of a variable, in the words of FMI 3.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Float32,
    Float64,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    String,
    /// Binaries, clocks.
    Other,
}

impl Kind {
    /// Whether variables of the contract may have this type.
    pub fn is_number(self) -> bool {
        matches!(self, Self::Float64 | Self::Int32 | Self::Int64 | Self::Boolean)
    }
}

/// What a variable is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    Parameter,
    CalculatedParameter,
    Input,
    Output,
    Local,
    Other,
}

/// Most values of a variable.
const MOST_VALUES: usize = 1 << 24;
/// Longest description, bytes.
const LONGEST: u64 = 256 << 20;

impl Model {
    /// Reads the description of an FMU for co-simulation.
    ///
    /// **Errors**: what it says cannot be understood, or this program cannot do what it needs.
    pub fn read(fmu: &Unpacked) -> Result<Self, FmuUnitError> {
        let path = fmu.description();
        let unreadable =
            |cause: String| FmuUnitError::Description { path: "modelDescription.xml".into(), cause };
        let text = read(&path).map_err(unreadable)?;
        let foreign = |e: ModelDescriptionError| unreadable(e.to_string());
        let version = fmi_version(&text).map_err(unreadable)?;
        let mut model = if version == "2.0" {
            of_fmi2(fmi2::ModelDescription::from_string(&text).map_err(foreign)?)?
        } else if version.starts_with("3.") {
            of_fmi3(&fmi3::ModelDescription::from_string(&text).map_err(foreign)?, &unreadable)?
        } else {
            return Err(FmuUnitError::Version { version });
        };
        if !is_file_name(&model.identifier) {
            return Err(unreadable(format!(
                "its modelIdentifier {:?} is no name of a library",
                model.identifier
            )));
        }
        let name = "terminalsAndIcons/terminalsAndIcons.xml";
        let terminals = fmu.folder().join(name);
        if terminals.is_file() {
            model.terminal = read(&terminals)
                .and_then(|text| terminal(&text))
                .map_err(|cause| FmuUnitError::Description { path: name.into(), cause })?;
        }
        Ok(model)
    }

    /// A description with these variables.
    #[cfg(test)]
    pub fn of_variables(variables: Vec<ModelVariable>) -> Self {
        Self {
            version: FMIMajorVersion::V2,
            name: "water".into(),
            tool: String::new(),
            identifier: "water".into(),
            token: String::new(),
            saved_state: true,
            state_as_bytes: false,
            variable_step: true,
            fixed_step: None,
            wants_memory: false,
            only_once: false,
            needs_tool: false,
            stop_time: None,
            variables,
            terminal: BTreeMap::new(),
        }
    }

    /// Joins the scalars `p[1]`, `p[2]`, … that are left.
    pub fn join_arrays(&mut self) {
        self.variables = arrays(std::mem::take(&mut self.variables));
    }

    /// The real variables of these causalities.
    pub fn real(&self, causalities: &[Causality]) -> impl Iterator<Item = &ModelVariable> {
        self.variables.iter().filter(move |v| v.kind == Kind::Float64 && causalities.contains(&v.causality))
    }
}

/// The text of an XML file.
fn read(path: &Path) -> Result<String, String> {
    let length = std::fs::metadata(path).map_err(|e| e.to_string())?.len();
    if length > LONGEST {
        return Err(format!("it has {} MB, more than {}", length >> 20, LONGEST >> 20));
    }
    decode(&std::fs::read(path).map_err(|e| e.to_string())?)
}

/// The version of FMI that a description names.
fn fmi_version(text: &str) -> Result<String, String> {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event().map_err(|e| e.to_string())? {
            Event::Start(tag) | Event::Empty(tag) => {
                let missing = || "its first element has no attribute `fmiVersion`".to_owned();
                return attribute(&tag, "fmiVersion")?.ok_or_else(missing);
            }
            Event::Eof => return Err("there is no element in it".to_owned()),
            _ => (),
        }
    }
}

/// The stop time of a default experiment.
fn stop_time(experiment: Option<&DefaultExperiment>) -> Option<f64> {
    experiment?.stopTime.as_ref()?.trim().parse().ok()
}

/// Whether it stays in its folder.
fn is_file_name(name: &str) -> bool {
    !name.is_empty() && !name.contains(['/', '\\', '\0']) && name != "." && name != ".."
}

fn of_fmi3(
    description: &fmi3::ModelDescription,
    unreadable: &impl Fn(String) -> FmuUnitError,
) -> Result<Model, FmuUnitError> {
    let tool = description.generationTool.clone().unwrap_or_default();
    let Some(unit) = &description.coSimulation else {
        let me = description.modelExchange.is_some().then_some("model exchange");
        let se = description.scheduledExecution.is_some().then_some("scheduled execution");
        return Err(FmuUnitError::NoCoSimulation { kinds: me.into_iter().chain(se).collect() });
    };
    let fixed_step = match &unit.fixedInternalStepSize {
        Some(text) => Some(
            text.trim()
                .parse()
                .map_err(|_| unreadable(format!("fixedInternalStepSize is {text:?}, which is no number")))?,
        ),
        None => None,
    };
    let mut variables = Vec::new();
    for variable in &description.modelVariables {
        let sizes = description.initial_size(variable).map_err(|e| unreadable(e.to_string()))?;
        let size = sizes.iter().try_fold(1usize, |product, size| product.checked_mul(*size));
        let Some(size) = size.filter(|size| *size <= MOST_VALUES) else {
            return Err(unreadable(format!("variable {:?} has too many values: {sizes:?}", variable.name)));
        };
        let unit = match &variable.variableType {
            fmi3::VariableType::Float64 { unit, .. } => unit.clone().unwrap_or_default(),
            _ => String::new(),
        };
        variables.push(ModelVariable {
            name: variable.name.clone(),
            references: vec![variable.valueReference],
            kind: match variable.variableType.name() {
                "Float32" => Kind::Float32,
                "Float64" => Kind::Float64,
                "Int8" => Kind::Int8,
                "UInt8" => Kind::UInt8,
                "Int16" => Kind::Int16,
                "UInt16" => Kind::UInt16,
                "Int32" => Kind::Int32,
                "UInt32" => Kind::UInt32,
                "Int64" | "Enumeration" => Kind::Int64,
                "UInt64" => Kind::UInt64,
                "Boolean" => Kind::Boolean,
                "String" => Kind::String,
                _ => Kind::Other,
            },
            causality: match variable.causality {
                fmi3::Causality::Parameter => Causality::Parameter,
                fmi3::Causality::CalculatedParameter => Causality::CalculatedParameter,
                fmi3::Causality::Input => Causality::Input,
                fmi3::Causality::Output => Causality::Output,
                fmi3::Causality::Local => Causality::Local,
                _ => Causality::Other,
            },
            unit,
            size,
            array: !variable.dimensions.is_empty(),
        });
    }
    Ok(Model {
        version: FMIMajorVersion::V3,
        name: description.modelName.clone(),
        tool,
        identifier: unit.modelIdentifier.clone(),
        token: description.instantiationToken.clone(),
        saved_state: unit.canGetAndSetFMUState,
        state_as_bytes: unit.canGetAndSetFMUState && unit.canSerializeFMUState,
        variable_step: unit.canHandleVariableCommunicationStepSize,
        fixed_step,
        wants_memory: false,
        only_once: unit.canBeInstantiatedOnlyOncePerProcess,
        needs_tool: unit.needsExecutionTool,
        stop_time: stop_time(description.defaultExperiment.as_ref()),
        variables,
        terminal: BTreeMap::new(),
    })
}

fn of_fmi2(description: fmi2::ModelDescription) -> Result<Model, FmuUnitError> {
    let tool = description.generationTool.clone().unwrap_or_default();
    let Some(unit) = &description.coSimulation else {
        return Err(FmuUnitError::NoCoSimulation { kinds: vec!["model exchange"] });
    };
    let variable = |variable: &fmi2::ScalarVariable| ModelVariable {
        name: variable.name.clone(),
        references: vec![variable.valueReference],
        kind: match variable.variableType {
            fmi2::VariableType::Real { .. } => Kind::Float64,
            fmi2::VariableType::Integer { .. } | fmi2::VariableType::Enumeration { .. } => Kind::Int32,
            fmi2::VariableType::Boolean { .. } => Kind::Boolean,
            fmi2::VariableType::String { .. } => Kind::String,
        },
        causality: match variable.causality {
            fmi2::Causality::Parameter => Causality::Parameter,
            fmi2::Causality::CalculatedParameter => Causality::CalculatedParameter,
            fmi2::Causality::Input => Causality::Input,
            fmi2::Causality::Output => Causality::Output,
            fmi2::Causality::Local => Causality::Local,
            fmi2::Causality::Independent => Causality::Other,
        },
        unit: description.get_unit(variable).unwrap_or_default().to_owned(),
        size: 1,
        array: false,
    };
    Ok(Model {
        version: FMIMajorVersion::V2,
        name: description.modelName.clone(),
        tool,
        identifier: unit.modelIdentifier.clone(),
        token: description.guid.clone(),
        saved_state: unit.canGetAndSetFMUstate,
        state_as_bytes: unit.canGetAndSetFMUstate && unit.canSerializeFMUstate,
        variable_step: unit.canHandleVariableCommunicationStepSize,
        fixed_step: None,
        wants_memory: !unit.canNotUseMemoryManagementFunctions,
        only_once: unit.canBeInstantiatedOnlyOncePerProcess,
        needs_tool: unit.needsExecutionTool,
        stop_time: stop_time(description.defaultExperiment.as_ref()),
        variables: description.modelVariables.iter().map(variable).collect(),
        terminal: BTreeMap::new(),
    })
}

/// Joins scalars `p[1]`, `p[2]`, … or `p[0]`, `p[1]`, …, wherever they stand, into one array `p` at the place of the first, and so
/// `ground_acceleration.x` and `.y` and other pairs along both axes that the contract has as one variable.
fn arrays(variables: Vec<ModelVariable>) -> Vec<ModelVariable> {
    let mut parts: BTreeMap<String, Vec<(usize, usize)>> = BTreeMap::new();
    for (place, variable) in variables.iter().enumerate() {
        if let Some((base, index)) = element(&variable.name).filter(|_| !variable.array) {
            parts.entry(base.to_owned()).or_default().push((index, place));
        }
    }
    let names: Vec<&str> = variables.iter().map(|variable| variable.name.as_str()).collect();
    parts.retain(|base, elements| {
        elements.sort_unstable();
        let first = &variables[elements[0].1];
        let alike = |&(_, place): &(usize, usize)| {
            (variables[place].kind, variables[place].causality) == (first.kind, first.causality)
        };
        let complete = elements.iter().enumerate().all(|(i, (index, _))| *index == i + elements[0].0);
        let both = first.name.ends_with(']') || elements.len() == AXES.len();
        complete
            && both
            && elements[0].0 <= 1
            && elements.iter().all(alike)
            && !names.contains(&base.as_str())
    });
    let mut joined = Vec::new();
    for (place, variable) in variables.iter().enumerate() {
        match element(&variable.name).and_then(|(base, _)| Some((base, parts.get(base)?))) {
            None => joined.push(variable.clone()),
            // At the place of the first element by its number.
            Some((base, elements)) if elements[0].1 == place => joined.push(ModelVariable {
                name: base.to_owned(),
                references: elements.iter().map(|(_, place)| variables[*place].references[0]).collect(),
                size: elements.len(),
                array: true,
                ..variable.clone()
            }),
            Some(_) => (),
        }
    }
    joined
}

/// Ends of names of the components along x and y.
const AXES: [&str; 2] = ["x", "y"];

/// Base and number of a name such as `p[3]`, or `crest_displacement.y` of a variable of the contract.
fn element(name: &str) -> Option<(&str, usize)> {
    if let Some((base, axis)) = name.rsplit_once('.').filter(|_| !name.ends_with(']')) {
        let mut contract = cofferdam_unit::variables::dam::ALL.iter();
        let number = AXES.iter().position(|known| *known == axis)?;
        return contract
            .any(|own| own.shape == Shape::Plane && own.name == base)
            .then_some((base, number + 1));
    }
    let (base, index) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((base, index.trim().parse().ok()?))
}

/// Variables by the member names of the terminal `wet_face`.
fn terminal(text: &str) -> Result<BTreeMap<String, String>, String> {
    let mut members = BTreeMap::new();
    let mut reader = Reader::from_str(text);
    // Names of the terminals around.
    let mut inside = Vec::new();
    loop {
        match reader.read_event().map_err(|e| e.to_string())? {
            Event::Start(tag) if tag.local_name().as_ref() == "Terminal" => {
                inside.push(attribute(&tag, "name")?.unwrap_or_default());
            }
            Event::End(tag) if tag.local_name().as_ref() == "Terminal" => drop(inside.pop()),
            Event::Start(tag) | Event::Empty(tag)
                if tag.local_name().as_ref() == "TerminalMemberVariable"
                    && inside.last().is_some_and(|name| name == "wet_face") =>
            {
                let names = (attribute(&tag, "memberName")?, attribute(&tag, "variableName")?);
                if let (Some(member), Some(variable)) = names {
                    members.insert(member, variable);
                }
            }
            Event::Eof => return Ok(members),
            _ => (),
        }
    }
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, String> {
    match tag.try_get_attribute(name).map_err(|e| e.to_string())? {
        Some(found) => {
            let value = found.normalized_value(XmlVersion::Implicit1_0).map_err(|e| e.to_string())?;
            Ok(Some(value.into_owned()))
        }
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(name: &str, reference: u32, causality: Causality) -> ModelVariable {
        let (references, kind, unit) = (vec![reference], Kind::Float64, String::new());
        ModelVariable { name: name.to_owned(), references, kind, causality, unit, size: 1, array: false }
    }

    #[test]
    fn numbered_scalars_are_arrays_and_others_are_not() {
        use Causality::{Input, Output};
        let variables = vec![
            scalar("p[2]", 12, Output),
            scalar("x", 1, Input),
            scalar("p[1]", 11, Output),
            // One is missing.
            scalar("q[1]", 21, Input),
            scalar("q[3]", 23, Input),
            // Of two kinds.
            scalar("r[0]", 30, Input),
            scalar("r[1]", 31, Output),
            scalar("s[0]", 40, Input),
            scalar("s[1]", 41, Input),
            scalar("ground_acceleration.y", 52, Input),
            scalar("ground_acceleration.x", 51, Input),
            // The other axis is missing.
            scalar("crest_displacement.x", 61, Output),
            // Of no contract.
            scalar("tip.x", 71, Output),
            scalar("tip.y", 72, Output),
        ];
        let joined = arrays(variables);
        let found: Vec<_> = joined.iter().map(|v| (v.name.as_str(), v.references.clone(), v.array)).collect();
        let expected = [
            ("x", vec![1], false),
            ("p", vec![11, 12], true),
            ("q[1]", vec![21], false),
            ("q[3]", vec![23], false),
            ("r[0]", vec![30], false),
            ("r[1]", vec![31], false),
            ("s", vec![40, 41], true),
            ("ground_acceleration", vec![51, 52], true),
            ("crest_displacement.x", vec![61], false),
            ("tip.x", vec![71], false),
            ("tip.y", vec![72], false),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_library_stays_in_its_folder() {
        assert!(is_file_name("water"));
        for name in ["", "..", "a/b", "../water", "a\\b", "a\0b"] {
            assert!(!is_file_name(name), "{name:?}");
        }
    }
}
