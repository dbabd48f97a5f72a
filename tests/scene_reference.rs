//! The keys of a scene stand on their types; what is written of them elsewhere follows.

use cofferdam_scene::reference;
use whole_chain::generated;

#[test]
fn the_reference_in_the_readme_is_that_of_the_types() {
    generated::part("scenes/README.md", "keys of a scene", &reference());
}
