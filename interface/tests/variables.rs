//! The tables of variables.

use cofferdam_unit::variables::{coupled, dam, reservoir};
use std::collections::BTreeSet;

#[test]
fn names_and_value_references_are_unique_within_a_unit() {
    for (unit, variables) in [("dam", dam::ALL), ("reservoir", reservoir::ALL), ("coupled", coupled::ALL)] {
        let names: BTreeSet<_> = variables.iter().map(|variable| variable.name).collect();
        let references: BTreeSet<_> = variables.iter().map(|variable| variable.value_reference).collect();
        assert_eq!([names.len(), references.len()], [variables.len(); 2], "{unit}");
        // Larger ones are those of single values.
        assert!(references.iter().all(|reference| (1..1000).contains(reference)), "{unit}");
    }
}
