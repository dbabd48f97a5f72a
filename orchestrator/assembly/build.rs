//! Hashes the sources that determine results, and those that determine prepared operators.

use std::hash::{DefaultHasher, Hasher};
use std::path::Path;

/// What determines results, from this folder.
const SOURCES: [&str; 12] = [
    "src",
    "../../interface/src",
    "../../reservoir-fmu/src",
    "../../dam-dem/src",
    "../coupling/src",
    "../shared-memory/src",
    "../log/src",
    "../fmi/src",
    "../motion/src",
    "../scene/src",
    "../analysis/src",
    "../../Cargo.lock",
];

/// What determines prepared operators.
const SOLVERS: [&str; 3] = ["../../reservoir-fmu/src", "../../interface/src", "../../Cargo.lock"];

/// Hashes all files of a folder, or a file, with their names; a file that cannot be read counts as empty.
fn hash(path: &Path, hasher: &mut DefaultHasher) {
    hasher.write(path.as_os_str().as_encoded_bytes());
    let mut inside: Vec<_> =
        std::fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path()).collect();
    inside.sort();
    match inside.is_empty() {
        true => hasher.write(&std::fs::read(path).unwrap_or_default()),
        false => inside.iter().for_each(|path| hash(path, hasher)),
    }
}

fn main() {
    for path in SOURCES.into_iter().filter(|path| Path::new(path).exists()) {
        println!("cargo:rerun-if-changed={path}");
    }
    for (name, paths) in [("SOLVERS", &SOLVERS[..]), ("SOURCES", &SOURCES)] {
        let mut hasher = DefaultHasher::new();
        paths.iter().for_each(|path| hash(Path::new(path), &mut hasher));
        println!("cargo:rustc-env=COFFERDAM_{name}={:016x}", hasher.finish());
    }
}
