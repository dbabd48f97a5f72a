//! Tells the program which commit it was built from.

use std::process::Command;

fn main() {
    // Whatever makes the program or the state of the work tree another one.
    let solvers =
        ["../reservoir-fmu/src", "../reservoir-fmu/fmu/src", "../dam-dem/src", "../dam-dem/fmu/src"];
    let sources = ["src", "../interface/src", "../Cargo.lock"].into_iter().chain(solvers);
    for path in sources.chain(["../.git/HEAD", "../.git/index"]) {
        if std::path::Path::new(path).exists() {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    // Without optional locks: git would write the index anew, and the next build would begin from there.
    let describe = ["--no-optional-locks", "describe", "--always", "--dirty", "--abbrev=12"];
    let output = Command::new("git").args(describe).output();
    let commit = output.ok().filter(|o| o.status.success()).and_then(|o| String::from_utf8(o.stdout).ok());
    println!("cargo:rustc-env=COFFERDAM_COMMIT={}", commit.as_deref().map_or("unknown", str::trim));
}
