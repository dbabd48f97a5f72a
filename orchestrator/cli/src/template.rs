//! `cofferdam template`.

use crate::options::BuiltIn;
use crate::terminal::{print, show_warnings, warn};
use cofferdam_assembly::packing;
use cofferdam_assembly::{AssemblyError, read_scene};
use cofferdam_fmi::template::{self, Language, Place, TemplateError, Unit};
use cofferdam_scene::SceneError;
use miette::Diagnostic;
use std::path::PathBuf;
use std::process::ExitCode;

/// The languages.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Create an FMU (FMI 3.0, co-simulation) as a single C file
    #[command(after_long_help = C_HELP)]
    C(Arguments),
    /// Create a Python class that the package `cofferdam` serves as a process
    #[command(after_long_help = PYTHON_HELP)]
    Python(Arguments),
}

/// Arguments of both.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder to write; created if necessary, and must be empty
    pub folder: PathBuf,

    /// Scene whose wet face is used: a folder with a scene.toml, or a .toml file
    #[arg(long)]
    pub scene: PathBuf,

    /// Unit of the scene to replace
    #[arg(short, long, default_value = "reservoir")]
    pub unit: BuiltIn,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

const C_HELP: &str = "\
The folder is complete: build.sh compiles the unit with any C compiler and
packs the FMU. README.md explains what to change, how to test the FMU alone
with FMPy, and how to use it in the scene. No FMI headers are needed.
Initially, the reservoir is Westergaard's added mass,
  p = -7/8 rho sqrt(h (h - y)) a,
and the dam is a single-degree-of-freedom oscillator.

Examples:
  cofferdam template c own-water --scene scenes/koyna-intact
      own-water/water.c is a reservoir for the intact Koyna dam;
      own-water/build.sh builds water.fmu.
  cofferdam template c own-dam --scene scenes/rigid-dam-ramp --unit dam
      A dam to replace the rigid one.

Exit status: 0 written, 1 the folder is not empty or cannot be written, 2 the
scene is invalid.";

const PYTHON_HELP: &str = "\
The folder contains water.py or dam.py, and a README.md that explains what to
change, how to test the unit alone, and how to use it in the scene. Initially,
the reservoir is Westergaard's added mass, and the dam is a
single-degree-of-freedom oscillator. The unit receives the points of the wet
face with its task when a run starts.

Example:
  cofferdam template python own-water --scene scenes/koyna-intact

Exit status: 0 written, 1 the folder is not empty or cannot be written, 2 the
scene is invalid.";

/// Reason why no folder was written.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    #[error(transparent)]
    Template(#[from] TemplateError),
    #[error("the scene cannot be written as TOML: {0}")]
    Toml(#[from] toml::ser::Error),
}

/// Writes the folder and reports the result.
pub fn run(command: &Command) -> ExitCode {
    let (language, arguments) = match command {
        Command::C(arguments) => (Language::C, arguments),
        Command::Python(arguments) => (Language::Python, arguments),
    };
    match execute(language, arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if matches!(error, Failure::Scene(_) | Failure::Unit(_)) { 2 } else { 1 };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

fn execute(language: Language, arguments: &Arguments) -> Result<(), Failure> {
    template::check_folder(&arguments.folder)?;
    let loaded = read_scene(&arguments.scene, &arguments.set)?;
    show_warnings(&loaded.warnings);
    let scene = &loaded.scene;
    let communication_step = scene.time.communication_step;
    let place = Place {
        face: arguments.unit.face(scene)?,
        density: arguments.unit.water(scene).density,
        gravity: scene.gravity,
        communication_step,
        // Without what binary numbers add to a sum of decimal ones.
        end: (loaded.steps() as f64 * communication_step * 1e9).round() / 1e9,
        title: scene.title.clone(),
        scene: packing::portable(scene)?,
    };
    let unit = match arguments.unit {
        BuiltIn::Dam => Unit::Dam,
        BuiltIn::Reservoir | BuiltIn::Tailwater => Unit::Reservoir,
    };
    template::write(&arguments.folder, &language.files(unit, &place)?)?;
    print(format!(
        "{}: for {} interface points; README.md in it has the steps",
        arguments.folder.display(),
        place.face.len()
    ));
    Ok(())
}
