//! The XML in `modelDescription/`, the variables in Rust and the FMUs that are packed say the same.

use interface::{Causality, Shape, Variability, Variable, variables};
use std::collections::BTreeMap;
use whole_chain::fmu::{Element, Fmu, export};
use whole_chain::scenario::root;

fn reference(file: &str) -> Element {
    let path = root().join("modelDescription").join(file);
    Element::read(&std::fs::read_to_string(path).expect("the XML"))
}

/// Attributes of a variable, and its dimension.
type Described = (BTreeMap<String, String>, Option<(String, String)>);

fn described(element: &Element) -> Described {
    let mut attributes = element.attributes.clone();
    attributes.remove("start");
    let dimension = element.children.first().and_then(|d| d.attributes.clone().into_iter().next());
    (attributes, dimension)
}

fn expected(variable: &Variable) -> Described {
    let causality = match variable.causality {
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculatedParameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    };
    let variability = match variable.variability {
        Variability::Fixed => "fixed",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let reference = variable.value_reference.to_string();
    let pairs = [
        ("name", variable.name),
        ("valueReference", &reference),
        ("causality", causality),
        ("variability", variability),
        ("unit", variable.unit),
        ("description", variable.description),
    ];
    let dimension = match variable.shape {
        Shape::Scalar => None,
        Shape::Plane => Some(("start", "2")),
        Shape::InterfacePoints => Some(("valueReference", "900")),
        Shape::Cracks => Some(("valueReference", "901")),
        Shape::StressPoints => Some(("valueReference", "902")),
        Shape::Nodes => Some(("valueReference", "903")),
        Shape::Triangles => Some(("valueReference", "904")),
        Shape::Contacts => Some(("valueReference", "905")),
    };
    let own = |(a, b): (&str, &str)| (a.to_owned(), b.to_owned());
    (pairs.map(own).into(), dimension.map(own))
}

/// Value references and dependencies of the outputs.
fn outputs(description: &Element) -> Vec<(u32, Vec<u32>)> {
    let output = |element: &Element| {
        let inputs = element.get("dependencies").split(' ').map(|input| input.parse().expect("a number"));
        (element.get("valueReference").parse().expect("a number"), inputs.collect())
    };
    description.list("ModelStructure", "Output").into_iter().map(output).collect()
}

fn agree(file: &str, variables: &[Variable]) {
    let reference = reference(file);
    let described: Vec<Described> = reference.list("ModelVariables", "Float64")[1..]
        .iter()
        .map(|element| self::described(element))
        .collect();
    assert_eq!(described.len(), variables.len(), "{file}: number of variables");
    for (found, variable) in described.into_iter().zip(variables) {
        assert_eq!(found, expected(variable), "{file}");
    }
    let results = variables.iter().filter(|v| v.causality == Causality::Output);
    let expected: Vec<_> = results.map(|v| (v.value_reference, v.dependencies.to_vec())).collect();
    assert_eq!(outputs(&reference), expected, "{file}: outputs of the model structure");
}

#[test]
fn reservoir_xml_is_the_contract_in_rust() {
    agree("reservoir.xml", variables::reservoir::ALL);
}

#[test]
fn dam_xml_is_the_contract_in_rust() {
    agree("dam.xml", variables::dam::ALL);
}

#[test]
fn names_and_value_references_are_unique() {
    for all in [variables::reservoir::ALL, variables::dam::ALL] {
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                assert!(
                    a.name != b.name && a.value_reference != b.value_reference,
                    "{} and {}",
                    a.name,
                    b.name
                );
            }
        }
    }
}

/// The FMU of a unit of a shipped scene on a mesh of 10 m, and what its terminal is made of.
fn packed(case: &str, unit: &str) -> (Element, Element) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let more = ["--set", "dam.element_size=10", "-o", "x.fmu"];
    let output = export(folder.path(), &root().join("scenes").join(case), unit, &more);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut fmu = Fmu::open(&folder.path().join("x.fmu"));
    let terminals = Element::read(&fmu.text("terminalsAndIcons/terminalsAndIcons.xml"));
    (fmu.description(), terminals)
}

/// Whether the FMU says what the contract says, with these sizes; returns the names of its terminal's members.
fn packed_agrees(unit: &str, interface_points: usize) -> Vec<String> {
    let reference = reference(&format!("{unit}.xml"));
    let (found, terminals) = packed("koyna-northridge-1994", unit);

    let mut capabilities = found.child("CoSimulation").attributes.clone();
    let step = capabilities.remove("fixedInternalStepSize");
    assert_eq!(capabilities, reference.child("CoSimulation").attributes);
    let varies = capabilities["canHandleVariableCommunicationStepSize"] == "true";
    assert_eq!(step.as_deref(), (!varies).then_some("0.0025"));
    assert_eq!(found.child("UnitDefinitions"), reference.child("UnitDefinitions"));
    assert_eq!(found.child("ModelStructure"), reference.child("ModelStructure"));
    assert_eq!(found.child("DefaultExperiment").get("stepSize"), "0.0025");
    assert!(found.get("description").ends_with(": Cracked Koyna dam, Northridge 1994, Canyon Country 270"));

    let all = &found.child("ModelVariables").children;
    assert!(all.iter().all(|variable| variable.name == "Float64"), "no structural parameters");
    let wanted = reference.list("ModelVariables", "Float64");
    assert_eq!(all.len(), wanted.len());
    for (found, wanted) in all.iter().zip(wanted) {
        let (attributes, dimension) = described(wanted);
        let size = match dimension.as_ref().map(|(name, value)| (name.as_str(), value.as_str())) {
            None => None,
            Some(("start", "2")) => Some(2),
            Some(("valueReference", "900")) => Some(interface_points),
            Some(("valueReference", "901")) => Some(1),
            Some(("valueReference", "902")) => Some(4),
            Some(("valueReference", "903")) => Some(NODES),
            Some(("valueReference", "904")) => Some(4 * CELLS),
            Some(("valueReference", "905")) => Some(2 * (COLUMNS + 1)),
            other => panic!("{other:?}"),
        };
        let fixed = size.map(|size| ("start".to_owned(), size.to_string()));
        assert_eq!(described(found), (attributes, fixed));
        assert_eq!(found.attributes.contains_key("start"), wanted.attributes.contains_key("start"));
        if found.attributes.contains_key("start") {
            let start = found.start();
            assert!(start.iter().all(|value| value.is_finite()));
            assert_eq!(start.len(), size.unwrap_or(1), "{}", found.get("name"));
        }
    }

    let terminal = terminals.list("Terminals", "Terminal");
    assert_eq!(terminal.len(), 1);
    assert_eq!((terminal[0].get("name"), terminal[0].get("matchingRule")), ("wet_face", "bus"));
    let member = |member: &Element| {
        assert!(all.iter().any(|v| v.get("name") == member.get("variableName")), "{member:?}");
        member.get("memberName").to_owned()
    };
    terminal[0].children.iter().map(member).collect()
}

#[test]
fn a_packed_reservoir_keeps_the_contract() {
    let members = packed_agrees("reservoir", INTERFACE_POINTS);
    assert_eq!(members, ["pressure", "hydrostatic_pressure", "acceleration"]);
}

#[test]
fn a_packed_dam_keeps_the_contract() {
    let members = packed_agrees("dam", INTERFACE_POINTS);
    assert_eq!(members, ["pressure", "hydrostatic_pressure", "acceleration", "displacement", "velocity"]);
}

/// Rows of 10 m nearly: 7 panels in 66.5 m below the crack, 3 in 25.25 m above; a point more than panels on
/// either side of it.
const INTERFACE_POINTS: usize = 7 + 1 + 3 + 1;
/// As many columns as a mean width of 35.8 m has 10 m; rows up to the crack, up to the water and above it.
const COLUMNS: usize = 3;
const CELLS: usize = COLUMNS * (7 + 3 + 1);
const NODES: usize = CELLS + (COLUMNS + 1) * (7 + 1 + 3 + 1 + 1);

#[test]
fn a_dam_without_cracks_has_no_variables_of_cracks() {
    let (found, _) = packed("koyna-intact", "dam");
    let wanted: Vec<_> =
        variables::dam::ALL.iter().filter(|v| !matches!(v.shape, Shape::Cracks | Shape::Contacts)).collect();
    let variables = &found.child("ModelVariables").children;
    let names = |variable: &Element| variable.get("name").to_owned();
    assert_eq!(
        variables[1..].iter().map(names).collect::<Vec<_>>(),
        wanted.iter().map(|v| v.name).collect::<Vec<_>>()
    );
    let dimensions = variables.iter().flat_map(|v| &v.children);
    assert!(dimensions.map(|d| d.get("start")).all(|size| size != "0"));
    let known: Vec<&str> = variables.iter().map(|v| v.get("valueReference")).collect();
    for entry in &found.child("ModelStructure").children {
        assert!(known.contains(&entry.get("valueReference")), "{entry:?}");
    }
    assert!(found.list("UnitDefinitions", "Unit").iter().all(|unit| unit.get("name") != "Pa/m"));
}
