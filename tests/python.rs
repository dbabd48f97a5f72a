//! Runs the Python tests in an environment of their own, which is created if it is missing or outdated.

use std::path::Path;
use std::process::Command;
use whole_chain::scenario::{binary, root};

fn succeed(command: &mut Command) {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}\n{out}\n{err}");
    println!("{out}");
}

#[test]
fn python_tests() {
    let folder = root().join("tests/python");
    let requirements = std::fs::read_to_string(folder.join("requirements.txt")).expect("the requirements");
    let environment = binary().parent().and_then(Path::parent).expect("the target folder").join("python");
    let installed = environment.join("installed.txt");
    if std::fs::read_to_string(&installed).ok().as_deref() != Some(&*requirements) {
        succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment));
        let mut install = Command::new(environment.join("bin/python"));
        install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]);
        succeed(install.arg(folder.join("requirements.txt")));
        std::fs::write(&installed, requirements).expect("the list of what is installed");
    }
    let mut pytest = Command::new(environment.join("bin/python"));
    pytest
        .args(["-B", "-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .arg(&folder)
        .env("COFFERDAM", binary());
    succeed(pytest.current_dir(root()));
}
