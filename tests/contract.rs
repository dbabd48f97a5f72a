//! The XML in `modelDescription/` and the variables in Rust say the same.

use interface::{Causality, Shape, Variability, Variable, variables};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use whole_chain::scenario::root;

/// What the XML says of a variable: attributes, and its dimension.
#[derive(Clone, Debug, PartialEq)]
struct Described {
    attributes: BTreeMap<String, String>,
    dimension: Option<(String, String)>,
}

fn attributes(element: &BytesStart<'_>) -> BTreeMap<String, String> {
    let pair =
        |a: quick_xml::events::attributes::Attribute<'_>| (a.key.as_ref().to_owned(), a.value.to_string());
    element.attributes().map(|a| pair(a.expect("an attribute"))).collect()
}

fn described(file: &str) -> (Vec<Described>, Vec<u32>) {
    let text = std::fs::read_to_string(root().join("modelDescription").join(file)).expect("the XML");
    let mut reader = Reader::from_str(&text);
    let (mut variables, mut outputs) = (Vec::new(), Vec::new());
    loop {
        match reader.read_event().expect("well-formed XML") {
            Event::Start(e) | Event::Empty(e) => match e.name().as_ref() {
                "Float64" => variables.push(Described { attributes: attributes(&e), dimension: None }),
                "Dimension" => {
                    let variable: &mut Described = variables.last_mut().expect("a variable");
                    variable.dimension = attributes(&e).into_iter().next();
                }
                "Output" => outputs.push(attributes(&e)["valueReference"].parse().expect("a number")),
                _ => {}
            },
            Event::Eof => return (variables, outputs),
            _ => {}
        }
    }
}

fn expected(variable: &Variable) -> (BTreeMap<String, String>, Option<(String, String)>) {
    let causality = match variable.causality {
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculatedParameter",
        Causality::Input => "input",
        Causality::Output => "output",
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
    };
    let own = |(a, b): (&str, &str)| (a.to_owned(), b.to_owned());
    (pairs.map(own).into(), dimension.map(own))
}

fn agree(file: &str, variables: &[Variable]) {
    let (described, outputs) = described(file);
    let described: Vec<_> =
        described.into_iter().filter(|d| d.attributes["causality"] != "independent").collect();
    assert_eq!(described.len(), variables.len(), "{file}: number of variables");
    for (found, variable) in described.into_iter().zip(variables) {
        let (attributes, dimension) = expected(variable);
        let mut found_attributes = found.attributes;
        found_attributes.remove("start");
        assert_eq!(found_attributes, attributes, "{file}");
        assert_eq!(found.dimension, dimension, "{file}: {}", variable.name);
    }
    let expected: Vec<u32> =
        variables.iter().filter(|v| v.causality == Causality::Output).map(|v| v.value_reference).collect();
    assert_eq!(outputs, expected, "{file}: outputs of the model structure");
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
