//! The Python environment of the tests: what `tests/python/requirements.txt` lists, and the package `cofferdam`.

use crate::scenario::{binary, root};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Runs a command that must succeed, and prints its output.
pub fn succeed(command: &mut Command) {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}\n{out}\n{err}");
    println!("{out}");
}

/// The interpreter of the environment, which is created if it is missing or outdated.
pub fn interpreter() -> &'static Path {
    static INTERPRETER: OnceLock<PathBuf> = OnceLock::new();
    INTERPRETER.get_or_init(|| {
        let requirements = root().join("tests/python/requirements.txt");
        let package = root().join("python/pyproject.toml");
        let read = |path: &Path| std::fs::read_to_string(path).expect("what is needed");
        let needed = read(&requirements) + &read(&package);
        let environment = binary().parent().and_then(Path::parent).expect("the target folder").join("python");
        let (interpreter, installed) = (environment.join("bin/python"), environment.join("installed.txt"));
        if std::fs::read_to_string(&installed).ok().as_deref() != Some(&*needed) {
            succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment));
            let mut install = Command::new(&interpreter);
            install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]);
            succeed(install.arg(&requirements).current_dir(root()));
            std::fs::write(&installed, needed).expect("the list of what is installed");
        }
        interpreter
    })
}
