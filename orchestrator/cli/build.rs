//! Gives the program the git commit that it is built from.

use std::path::Path;
use std::process::Command;

/// Where git keeps the commit and the state of the work tree.
const COMMIT: [&str; 2] = ["../../.git/HEAD", "../../.git/index"];

fn main() {
    for path in COMMIT.into_iter().filter(|path| Path::new(path).exists()) {
        println!("cargo:rerun-if-changed={path}");
    }
    // Without optional locks: git would rewrite the index, and the next build would start over.
    let describe = ["--no-optional-locks", "describe", "--always", "--dirty", "--abbrev=12"];
    let output = Command::new("git").args(describe).output();
    let commit = output.ok().filter(|o| o.status.success()).and_then(|o| String::from_utf8(o.stdout).ok());
    println!("cargo:rustc-env=COFFERDAM_COMMIT={}", commit.as_deref().map_or("unknown", str::trim));
}
