//! The descriptions in `modelDescription/` are those that the variables in Rust give, and packed FMUs agree with them.

use cofferdam_dam::Dam;
use cofferdam_fmi::export::contract;
use cofferdam_reservoir::{Reservoir, ReservoirParameters};
use cofferdam_scene::bounds;
use cofferdam_unit::{Shape, Variable, WetFace, variables};
use std::collections::BTreeMap;
use whole_chain::fmu::{Element, Fmu, export};
use whole_chain::generated;
use whole_chain::koyna;
use whole_chain::scenario::root;

/// The contract of the reservoir, compressible and stepped by convolution.
fn reservoir() -> String {
    let face = WetFace::straight([0.0, 1.0], 1).expect("a face");
    contract::<Reservoir>(&ReservoirParameters::before(face), bounds).expect("a description")
}

/// The contract of the dam.
fn dam() -> String {
    contract::<Dam>(&koyna::dam(10.0, true), bounds).expect("a description")
}

#[test]
fn reservoir_xml_is_the_contract_in_rust() {
    generated::whole("modelDescription/reservoir.xml", &reservoir());
}

#[test]
fn dam_xml_is_the_contract_in_rust() {
    generated::whole("modelDescription/dam.xml", &dam());
}

#[test]
fn names_and_value_references_are_unique() {
    let sizes: Vec<_> = Shape::ALL.into_iter().filter_map(Shape::structural_parameter).collect();
    for all in [variables::reservoir::ALL, variables::dam::ALL, variables::coupled::ALL] {
        let of_variables = all.iter().map(|v| (v.name, v.value_reference));
        let of_sizes = sizes.iter().map(|p| (p.name, p.value_reference));
        let used: Vec<_> = of_variables.chain(of_sizes).chain([("time", variables::TIME)]).collect();
        for (i, a) in used.iter().enumerate() {
            assert!(used[..i].iter().all(|b| a.0 != b.0 && a.1 != b.1), "{a:?} is there twice");
        }
    }
}

/// Attributes of a variable but for its start values, and its dimension.
fn described(element: &Element) -> (BTreeMap<String, String>, Option<(String, String)>) {
    let mut attributes = element.attributes.clone();
    attributes.remove("start");
    let dimension = element.children.first().and_then(|d| d.attributes.clone().into_iter().next());
    (attributes, dimension)
}

/// The FMU of a unit of a shipped scene on a mesh of 10 m, with uplift, a bonded crack and all envelopes: its description and its terminals.
fn packed(case: &str, unit: &str) -> (Element, Element) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let strength = "dam.material.tensile_strength=2e6";
    let mut sets = vec!["dam.element_size=10", strength, "dam.uplift=unchanged"];
    if case != "koyna-intact" {
        sets.push("dam.cracks.0.tensile_strength=1e5");
    }
    let more: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).chain(["-o", "x.fmu"]).collect();
    let output = export(folder.path(), &root().join("scenes").join(case), unit, &more);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut fmu = Fmu::open(&folder.path().join("x.fmu"));
    let terminals = Element::read(&fmu.text("terminalsAndIcons/terminalsAndIcons.xml"));
    (fmu.description(), terminals)
}

/// Compares the FMU of the scene with tailwater with the contract; returns the names of its terminals and of their members.
fn packed_agrees(unit: &str, contract: &str, variables: &[Variable]) -> Vec<(String, Vec<String>)> {
    let reference = Element::read(contract);
    let (found, terminals) = packed("koyna-tailwater", unit);

    let mut capabilities = found.child("CoSimulation").attributes.clone();
    let step = capabilities.remove("fixedInternalStepSize");
    assert_eq!(capabilities, reference.child("CoSimulation").attributes);
    let varies = capabilities["canHandleVariableCommunicationStepSize"] == "true";
    assert_eq!(step.as_deref(), (!varies).then_some("0.0025"));
    assert_eq!(found.child("UnitDefinitions"), reference.child("UnitDefinitions"));
    assert_eq!(found.child("TypeDefinitions"), reference.child("TypeDefinitions"));
    assert_eq!(found.child("ModelStructure"), reference.child("ModelStructure"));
    assert_eq!(found.child("DefaultExperiment").get("stepSize"), "0.0025");
    assert!(
        found
            .get("description")
            .ends_with(": Cracked Koyna dam with tailwater, Northridge 1994, Canyon Country 270")
    );

    let all = &found.child("ModelVariables").children;
    // Structural parameters are of the contract only.
    let is_structural = |variable: &&Element| variable.name == "UInt64";
    assert_eq!(all.iter().find(is_structural), None);
    let of_contract = &reference.child("ModelVariables").children;
    let wanted: Vec<_> = of_contract.iter().filter(|variable| !is_structural(variable)).collect();
    assert_eq!(all.len(), wanted.len());
    for (i, (found, wanted)) in all.iter().zip(wanted).enumerate() {
        assert_eq!(found.name, wanted.name, "the type of {}", found.get("name"));
        // The first is the time.
        let size = if i == 0 { 1 } else { size(variables[i - 1].shape) };
        let (attributes, dimension) = described(wanted);
        // A single value is a scalar.
        let fixed = dimension.filter(|_| size > 1).map(|_| ("start".to_owned(), size.to_string()));
        assert_eq!(described(found), (attributes, fixed));
        assert_eq!(found.attributes.contains_key("start"), wanted.attributes.contains_key("start"));
        if found.attributes.contains_key("start") && found.name == "Float64" {
            let start = found.start();
            assert!(start.iter().all(|value| value.is_finite()));
            assert_eq!(start.len(), size, "{}", found.get("name"));
        }
    }

    let member = |member: &Element| {
        assert!(all.iter().any(|v| v.get("name") == member.get("variableName")), "{member:?}");
        member.get("memberName").to_owned()
    };
    let terminal = |terminal: &&Element| {
        assert_eq!(terminal.get("matchingRule"), "bus");
        (terminal.get("name").to_owned(), terminal.children.iter().map(member).collect())
    };
    terminals.list("Terminals", "Terminal").iter().map(terminal).collect()
}

fn named(terminals: &[(&str, &[&str])]) -> Vec<(String, Vec<String>)> {
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    terminals.iter().map(|(name, members)| ((*name).to_owned(), owned(members))).collect()
}

const OF_DAM: &[&str] = &[
    "pressure",
    "hydrostatic_pressure",
    "acceleration",
    "acceleration_end",
    "displacement",
    "velocity",
    "x",
    "y",
    "normal_x",
    "normal_y",
    "length",
];
const OF_WATER: &[&str] =
    &["pressure", "hydrostatic_pressure", "acceleration", "x", "y", "normal_x", "normal_y", "length"];

#[test]
fn a_packed_reservoir_keeps_the_contract() {
    let terminals = packed_agrees("reservoir", &reservoir(), variables::reservoir::ALL);
    assert_eq!(terminals, named(&[("wet_face", OF_WATER)]));
}

#[test]
fn a_packed_dam_keeps_the_contract() {
    let terminals = packed_agrees("dam", &dam(), variables::dam::ALL);
    assert_eq!(terminals, named(&[("wet_face", OF_DAM), ("tailwater_wet_face", OF_DAM)]));
}

#[test]
fn a_dam_without_tailwater_has_no_variables_of_it() {
    let (found, terminals) = packed("koyna-coarse", "dam");
    let wanted = variables::dam::ALL.iter().filter(|v| v.shape != Shape::TailwaterPoints);
    let all = &found.child("ModelVariables").children;
    let names: Vec<_> = all[1..].iter().map(|variable| variable.get("name")).collect();
    assert_eq!(names, wanted.map(|variable| variable.name).collect::<Vec<_>>());
    let known: Vec<&str> = all.iter().map(|variable| variable.get("valueReference")).collect();
    for output in found.list("ModelStructure", "Output") {
        assert!(
            output.get("dependencies").split_whitespace().all(|input| known.contains(&input)),
            "{output:?}"
        );
    }
    let terminals = terminals.list("Terminals", "Terminal");
    assert_eq!(terminals.iter().map(|terminal| terminal.get("name")).collect::<Vec<_>>(), ["wet_face"]);
}

/// Rows of about 10 m: 7 panels in the 66.5 m below the crack and 3 in the 25.25 m above it; on either side one point more
/// than panels.
const INTERFACE_POINTS: usize = 7 + 1 + 3 + 1;
/// 3 panels in the 30 m of tailwater.
const TAILWATER_POINTS: usize = 3 + 1;
/// The mean width of 35.8 m in columns of about 10 m.
const COLUMNS: usize = 3;
/// Rows up to the crack, from there up to the water level, and above it.
const CELLS: usize = COLUMNS * (7 + 3 + 1);
const NODES: usize = CELLS + (COLUMNS + 1) * (7 + 1 + 3 + 1 + 1);

/// Number of values in the scene with tailwater on a mesh of 10 m.
fn size(shape: Shape) -> usize {
    match shape {
        Shape::Scalar | Shape::Plane | Shape::Modes => shape.least_size(),
        Shape::InterfacePoints => INTERFACE_POINTS,
        Shape::TailwaterPoints => TAILWATER_POINTS,
        Shape::Cracks => 1,
        Shape::StressPoints => 4,
        Shape::Nodes => NODES,
        Shape::Triangles => 4 * CELLS,
        Shape::Contacts => 2 * (COLUMNS + 1),
    }
}

#[test]
fn a_dam_without_cracks_has_no_variables_of_cracks() {
    let (found, _) = packed("koyna-intact", "dam");
    let wanted: Vec<_> = variables::dam::ALL
        .iter()
        .filter(|v| !matches!(v.shape, Shape::Cracks | Shape::Contacts | Shape::TailwaterPoints))
        .collect();
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
