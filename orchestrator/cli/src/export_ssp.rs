//! `cofferdam export-ssp`.

use crate::terminal::{print, show_warnings, warn};
use cofferdam_assembly::packing::{PackedSystem, PackingError, Target, pack_system};
use cofferdam_assembly::read_scene;
use cofferdam_fmi::export::Version;
use cofferdam_scene::SceneError;
use miette::Diagnostic;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam export-ssp`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    pub scene: PathBuf,

    /// SSP archive to write (default: SCENE.ssp in the current folder)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Change a value of the scene (repeatable)
    ///
    /// As in `cofferdam run`. The ground motion and the communication step can be changed only here, because they are
    /// fixed in the FMUs.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Overwrite an existing file
    #[arg(short, long)]
    pub force: bool,
}

pub const HELP: &str = "\
The archive (SSP 1.0) contains the dam, the reservoir and, if the scene has one,
the tailwater as FMUs of FMI 2.0 with their connections, parameters and
documentation. The ground motion of the scene is inside the FMUs. It is for
importers that step all units at once and repeat no step, such as libcosim,
ecos or FMPy's simulate_ssp; `export-fmu --unit coupled` packs the same system
with the iteration inside.

To be stable without iteration, the mass of the dam contains the water's
response to the step itself, and the reservoir returns the rest of the pressure
one step ahead. The importer must take steps of `time.communication_step`.
Results differ from `cofferdam run` by a term of third order in this step:
docs/guide/fmpy.md has measured differences.

Examples:
  cofferdam export-ssp scenes/koyna-coarse
      koyna-coarse.ssp
  cofferdam export-ssp scenes/koyna-northridge-1994 \\
    --set time.communication_step=0.00125 --output fine.ssp --force
      With half the communication step; an existing file fine.ssp is
      overwritten.

Exit status: 0 exported, 1 the archive cannot be created or written, 2 the scene
is invalid.";

const WITH_MEMORY: &str = "the difference from `cofferdam run` is of third order in the communication step; of the intact Koyna dam at 0.0025 s, \
     0.01 % of the largest crest displacement";
const WITHOUT_MEMORY: &str =
    "the added mass of the water is in the dam: the equations are those of the scheme \"added-mass\"";

/// Reason why no archive was written.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Packing(#[from] PackingError),
}

/// Packs the units of a scene and reports the result.
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
    let loaded = read_scene(&arguments.scene, &arguments.set)?;
    show_warnings(&loaded.warnings);
    let path = arguments.output.clone().unwrap_or_else(|| format!("{}.ssp", loaded.name).into());
    let target = Target { path: &path, overwrite: arguments.force, version: Version::Fmi2, library: None };
    let packed = pack_system(&loaded.name, &loaded.scene, &loaded.ground_motion, &target)?;
    let PackedSystem { size, components, memory, moved } = packed;
    print(format!("{}: {} kB, SSP 1.0 with FMUs of FMI 2.0", path.display(), size.div_ceil(1000)));
    print(format!("components: {}; the ground moves as in the scene", components.join(", ")));
    for side in moved {
        print(format!(
            "the {0} has the dam's interface points; `{0}.interface_size` is not used",
            side.table()
        ));
    }
    let step = loaded.scene.time.communication_step;
    print(format!("explicit coupling: the importer steps all units at once, always by {step} s"));
    print(if memory { WITH_MEMORY } else { WITHOUT_MEMORY });
    Ok(())
}
