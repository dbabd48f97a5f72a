//! `cofferdam fmu-input`.

use crate::terminal::{print, warn};
use cofferdam_analysis::table::Table;
use cofferdam_assembly::read_scene;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam fmu-input`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    pub scene: PathBuf,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Print both components, named as in FMI 2.0 FMUs of a dam or a reservoir
    #[arg(long)]
    pub plane: bool,
}

pub const HELP: &str = "\
Prints the ground motion of the scene as a CSV table for FMPy: time (s) and
ground acceleration (m/s²), one row per communication step; of a scene with
vertical ground motion also the vertical acceleration.

FMPy sets the inputs of time t before the step from t to t + H, and the FMU
takes them for the end of that step. So the row of time t has the acceleration
at t + H. Of the two rows at time 0, FMPy uses the first for initialisation and
the second for the first step; the row before time 0 makes it do so.

Examples:
  cofferdam fmu-input scenes/koyna-coarse > input.csv
      For `fmpy simulate --input-file input.csv koyna-coarse-coupled.fmu`.
  cofferdam fmu-input scenes/koyna-coarse --plane > input.csv
      Columns ground_acceleration.x and .y.

Exit status: 0 printed, 1 the table cannot be printed, 2 the scene is invalid.";

/// Prints the table.
pub fn run(arguments: &Arguments) -> ExitCode {
    let loaded = match read_scene(&arguments.scene, &arguments.set) {
        Ok(loaded) => loaded,
        Err(error) => {
            warn(format!("{:?}", miette::Report::new(error)));
            return ExitCode::from(2);
        }
    };
    let step = loaded.scene.time.communication_step;
    let names: &[&str] = match loaded.ground_motion.vertical() {
        _ if arguments.plane => &["ground_acceleration.x", "ground_acceleration.y"],
        Some(_) => &["ground_acceleration", "ground_acceleration_vertical"],
        None => &["ground_acceleration"],
    };
    let mut table = Table::new(std::iter::once("time").chain(names.iter().copied()));
    let mut row = |time: f64, value: [f64; 2]| {
        table.row(std::iter::once(time).chain(value.into_iter().take(names.len())).map(|x| x.to_string()));
    };
    let at = |number: u64| loaded.ground_motion.at(number as f64 * step);
    row(-step, at(0));
    row(0.0, at(0));
    (0..=loaded.scene.steps()).for_each(|number| row(number as f64 * step, at(number + 1)));
    match table.csv() {
        Ok(text) => {
            print(text.trim_end());
            ExitCode::SUCCESS
        }
        Err(error) => {
            warn(format!("the table cannot be written: {error}"));
            ExitCode::FAILURE
        }
    }
}
