//! The version of the defaults, and which of them have moved.

use super::shape::Shape;

/// The version of today.
pub const VERSION: u32 = 5;

/// A default that is another one since some version.
struct Moved {
    since: u32,
    key: &'static str,
    /// The default before, as a scene would have it.
    before: &'static str,
}

/// Whoever moves a default raises the version and adds a line.
const MOVED: &[Moved] = &[
    Moved { since: 2, key: "coupling.acceleration", before: "\"aitken\"" },
    Moved { since: 2, key: "coupling.measures", before: "[\"pressure\", \"displacement\"]" },
    Moved { since: 3, key: "dam.damping.drags_blocks", before: "true" },
    Moved { since: 4, key: "coupling.tolerance", before: "1e-6" },
    Moved { since: 4, key: "reservoir.method", before: "\"radau2\"" },
    Moved { since: 4, key: "tailwater.method", before: "\"radau2\"" },
    Moved { since: 5, key: "dam.uplift", before: "\"none\"" },
];

/// A sentence for each default that has moved since `version` and that a scene takes: its key is not `given`.
pub fn moved(version: u32, given: impl Fn(&str) -> bool) -> Vec<String> {
    let there = |key: &str| {
        let table = key.rsplit_once('.').map_or("", |(table, _)| table);
        given(table) || !Shape::is_like_another(table)
    };
    let moved = MOVED.iter().filter(|moved| moved.since > version && !given(moved.key) && there(moved.key));
    let sentence = |Moved { since, key, before }: &Moved| {
        let now = Shape::field(key).and_then(|field| field.default.as_ref());
        let now = now.map_or_else(|| "other".to_owned(), ToString::to_string);
        format!(
            "the default of `{key}` has moved: {before} before version {since} of scenes, {now} here; give the key, or set \
             `scene_version` to {VERSION}"
        )
    };
    moved.map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_that_has_moved_is_one_and_another_than_before() {
        for Moved { since, key, before } in MOVED {
            let field = Shape::field(key).expect("a key of a scene");
            let now = field.default.as_ref().expect("a default").to_string();
            assert!(*since <= VERSION && now != before.replace(", ", ","), "{key}: {now}");
        }
    }

    #[test]
    fn a_scene_that_names_an_old_version_is_told_what_it_does_not_set() {
        assert!(moved(VERSION, |_| false).is_empty());
        let said = moved(1, |key| key == "coupling.measures");
        assert!(said.len() == 5 && said[0].contains("\"aitken\" before version 2"), "{said:?}");
        // What is said of a tailwater needs one.
        assert_eq!(moved(3, |key| key == "tailwater").len(), 4);
    }
}
