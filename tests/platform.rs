//! What is passed on, the command and the libraries of FMUs, is small and tells nothing of the machine that built it.

use std::path::PathBuf;
use whole_chain::scenario::{binary, root};

/// Largest size of the command, bytes; 7 MB of it write Parquet. (29.3 MB before loads and `stability`, 30.8 MB with them; compiling
/// crates for size makes it larger.)
const MOST: usize = 34_000_000;

#[test]
fn the_command_and_the_libraries_hold_no_path_of_the_machine() {
    let home = std::env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
    let cargo = std::env::var_os("CARGO_HOME").map_or_else(|| home.join(".cargo"), PathBuf::from);
    let folder = binary().parent().expect("target/<profile>");
    for file in ["cofferdam", "deps/libdam_fmu.so", "deps/libreservoir_fmu.so", "deps/libcoupled_fmu.so"] {
        let bytes = std::fs::read(folder.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        println!("{file}: {:.1} MB", bytes.len() as f64 / 1e6);
        assert!(bytes.len() < MOST, "{file} has {} bytes", bytes.len());
        for path in [&cargo, &root()] {
            let path = path.to_str().expect("a readable path").as_bytes();
            assert!(path.len() > 2, "no path to look for");
            // The sources are built through `.cargo/rustc`, unless RUSTC_WRAPPER names another wrapper.
            let found = bytes.windows(path.len()).position(|window| window == path);
            let around =
                found.map(|at| String::from_utf8_lossy(&bytes[at..(at + 120).min(bytes.len())]).into_owned());
            assert_eq!(around, None, "{file} names a path of this machine");
        }
    }
}
