//! Tells the program which commit it was built from, and the hashes of the sources that what it keeps on disk is made by.

use std::hash::{DefaultHasher, Hasher};
use std::path::Path;
use std::process::Command;

/// What results are made by, from this folder.
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

/// What prepared operators are made by.
const SOLVERS: [&str; 3] = ["../../reservoir-fmu/src", "../../interface/src", "../../Cargo.lock"];

/// Where git tells the commit and the state of the work tree.
const COMMIT: [&str; 2] = ["../../.git/HEAD", "../../.git/index"];

/// Hashes all files of a folder, or a file, with their names; what cannot be read counts as empty.
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
    for path in SOURCES.into_iter().chain(COMMIT).filter(|path| Path::new(path).exists()) {
        println!("cargo:rerun-if-changed={path}");
    }
    for (name, paths) in [("SOLVERS", &SOLVERS[..]), ("SOURCES", &SOURCES)] {
        let mut hasher = DefaultHasher::new();
        paths.iter().for_each(|path| hash(Path::new(path), &mut hasher));
        println!("cargo:rustc-env=COFFERDAM_{name}={:016x}", hasher.finish());
    }
    // Without optional locks: git would write the index anew, and the next build would begin from there.
    let describe = ["--no-optional-locks", "describe", "--always", "--dirty", "--abbrev=12"];
    let output = Command::new("git").args(describe).output();
    let commit = output.ok().filter(|o| o.status.success()).and_then(|o| String::from_utf8(o.stdout).ok());
    println!("cargo:rustc-env=COFFERDAM_COMMIT={}", commit.as_deref().map_or("unknown", str::trim));
}
