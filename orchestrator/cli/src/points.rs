//! `cofferdam points`.

use crate::options::BuiltIn;
use crate::terminal::{print, warn};
use clap::ValueEnum;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::units::unit_name;
use cofferdam_assembly::{AssemblyError, read_scene};
use cofferdam_scene::SceneError;
use miette::Diagnostic;
use serde::Serialize;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam points`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    pub scene: PathBuf,

    /// Unit whose points are printed
    #[arg(short, long, default_value = "reservoir")]
    pub unit: BuiltIn,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Output format
    #[arg(short, long, value_enum, default_value_t = Format::Csv)]
    pub format: Format,
}

/// Output format of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// One row per point
    Csv,
    /// One object: depth, density, gravity, `communication_step`, and the points as arrays
    Json,
}

pub const HELP: &str = "\
Intended for computing the water or the dam with a program of your own.
Coordinates and tributary lengths are in m, ordered from the heel upwards; x
points downstream and y up; the normal points out of the water into the dam.
All digits are printed, so that the values read back are bit-identical. Where a
crack meets the face, two points coincide; the first belongs to the block below
the crack.

The reservoir has its own points if the scene sets `reservoir.interface_size`;
otherwise both units use those of the dam. A line on standard error states
which.

Examples:
  cofferdam points scenes/koyna-northridge-1994
      index,x,y,normal_x,normal_y,tributary_length
  cofferdam points scenes/rigid-dam-ramp --set prescribed.panels=32 -f json

Exit status: 0 printed, 1 the points cannot be printed, 2 the scene is invalid.";

/// Reason why nothing was printed.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum Failure {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    #[error("the points cannot be written: {0}")]
    Written(Box<dyn Error + Send + Sync>),
}

/// JSON output; SI units.
#[derive(Serialize)]
struct Printed<'a> {
    depth: f64,
    density: f64,
    gravity: f64,
    communication_step: f64,
    points: Points<'a>,
}

#[derive(Serialize)]
struct Points<'a> {
    x: &'a [f64],
    y: &'a [f64],
    normal_x: &'a [f64],
    normal_y: &'a [f64],
    tributary_length: &'a [f64],
}

/// Prints the points.
pub fn run(arguments: &Arguments) -> ExitCode {
    match execute(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if matches!(error, Failure::Written(_)) { 1 } else { 2 };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let scene = read_scene(&arguments.scene, &arguments.set)?.scene;
    let face = arguments.unit.face(&scene)?;
    let column = |axis: usize, of: &[[f64; 2]]| -> Vec<f64> { of.iter().map(|pair| pair[axis]).collect() };
    let (points, normals) = (face.points(), face.normals());
    let [x, y] = [0, 1].map(|axis| column(axis, points));
    let [normal_x, normal_y] = [0, 1].map(|axis| column(axis, &normals));
    let tributary_length = face.tributary_lengths();
    let columns = [&x, &y, &normal_x, &normal_y, &tributary_length];
    let text = match arguments.format {
        Format::Csv => {
            let mut table = Table::new(["index", "x", "y", "normal_x", "normal_y", "tributary_length"]);
            for index in 0..face.len() {
                let values = columns.iter().map(|column| column[index].to_string());
                table.row(std::iter::once(index.to_string()).chain(values));
            }
            table.csv().map_err(Failure::Written)?
        }
        Format::Json => {
            let points = Points {
                x: &x,
                y: &y,
                normal_x: &normal_x,
                normal_y: &normal_y,
                tributary_length: &tributary_length,
            };
            let printed = Printed {
                depth: face.depth(),
                density: arguments.unit.water(&scene).density,
                gravity: scene.gravity,
                communication_step: scene.time.communication_step,
                points,
            };
            serde_json::to_string(&printed).map_err(|cause| Failure::Written(cause.into()))?
        }
    };
    print(text.trim_end());
    let name = unit_name(arguments.unit.into());
    warn(match (arguments.unit, arguments.unit.water(&scene).interface_size) {
        (BuiltIn::Dam, _) => format!("{} points of the dam", face.len()),
        (_, Some(size)) => format!(
            "{} points of the {name}'s own ({name}.interface_size = {size}); --unit dam has the dam's",
            face.len()
        ),
        (_, None) => format!("{} points of the dam, which the {name} shares", face.len()),
    });
    Ok(())
}
