//! `cofferdam export-fmu`.

use crate::terminal::{print, show_warnings, warn};
use cofferdam_assembly::packing::{self, PackingError, Target, Unit};
use cofferdam_assembly::read_scene;
use cofferdam_fmi::export::Version;
use cofferdam_scene::{SceneError, Side};
use miette::Diagnostic;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam export-fmu`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    pub scene: PathBuf,

    /// Unit of the scene to export
    #[arg(short, long)]
    pub unit: Exported,

    /// Version of FMI
    ///
    /// With 2, every value is a scalar: `interface_pressure[1]`, `crack.neck.sliding`.
    #[arg(long, value_name = "VERSION", default_value = "3")]
    pub fmi: FmiVersion,

    /// FMU file to write (default: SCENE-UNIT.fmu in the current folder)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Change a value of the scene (repeatable)
    ///
    /// As in `cofferdam run`. The mesh and the cracks of the dam can be changed only here, because they are
    /// fixed in the FMU.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Add the incompressible added mass of the scene's water to the mass of the dam
    ///
    /// For a dam that is simulated without a reservoir. With a reservoir, the water would be counted twice.
    #[arg(long)]
    pub added_mass: bool,

    /// Overwrite an existing file
    #[arg(short, long)]
    pub force: bool,

    /// Shared library of the unit (default: the one built with this program)
    #[arg(long, value_name = "FILE")]
    pub library: Option<PathBuf>,
}

/// What can be exported.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Exported {
    /// Dam
    Dam,
    /// Reservoir
    Reservoir,
    /// Tailwater
    Tailwater,
    /// Dam and waters with their coupling: takes the acceleration of the ground
    Coupled,
}

/// Versions of FMI.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum FmiVersion {
    /// FMI 2.0
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

impl From<FmiVersion> for Version {
    fn from(version: FmiVersion) -> Self {
        match version {
            FmiVersion::Two => Self::Fmi2,
            FmiVersion::Three => Self::Fmi3,
        }
    }
}

pub const HELP: &str = "\
The FMU (FMI 2.0 or 3.0, co-simulation) contains one unit of the scene: its compiled
library for this platform, its parameters, and documentation of its variables
and their use. It needs neither cofferdam nor the files of the scene. The
number of interface points and of cracks is fixed; the importer can change
parameters such as material, friction and damping. documentation/index.html in
the FMU (a zip archive) lists them and explains how to repeat a communication
step.

`--unit coupled` takes a ground acceleration and returns displacements,
sliding, forces and pressures as scalars: the whole coupling runs inside.

Examples:
  cofferdam export-fmu scenes/koyna-coarse --unit coupled --fmi 2
      koyna-coarse-coupled.fmu: dam and water for any FMI 2.0 importer.
  cofferdam export-fmu scenes/koyna-northridge-1994 --unit dam
      koyna-northridge-1994-dam.fmu: the cracked dam under self-weight and
      hydrostatic pressure.
  cofferdam export-fmu scenes/koyna-northridge-1994 --unit reservoir \\
    --output water.fmu --force
      Its reservoir; an existing file water.fmu is overwritten.
  cofferdam export-fmu scenes/koyna-northridge-1994 --unit dam \\
    --set dam.element_size=1.25 --output fine.fmu
      The dam with a finer mesh.

Exit status: 0 exported, 1 the FMU cannot be created or written, 2 the scene is
invalid.";

const WITH_WATER: &str =
    "its mass contains the inertia of the water (added_mass_included = 1): simulate it without a reservoir";
const WITHOUT_WATER: &str =
    "its mass is that of the concrete only (added_mass_included = 0): couple it with a reservoir";
const RESERVOIR: &str =
    "it returns the total hydrodynamic pressure: couple it with a dam whose added_mass_included is 0";

const COUPLED: &str =
    "input: ground_acceleration; with the parameter use_record = 1 the ground moves as in the scene";
const COUPLED_IN_BOTH: &str = "inputs: ground_acceleration, ground_acceleration_vertical; with the parameter use_record = 1 the ground moves as \
     in the scene";

/// Reason why no FMU was written.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Packing(#[from] PackingError),
    #[error("--added-mass is for the dam's FMU alone; leave it out")]
    AddedMass,
}

/// Packs a unit of a scene and reports the result.
pub fn run(arguments: &Arguments) -> ExitCode {
    match execute(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if matches!(error, Failure::Packing(_)) { 1 } else { 2 };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (name, unit, said) = match (arguments.unit, arguments.added_mass) {
        (Exported::Dam, true) => ("dam", Unit::Dam { added_mass: true }, WITH_WATER),
        (Exported::Dam, false) => ("dam", Unit::Dam { added_mass: false }, WITHOUT_WATER),
        (Exported::Reservoir, false) => ("reservoir", Unit::Water(Side::Upstream), RESERVOIR),
        (Exported::Tailwater, false) => ("tailwater", Unit::Water(Side::Downstream), RESERVOIR),
        (Exported::Coupled, false) => ("coupled", Unit::Coupled, COUPLED),
        (_, true) => return Err(Failure::AddedMass),
    };
    let loaded = read_scene(&arguments.scene, &arguments.set)?;
    show_warnings(&loaded.warnings);
    let path = arguments.output.clone().unwrap_or_else(|| format!("{}-{name}.fmu", loaded.name).into());
    let version = Version::from(arguments.fmi);
    let library = arguments.library.as_deref();
    let target = Target { path: &path, overwrite: arguments.force, version, library };
    let packed = packing::pack(unit, &loaded.scene, &loaded.ground_motion, &target)?;
    let step = loaded.scene.time.communication_step;
    let steps = if packed.variable_step { "or any other" } else { "or whole multiples" };
    print(format!(
        "{}: {} kB, FMI {} co-simulation",
        path.display(),
        packed.size.div_ceil(1000),
        version.number()
    ));
    print(format!("{} interface points; communication step {step} s {steps}", packed.interface_points));
    let both = unit == Unit::Coupled && loaded.ground_motion.vertical().is_some();
    print(if both { COUPLED_IN_BOTH } else { said });
    let number = version.number();
    print(format!(
        "for importers of FMI {number} on this platform, such as FMPy; documentation/index.html in it explains its use"
    ));
    Ok(())
}
