//! `cofferdam reservoir`: response of the water of a scene to a rigid dam.

use cofferdam_assembly::{Assembly, AssemblyError, read_scene};
mod field;
mod figure;
mod grid;
mod impulse;
mod points;
mod record;
mod response;

use crate::terminal::{print, show_warnings, warn};
use clap::ValueEnum;
use cofferdam_analysis::closed_form;
use cofferdam_analysis::context::threads;
use cofferdam_motion::GroundMotion;
use cofferdam_reservoir::{ReservoirError, ReservoirParameters};
use cofferdam_scene::{ELEMENTS_OF_THE_RESERVOIR, SceneError, Side, down};
use miette::Diagnostic;
use std::error::Error;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The commands.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Compute pressure and force over frequency, per unit acceleration of a rigid dam
    #[command(after_long_help = response::HELP)]
    Response(response::Arguments),
    /// Compute pressure and force after an impulse or a ramp of a rigid dam's acceleration
    #[command(after_long_help = impulse::HELP)]
    Impulse(impulse::Arguments),
    /// Compute pressure and force on a rigid dam under the scene's ground motion
    #[command(after_long_help = record::HELP)]
    Record(record::Arguments),
    /// Compute the pressure field in the water at one frequency, as VTU for ParaView
    #[command(after_long_help = field::HELP)]
    Field(field::Arguments),
}

/// Arguments of all commands.
#[derive(clap::Args)]
struct Common {
    /// Folder with a scene.toml, or a .toml file
    scene: PathBuf,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Folder for tables and figures; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Number of threads (default: one per core)
    ///
    /// Results are bit-identical for any number of threads.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
}

/// Motion of the rigid dam and the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Motion {
    /// Downstream, together with the ground
    Horizontal,
    /// Upwards, together with the bed
    Vertical,
}

/// Reason why nothing was written.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    #[error(transparent)]
    Solver(#[from] ReservoirError),
    /// The request cannot be fulfilled; the text names the remedy.
    #[error("{what}")]
    Unfit { what: String },
    #[error("{} is not empty; choose another --output, nothing is overwritten", path.display())]
    OutputTaken { path: PathBuf },
    #[error("{}: {cause}; choose another --output", path.display())]
    File { path: PathBuf, cause: Box<dyn Error + Send + Sync> },
}

fn unfit(what: impl Into<String>) -> Failure {
    Failure::Unfit { what: what.into() }
}

/// Runs the command and reports the result.
pub fn run(command: &Command) -> ExitCode {
    let done = match command {
        Command::Response(arguments) => response::run(arguments),
        Command::Impulse(arguments) => impulse::run(arguments),
        Command::Record(arguments) => record::run(arguments),
        Command::Field(arguments) => field::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match error {
                Failure::Scene(_) | Failure::Unfit { .. } | Failure::Unit(AssemblyError::Empty) => 2,
                Failure::Unit(_) | Failure::Solver(_) => 4,
                Failure::File { .. } | Failure::OutputTaken { .. } => 1,
            };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

/// The water of a scene.
struct Water {
    title: String,
    parameters: ReservoirParameters,
    ground_motion: GroundMotion,
    /// Communication steps of the simulated time.
    steps: u64,
}

impl Common {
    /// Checks that the results can be written, then reads the scene.
    fn load(&self) -> Result<Water, Failure> {
        let path = || self.output.clone();
        match std::fs::read_dir(&self.output).map(|mut entries| entries.next().is_some()) {
            Ok(true) => return Err(Failure::OutputTaken { path: path() }),
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                return Err(Failure::File { path: path(), cause: cause.into() });
            }
            _ => {}
        }
        let loaded = read_scene(&self.scene, &self.set)?;
        show_warnings(&loaded.warnings);
        let parameters = Assembly::of(&loaded.scene).water_parameters(Side::Upstream)?;
        parameters.validate()?;
        let (steps, ground_motion) = (loaded.scene.steps(), loaded.ground_motion);
        Ok(Water { title: loaded.scene.title, parameters, ground_motion, steps })
    }

    fn threads(&self) -> NonZeroUsize {
        threads(self.threads)
    }

    /// Writes the files into the output folder, each completely or not at all, and prints their names.
    fn write(&self, files: &[(&str, String)]) -> Result<(), Failure> {
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |cause: std::io::Error| Failure::File { path, cause: cause.into() }
        };
        std::fs::create_dir_all(&self.output).map_err(failed(&self.output))?;
        for (name, content) in files {
            let (path, draft) = (self.output.join(name), self.output.join(format!("{name}.part")));
            std::fs::write(&draft, content).and_then(|()| std::fs::rename(&draft, &path)).map_err(
                |cause| {
                    // The error of writing is reported, not one of removing.
                    let _ = std::fs::remove_file(&draft);
                    failed(&path)(cause)
                },
            )?;
            print(format!("wrote {}", path.display()));
        }
        Ok(())
    }
}

/// The error of a picture or a table that could not be made.
fn undrawn(name: &'static str) -> impl Fn(Box<dyn Error + Send + Sync>) -> Failure {
    move |cause| Failure::File { path: name.into(), cause }
}

impl Water {
    /// Warns if the elements do not resolve waves of the highest frequency, `omega` (rad/s), requested.
    fn warn_of_coarse_elements(&self, omega: f64) {
        let ReservoirParameters { element_size, bed_element_size, sound_speed, fidelity, .. } =
            self.parameters;
        let size = bed_element_size.map_or(element_size, |bed| bed.max(element_size));
        let (wavelength, resolved) =
            (TAU * sound_speed / omega, TAU * sound_speed / (ELEMENTS_OF_THE_RESERVOIR * size));
        if fidelity.has_memory() && omega > resolved * (1.0 + 1e-9) {
            warn(format!(
                "warning: elements of {size} m resolve the water up to {resolved:.0} rad/s, with {ELEMENTS_OF_THE_RESERVOIR} a sound \
                 wave; at {omega} rad/s they are {:.1} a wave of {wavelength:.1} m: take lower frequencies, or \
                 `--set reservoir.element_size` of {} m or less",
                wavelength / size,
                down(wavelength / ELEMENTS_OF_THE_RESERVOIR)
            ));
        }
    }

    /// First cut-off frequency of the channel at the heel's depth over a rigid bed, ω₁ = πc/2h, rad/s.
    fn first_cut_off(&self) -> f64 {
        let depth = self.parameters.wet_face.depth();
        std::f64::consts::PI * self.parameters.sound_speed / (2.0 * depth)
    }
}

impl From<Motion> for closed_form::Motion {
    fn from(motion: Motion) -> Self {
        match motion {
            Motion::Horizontal => Self::Horizontal,
            Motion::Vertical => Self::Vertical,
        }
    }
}
