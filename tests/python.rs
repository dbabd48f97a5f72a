//! Runs the Python tests.

use std::process::Command;
use whole_chain::python::{interpreter, succeed};
use whole_chain::scenario::{binary, root};

#[test]
fn python_tests() {
    let mut pytest = Command::new(interpreter());
    pytest
        .args(["-B", "-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .arg(root().join("tests/python"))
        .env("COFFERDAM", binary());
    succeed(pytest.current_dir(root()));
}
