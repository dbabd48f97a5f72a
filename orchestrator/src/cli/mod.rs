//! The command line.

pub mod run;

use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Seismic analysis of cracked concrete gravity dams with their reservoirs.
///
/// The reservoir (compressible water, boundary elements) and the dam (deformable blocks,
/// distinct elements) are two co-simulation units. Each communication step is repeated until
/// the pressure and the motion of the wet face agree, and every exchange is logged.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Subcommand)]
pub enum Command {
    /// Run a scene: crest motion, sliding, rotation, pressure; histories and a log of every exchange
    #[command(after_long_help = RUN_HELP)]
    Run(Run),
}

/// Arguments of `cofferdam run`.
#[derive(clap::Args)]
pub struct Run {
    /// Folder that holds scene.toml, or a .toml file
    ///
    /// scenes/README.md explains every key of a scene, with units and defaults. Mistakes in a
    /// scene are reported with their lines before anything is computed: first those of spelling, one
    /// at a time, then those of values, all at once.
    pub scene: PathBuf,

    /// Change a value of the scene; may be given several times
    ///
    /// Such as dam.element_size=2.5 or dam.cracks.0.elevation=60. The results' manifest shows the scene as it was run.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for the results; by default runs/SCENE-TIME
    ///
    /// It is made if need be. A folder that is not empty is refused: nothing is overwritten.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    /// Threads for preparing the reservoir's operator; by default one a core
    ///
    /// Results are the same, bit for bit, with any number.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// No progress line
    #[arg(short, long)]
    pub quiet: bool,
}

const RUN_HELP: &str = "\
Results, in the output folder:
  log.mcap        every request and answer of every iteration (MCAP, protobuf);
                  open it with Foxglove, PlotJuggler, Rerun or Python's mcap package
  histories.csv   time histories of all scalar results
  dam-*.csv, reservoir-*.csv
                  motion and pressure of the wet face, a column a point
  manifest.toml   the scene with all defaults, versions, machine, and the summary

Examples:
  cofferdam run scenes/koyna-northridge-1994
      The cracked Koyna dam under the Northridge earthquake of 1994.
  cofferdam run scenes/rigid-dam-ramp --output /tmp/ramp
      A rigid dam under a ramp of acceleration, which has a closed-form answer.
  cofferdam run scenes/koyna-northridge-1994 --set dam.element_size=2.5
      The same dam on a finer mesh.

Ctrl-C ends a run after the current step; log and histories stay readable, and the summary
says that it is partial. Press it twice to leave at once.

Exit status: 0 completed, 1 results could not be written, 2 the scene is wrong,
3 a step did not converge, 4 a unit failed, 130 interrupted.";
