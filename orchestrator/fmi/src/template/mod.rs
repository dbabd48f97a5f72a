//! Folders from which people write a unit of their own: an FMU in C, or a class in Python.
//!
//! The sources are files beside this one, in which `@word@` is replaced. An FMU's source is the unit's part (`water.c`,
//! `dam.c`) followed by what is the same in both (`fmi3.c`); its points are a header, its descriptions come from
//! [`crate::export`].

mod text;
mod variables;

use crate::export::{Description, FmuError, Times, described};
use cofferdam_unit::{Capabilities, Fingerprint, StateError, WetFace};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use text::Text;

/// Why a folder cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum TemplateError {
    /// Something is there already.
    #[error("{} is not an empty folder; choose another FOLDER, nothing is overwritten", folder.display())]
    Taken {
        /// The folder asked for.
        folder: PathBuf,
    },
    /// A file or folder cannot be written.
    #[error("{}: {cause}; choose another FOLDER", path.display())]
    File {
        /// It.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The descriptions of the FMU.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// The token of the FMU.
    #[error(transparent)]
    Token(#[from] StateError),
}

/// Which unit is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A dam.
    Dam,
    /// A reservoir.
    Reservoir,
}

impl Unit {
    fn text(self) -> &'static Text {
        match self {
            Self::Dam => &text::DAM,
            Self::Reservoir => &text::WATER,
        }
    }
}

/// What the scene says of the unit.
pub struct Place {
    /// The points at which it exchanges.
    pub face: WetFace,
    /// Density of the water, kg/m³.
    pub density: f64,
    /// Gravitational acceleration, m/s².
    pub gravity: f64,
    /// Length of a communication step, s.
    pub communication_step: f64,
    /// Simulated time, s.
    pub end: f64,
    /// Title of the scene.
    pub title: String,
    /// The scene with all defaults, as TOML.
    pub scene: String,
}

/// A file of a folder.
pub struct File {
    /// Path in the folder.
    path: String,
    text: String,
}

/// Checks a folder before any work is done for it.
///
/// **Errors**: [`TemplateError::Taken`], and a folder that cannot be read.
pub fn check_folder(folder: &Path) -> Result<(), TemplateError> {
    match std::fs::read_dir(folder).map(|mut entries| entries.next().is_none()) {
        Ok(true) => Ok(()),
        Ok(false) => Err(TemplateError::Taken { folder: folder.to_owned() }),
        Err(cause) => match cause.kind() {
            std::io::ErrorKind::NotFound => Ok(()),
            std::io::ErrorKind::NotADirectory => Err(TemplateError::Taken { folder: folder.to_owned() }),
            _ => Err(TemplateError::File { path: folder.to_owned(), cause }),
        },
    }
}

/// Writes `files` into `folder`, which is created if necessary. No file is replaced.
///
/// **Errors**: [`TemplateError::File`].
pub fn write(folder: &Path, files: &[File]) -> Result<(), TemplateError> {
    for File { path, text } in files {
        let path = folder.join(path);
        let failed = |cause| TemplateError::File { path: path.clone(), cause };
        path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(failed)?;
        let mut new = std::fs::File::create_new(&path).map_err(failed)?;
        new.write_all(text.as_bytes()).map_err(failed)?;
        if text.starts_with("#!") {
            let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
            std::fs::set_permissions(&path, executable).map_err(failed)?;
        }
    }
    Ok(())
}

/// In what the unit is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C, as an FMU.
    C,
    /// Python, as a process.
    Python,
}

impl Language {
    /// The files of a folder from which `unit` is made.
    ///
    /// **Errors**: descriptions of an FMU that cannot be written.
    pub fn files(self, unit: Unit, place: &Place) -> Result<Vec<File>, TemplateError> {
        match self {
            Self::C => c(unit, place),
            Self::Python => Ok(python(unit, place)),
        }
    }
}

/// A unit in C with everything from which its FMU is built.
fn c(unit: Unit, place: &Place) -> Result<Vec<File>, TemplateError> {
    let text = unit.text();
    let points = place.face.len();
    let fingerprint = Fingerprint::of(text.name, &(place.face.points(), place.density, place.gravity))?;
    let token = format!("own-{}-{fingerprint}", text.name);
    let oscillator = Oscillator::of_depth(place.face.depth());
    let (part, variables) = match unit {
        Unit::Dam => (include_str!("dam.c"), variables::dam(points, &oscillator.parameters())),
        Unit::Reservoir => {
            (include_str!("water.c"), variables::water(points, [place.density, place.gravity]))
        }
    };
    let description = Description {
        name: text.name,
        release: None,
        token: &token,
        text: &format!("{} of one's own: {}", text.title, place.title),
        capabilities: Capabilities {
            variable_communication_step: true,
            directional_derivative: false,
            saved_state: true,
        },
        variables: &variables,
        scene: Some(Times { communication_step: place.communication_step, end: place.end }),
    };
    let mut header = wet_face(place, &token);
    if unit == Unit::Dam {
        header += "\n/* First values of the parameters, as in fmu/modelDescription.xml. */\n";
        for (name, value) in oscillator.parameters() {
            define(&mut header, &name.to_uppercase(), &format!("{value:?}"));
        }
    }
    let readme = readme(include_str!("readme_c.md"), text, points, text.try_fmu, text.fmu_in_scene);
    let file = |path: &str, text: String| File { path: path.to_owned(), text };
    let mut files = vec![
        file("README.md", readme),
        file(&format!("{}.c", text.name), part.to_owned() + include_str!("fmi3.c")),
        file("fmi3.h", include_str!("fmi3.h").to_owned()),
        file("wet_face.h", header),
        file("build.sh", include_str!("build.sh").replace("@name@", text.name)),
        file("fmu/resources/scene.toml", place.scene.clone()),
    ];
    files.extend(described(&description)?.into_iter().map(|(path, xml)| file(&format!("fmu/{path}"), xml)));
    Ok(files)
}

/// A unit in Python.
fn python(unit: Unit, place: &Place) -> Vec<File> {
    let text = unit.text();
    let source = match unit {
        Unit::Dam => {
            let parameters = Oscillator::of_depth(place.face.depth()).parameters();
            parameters.iter().fold(include_str!("dam.py").to_owned(), |source, (name, value)| {
                source.replace(&format!("@{name}@"), &format!("{value:?}"))
            })
        }
        Unit::Reservoir => include_str!("water.py").to_owned(),
    };
    let (try_out, in_scene) = (text.try_python, text.command_in_scene);
    vec![
        File {
            path: "README.md".to_owned(),
            text: readme(include_str!("readme_python.md"), text, place.face.len(), try_out, in_scene),
        },
        File { path: format!("{}.py", text.name), text: source },
    ]
}

fn readme(page: &str, text: &Text, points: usize, try_out: &str, in_scene: &str) -> String {
    let words = [
        ("@Title@", text.title),
        ("@model@", text.model),
        ("@signs@", text.signs),
        ("@try@", try_out),
        ("@scene@", in_scene),
        ("@name@", text.name),
        ("@points@", &points.to_string()),
    ];
    words.iter().fold(page.to_owned(), |page, (word, text)| page.replace(word, text))
}

/// The points as a header of C.
fn wet_face(place: &Place, token: &str) -> String {
    let face = &place.face;
    let mut header = String::from(
        "/* The points of the wet face from the heel up, and what the scene in fmu/resources/scene.toml says; SI units. Where a crack\n \
         * meets the face, two points coincide: the first belongs to the block below it. */\n\n",
    );
    define(&mut header, "POINTS", &face.len().to_string());
    define(&mut header, "TOKEN", &format!("{token:?}"));
    let scalars = [
        ("DEPTH", face.depth()),
        ("DENSITY", place.density),
        ("GRAVITY", place.gravity),
        ("COMMUNICATION_STEP", place.communication_step),
    ];
    for (name, value) in scalars {
        define(&mut header, name, &format!("{value:?}"));
    }
    let column = |axis: usize, of: &[[f64; 2]]| -> Vec<f64> { of.iter().map(|pair| pair[axis]).collect() };
    let (points, normals) = (face.points(), face.normals());
    let arrays = [
        ("X", "coordinates, m: x downstream", column(0, points)),
        ("Y", "y up, from the heel", column(1, points)),
        ("NORMAL_X", "n, out of the water into the dam", column(0, &normals)),
        ("NORMAL_Y", "", column(1, &normals)),
        ("LENGTH", "tributary lengths, m: their sum is the length of the face", face.tributary_lengths()),
    ];
    for (name, comment, values) in arrays {
        let comment = if comment.is_empty() { String::new() } else { format!(" /* {comment} */") };
        // Writing to a string cannot fail.
        let _ = writeln!(header, "\nstatic const double {name}[POINTS] = {{{comment}");
        for value in values {
            let _ = writeln!(header, "    {value:?},");
        }
        header += "};\n";
    }
    header
}

fn define(header: &mut String, name: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(header, "#define {name} {value}");
}

/// The dam as it is written first.
struct Oscillator {
    /// kg/m.
    mass: f64,
    /// N/m over m.
    stiffness: f64,
}

impl Oscillator {
    const DENSITY: f64 = 2400.0;
    const DAMPING_RATIO: f64 = 0.05;

    /// A triangle of concrete 0.8 `depth` (m) wide at the base, with a period of `depth` / 400 m/s; three digits are enough.
    fn of_depth(depth: f64) -> Self {
        let mass = Self::DENSITY * 0.4 * depth * depth;
        let frequency = TAU * 400.0 / depth;
        let rounded = |value: f64| format!("{value:.2e}").parse().unwrap_or(value);
        Self { mass: rounded(mass), stiffness: rounded(mass * frequency * frequency) }
    }

    fn parameters(&self) -> [(&'static str, f64); 3] {
        [("mass", self.mass), ("stiffness", self.stiffness), ("damping_ratio", Self::DAMPING_RATIO)]
    }
}
