//! Differing and equal inputs of two runs.

use super::super::folder::RunFolder;
use crate::Build;
use cofferdam_log::{KeyDifference, settings};
use cofferdam_scene::Shock;

/// Keys whose text is too long for a table.
const LONG: &str = "mesh.text";

/// Differing keys of the scenes; then other differences: units, ground motion, program, machine.
pub fn differing(runs: [&RunFolder; 2]) -> (Vec<KeyDifference>, Vec<KeyDifference>) {
    let of_channel =
        |key: &str| key.starts_with('[') && (key.contains(" request ") || key.contains(" answer "));
    let shown = |setting: &KeyDifference| !setting.key.ends_with(LONG) && !of_channel(&setting.key);
    let all = settings(runs.map(|run| &run.log)).into_iter().filter(shown);
    let (mut origin, scene): (Vec<_>, Vec<_>) = all.partition(|setting| setting.key.starts_with('['));
    for setting in &mut origin {
        // As in sentences: `reservoir: solver`.
        setting.key = setting.key.replacen('[', "", 1).replacen(']', ":", 1);
    }
    let [a, b] = runs.map(|run| origins(&run.manifest.build));
    let differ = a.into_iter().zip(b).filter(|((_, a), (_, b))| a != b);
    origin.extend(
        differ.map(|((key, a), (_, b))| KeyDifference { key: key.to_owned(), values: [Some(a), Some(b)] }),
    );
    (scene, origin)
}

/// Program and machine.
fn origins(build: &Build) -> [(&'static str, String); 6] {
    [
        ("program", format!("cofferdam {}, {}", build.version, build.profile)),
        ("commit", build.commit.to_string()),
        ("processor", build.processor.clone()),
        ("processor features", build.features.clone()),
        ("cores", build.cores.to_string()),
        ("system", build.system.clone()),
    ]
}

/// Descriptions of equal inputs; `keys` is the number of equal keys of the scenes.
pub fn equal(runs: [&RunFolder; 2], keys: usize) -> Vec<String> {
    let mut said = vec![format!("{keys} keys of the scene")];
    let [a, b] = runs.map(|run| run.loaded.scene.ground_motion.shocks());
    for (a, b) in a.iter().zip(&b) {
        if let (Some(hash), Some(other)) = (&a.record.sha256, &b.record.sha256)
            && hash == other
        {
            said.push(format!("the record {} (SHA-256 {hash})", a.file_name()));
        }
        let hash = |shock: &Shock<'_>| shock.vertical.and_then(|vertical| vertical.sha256.clone());
        if let (Some(hash), Some(other), Some(name)) = (hash(a), hash(b), a.vertical_file_name())
            && hash == other
        {
            said.push(format!("the vertical record {name} (SHA-256 {hash})"));
        }
    }
    if runs[0].loaded.ground_motion == runs[1].loaded.ground_motion {
        said.push("the ground motion".to_owned());
    }
    for unit in &runs[0].manifest.units {
        let same = |other: &&crate::Unit| other.name == unit.name && other.fingerprint == unit.fingerprint;
        if runs[1].manifest.units.iter().any(|other| same(&other)) {
            said.push(format!("the unit {} ({})", unit.name, unit.solver));
        }
    }
    let [a, b] = runs.map(|run| origins(&run.manifest.build));
    for ((name, a), (_, b)) in a.into_iter().zip(b).filter(|((_, a), _)| !a.is_empty()) {
        if a == b {
            said.push(format!("{name} {a}"));
        }
    }
    said
}

/// Difference of two dams; `None` if they are the same.
pub fn dams(runs: [&RunFolder; 2]) -> Option<String> {
    let scenes = runs.map(|run| &run.loaded.scene);
    match scenes.map(|scene| scene.dam.as_ref()) {
        [None, None] => (scenes[0].height() != scenes[1].height()).then(|| heights(runs)),
        [Some(_), None] => Some("the dam of A is computed, the dam of B is prescribed".to_owned()),
        [None, Some(_)] => Some("the dam of A is prescribed, the dam of B is computed".to_owned()),
        [Some(a), Some(b)] if a.section == b.section => None,
        [Some(_), Some(_)] => Some(heights(runs)),
    }
}

fn heights(runs: [&RunFolder; 2]) -> String {
    let [a, b] = runs.map(|run| cofferdam_unit::number::plain(run.loaded.scene.height()).to_string());
    if a == b {
        format!("their sections differ, both are {a} m high")
    } else {
        format!("A is {a} m high, B is {b} m high")
    }
}
