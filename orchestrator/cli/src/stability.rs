//! `cofferdam stability`.

use crate::terminal::{print, warn};
use cofferdam_assembly::{AssemblyError, UpliftRule, read_scene};
use cofferdam_report::page::{ReportError, RunFolder};
use cofferdam_report::stability::{csv, of_run, of_scene, text};
use cofferdam_scene::SceneError;
use miette::Diagnostic;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `cofferdam stability`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, a .toml file, or the folder of a run
    #[arg(value_name = "SCENE|RUN")]
    pub subject: PathBuf,

    /// Change a value of the scene (repeatable; not for a run)
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Put all uplift rules side by side in the seismic combination
    #[arg(long)]
    pub rules: bool,

    /// Write the table to this CSV file, in SI units
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
}

pub const HELP: &str = "\
For every joint and combination of loads: normal force, uplift, shear force,
place of the resultant, open length, stresses at both ends, factors against
overturning and against sliding with peak and residual strength, and the factor
that an authority requires. Joints are the straight cracks of the scene that
carry a body by themselves. The combinations are usual; unusual, with drains
out of service, if there are drains; seismic, with the inertia of dam and water
(Westergaard) under two thirds of the record's peak; and after the earthquake.
Joints that a gallery interrupts are not covered.
[stability] in the scene changes them, the authority and the required factors.

Of a run: also the least factor over time, how long the joint slid as a whole,
and the stability after the earthquake with the residual strength and full
water pressure in what has opened: the largest length that was open at one time
counts as a crack from the upstream end. Of a run with a sequence of shocks,
both after each of them, with what has opened until then. Without a run, the
joint counts as cracked through then.

Factors that could not be compared with the authority's document are named as
to be confirmed.

Examples:
  cofferdam stability scenes/koyna-base-joint --set 'dam.uplift=\"unchanged\"'
  cofferdam stability scenes/koyna-base-joint --rules
      Four rules for the uplift during the earthquake, side by side.
  cofferdam stability runs/koyna --csv koyna-stability.csv
      The joints after a run, also as a table for spreadsheets.

Exit status: 0 written, 1 the file cannot be written, 2 the scene or the run is
invalid, or has no joint.";

#[derive(Debug, thiserror::Error, Diagnostic)]
enum StabilityError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Dam(#[from] AssemblyError),
    #[error(transparent)]
    Run(#[from] ReportError),
    #[error("--set: a run has its values; leave the option out, or give the scene")]
    SetOfRun,
    #[error(
        "{}: the dam has no straight crack that carries a body by itself; add one, such as [[dam.cracks]] with `elevation` = 0",
        path.display()
    )]
    NoJoint { path: PathBuf },
}

/// Prints the table; reports what is wrong by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    match table(arguments) {
        Ok((table, rows)) => {
            print(table.trim_start_matches('\n').trim_end());
            match &arguments.csv {
                Some(path) => write(path, &rows),
                None => ExitCode::SUCCESS,
            }
        }
        Err(error) => {
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(2)
        }
    }
}

fn table(arguments: &Arguments) -> Result<(String, String), StabilityError> {
    let Arguments { subject, set, rules, .. } = arguments;
    let rules: Vec<Option<UpliftRule>> = match rules {
        true => std::iter::once(None).chain(UpliftRule::ALL.map(Some)).collect(),
        false => Vec::new(),
    };
    let is_run = subject.join("manifest.toml").exists();
    if is_run && !set.is_empty() {
        return Err(StabilityError::SetOfRun);
    }
    let (scene, joints, shaken) = if is_run {
        let run = RunFolder::read(subject)?;
        let (joints, shaken) = of_run(&run.loaded, &run.histories, &rules)?;
        (run.loaded.scene, joints, shaken)
    } else {
        let loaded = read_scene(subject, set)?;
        let joints = of_scene(&loaded, &rules)?;
        (loaded.scene, joints, Vec::new())
    };
    if joints.is_empty() {
        return Err(StabilityError::NoJoint { path: subject.clone() });
    }
    Ok((text(&scene, &joints, &shaken), csv(&scene, &joints)))
}

fn write(path: &Path, rows: &str) -> ExitCode {
    match std::fs::write(path, rows) {
        Ok(()) => {
            print(format!("wrote {}", path.display()));
            ExitCode::SUCCESS
        }
        Err(cause) => {
            warn(format!("{}: {cause}; choose a folder that exists and can be written", path.display()));
            ExitCode::FAILURE
        }
    }
}
