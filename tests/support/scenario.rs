//! A shipped scene, varied, and what running it gives.

use std::collections::HashMap;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;
use toml::{Table, Value};

/// The root of the project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests lie in the project").to_owned()
}

/// The binary `cofferdam`, built with the profile of the tests.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| built("cofferdam"))
}

/// The developers' binary `cofferdam-lab`, likewise.
pub fn lab() -> &'static Path {
    static LAB: OnceLock<PathBuf> = OnceLock::new();
    LAB.get_or_init(|| built("cofferdam-lab"))
}

fn built(program: &str) -> PathBuf {
    // target/<profile>/deps/<test>: the profile is that of the running test.
    let test = std::env::current_exe().expect("a test has a path");
    let folder = test.ancestors().nth(2).expect("target/<profile>/deps").to_owned();
    let mut build = Command::new(env!("CARGO"));
    // Of the whole workspace, with the features that a test of all its packages has built it with.
    build.current_dir(root()).args(["build", "--locked", "--quiet", "--workspace", "--bin", program]);
    build.arg("--target-dir").arg(folder.parent().expect("target/<profile>"));
    if folder.ends_with("release") {
        build.arg("--release");
    }
    assert!(build.status().expect("cargo runs").success(), "{program} does not build");
    folder.join(program)
}

/// Whether the tests run as root, who alone can run a program as another user.
pub fn is_root() -> bool {
    std::fs::metadata("/proc/self").is_ok_and(|metadata| metadata.uid() == 0)
}

/// A shipped scene that can be varied, in a folder of its own.
pub struct Scenario {
    table: Table,
    folder: TempDir,
}

impl Scenario {
    /// The shipped scene `case`, its record made an absolute path.
    pub fn shipped(case: &str) -> Self {
        let folder = root().join("scenes").join(case);
        let text = std::fs::read_to_string(folder.join("scene.toml")).expect("a shipped scene");
        let mut scenario = Self {
            table: text.parse().expect("a shipped scene is TOML"),
            folder: tempfile::tempdir().expect("a temporary folder"),
        };
        if let Some(Value::String(file)) = scenario.find("ground_motion.record.file") {
            let file = folder.join(file).to_string_lossy().into_owned();
            scenario.set("ground_motion.record.file", file);
        }
        scenario
    }

    /// The main scene, coarse, with water that needs no preparation, for this long (s).
    pub fn quick(duration: f64) -> Self {
        let mut scenario = Self::shipped("koyna-coarse");
        scenario.set("dam.element_size", 10.0).set("time.duration", duration);
        scenario.set("reservoir.fidelity", "westergaard").set("coupling.scheme", "serial-implicit");
        scenario
    }

    fn find(&mut self, key: &str) -> Option<&mut Value> {
        let mut parts = key.split('.');
        let mut value = self.table.get_mut(parts.next()?)?;
        for part in parts {
            value = match value {
                Value::Array(array) => array.get_mut(part.parse::<usize>().ok()?)?,
                _ => value.get_mut(part)?,
            };
        }
        Some(value)
    }

    /// Sets the value at `key`, such as `dam.cracks.0.elevation`; its table must exist.
    pub fn set(&mut self, key: &str, new: impl Into<Value>) -> &mut Self {
        let new = new.into();
        match key.rsplit_once('.') {
            None => drop(self.table.insert(key.to_owned(), new)),
            Some((parent, last)) => match self.find(parent) {
                Some(Value::Table(table)) => drop(table.insert(last.to_owned(), new)),
                Some(Value::Array(array)) => array[last.parse::<usize>().expect("an index")] = new,
                _ => panic!("no table {parent}"),
            },
        }
        self
    }

    /// Removes the value at `key`.
    pub fn remove(&mut self, key: &str) -> &mut Self {
        match key.rsplit_once('.') {
            None => drop(self.table.remove(key)),
            Some((parent, last)) => match self.find(parent) {
                Some(Value::Table(table)) => drop(table.remove(last)),
                _ => panic!("no table {parent}"),
            },
        }
        self
    }

    /// The folder that the scene is written into.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Writes the scene; returns the path of its file.
    pub fn write(&self) -> PathBuf {
        let path = self.folder().join("scene.toml");
        std::fs::write(&path, toml::to_string(&self.table).expect("a table is TOML"))
            .expect("scene.toml is written");
        path
    }

    /// A folder that every user may use, with the program, the scene, as `scene.toml`, and its record.
    pub fn for_all_users(&mut self) -> TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::set_permissions(folder.path(), PermissionsExt::from_mode(0o777)).expect("permissions");
        std::fs::copy(binary(), path("cofferdam")).expect("a copy");
        if let Some(Value::String(file)) = self.find("ground_motion.record.file") {
            std::fs::copy(std::mem::replace(file, "record.csv".to_owned()), path("record.csv"))
                .expect("a copy");
        }
        std::fs::copy(self.write(), path("scene.toml")).expect("a copy");
        folder
    }

    /// Runs the scene into the folder `output` under the scene's; returns what the program said.
    pub fn try_run(&self, output: &str) -> Output {
        let mut command = self.command(output);
        command.output().expect("cofferdam runs")
    }

    /// The command that runs the scene.
    pub fn command(&self, output: &str) -> Command {
        let mut command = Command::new(binary());
        command.arg("run").arg(self.write()).arg("--quiet").arg("--output").arg(self.folder().join(output));
        command
    }

    /// Runs the scene to its end, in one process, which has the same bits sooner, and reads the histories.
    pub fn run(&self) -> Histories {
        let mut command = self.command("run");
        let output = command.args(["--transport", "in-process"]).output().expect("cofferdam runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Histories::read(&self.folder().join("run/histories.csv"))
    }
}

/// The columns of a CSV file, by name without unit.
pub struct Histories(HashMap<String, Vec<f64>>);

impl Histories {
    /// Reads `path`.
    pub fn read(path: &Path) -> Self {
        let mut reader = csv::Reader::from_path(path).expect("histories are readable");
        let header = reader.headers().expect("histories have a header").clone();
        let names: Vec<&str> = header.iter().map(|h| h.split(" [").next().unwrap_or(h)).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for record in reader.records() {
            for (column, field) in columns.iter_mut().zip(&record.expect("a row")) {
                column.push(field.parse().expect("a number"));
            }
        }
        Self(names.into_iter().map(str::to_owned).zip(columns).collect())
    }

    /// The column `name`, such as `dam.crest_displacement.x`.
    pub fn column(&self, name: &str) -> &[f64] {
        self.0.get(name).unwrap_or_else(|| panic!("no column {name} among {:?}", self.0.keys()))
    }

    /// All values.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        self.0.values().flatten().copied()
    }
}
