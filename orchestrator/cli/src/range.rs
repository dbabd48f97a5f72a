//! `cofferdam range`.

use crate::context::context;
use crate::terminal::{show_warnings, warn};
use cofferdam_analysis::accuracy::AccuracyError;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::range::{self, Request};
use cofferdam_analysis::study::StudyError;
use cofferdam_assembly::read_scene;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam range`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with a scene.toml, or a .toml file
    scene: PathBuf,

    /// Change a value of the scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Folder for tables and figures; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Number of runs in which all factors vary at once, by a Latin hypercube
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u16).range(8..=10000))]
    samples: u16,

    /// Change one factor at a time only; no combined interval
    #[arg(long, conflicts_with = "samples")]
    one_at_a_time: bool,

    /// Number of perturbed replicates of the scene as it is
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(2..=1000))]
    replicates: u16,

    /// Another record, scaled to the peak acceleration of the scene's (repeatable)
    ///
    /// A .csv with one column of accelerations or an .at2 file; for a scene with a vertical component two
    /// files, separated by a comma: FILE,VERTICAL. Both get the same factor.
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,

    /// Keep a dam of elements (dam.fidelity = "dem") instead of reducing its blocks to modes
    #[arg(long)]
    keep_fidelity: bool,

    /// Seed of the joint sample and of the noise on the motion
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32))]
    seed: u32,

    /// Number of simultaneous runs (default: one per core)
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
}

pub const HELP: &str = "\
Runs the scene with one factor changed at a time and with all of them at once,
in this process and without logs, and tabulates the range of the results:

  numerical error   element size x 0.7, contact points, half the time step of
                    the dam, half the communication step, every element instead
                    of reduced blocks
  perturbed motion  1 % of noise on the ground motion, as in `run --band`
  range of models   damping ratio x 0.6 to x 2, damping model, joint stiffness
                    x 0.5 to x 2, friction x 0.9 to x 1.1, polarity, wave
                    reflection coefficient +- 0.1, plane condition, uplift rule
  range of records  those of --record, at the peak acceleration of the scene's

A factor that the scene does not have is left out, and named with the reason.
For every joint: residual sliding, least factor against sliding over time and
peak opening; of the dam: peak displacement of the crest, peak base shear and
the largest tension at the heel. The combined interval holds the 5 to 95 %
quantiles of the runs in which all factors vary, each equally likely over its
range, and the factors that dominate are named.

A dam with dam.fidelity = \"dem\" is reduced, at a tenth of the cost; one run
with elements shows the error of that. Results are bit-identical for any number
of threads. Runs that fail are named and in no number.

Files in the output folder:
  range.md          all tables, with the ranges of the factors and the reasons
  range.csv         one row per run: its settings and its quantities
  range-*.svg       for each quantity a tornado chart
  range.toml        the same for programs; `cofferdam report RUN --range DIR`
                    puts the intervals on the report of a run of the scene

Examples:
  cofferdam range scenes/koyna-northridge-1994 --output ranges/koyna
  cofferdam range scenes/koyna-coarse --output ranges/coarse --samples 60 \\
    --record scenes/records/loma-prieta-1989-corralitos-038.csv
  cofferdam range scenes/koyna-coarse --output ranges/one --one-at-a-time

Exit status: 0 completed, 1 results could not be written, 2 the scene or an
option is invalid or not suitable, 3 the run of the scene as it is failed, 4 a
unit of it cannot be created.";

/// Runs the range of a scene and reports the result.
pub fn run(arguments: &Arguments) -> ExitCode {
    let Arguments { scene, set, output, record, keep_fidelity, .. } = arguments;
    let request = Request {
        scene,
        set,
        output,
        samples: if arguments.one_at_a_time { 0 } else { arguments.samples.into() },
        seed: arguments.seed.into(),
        replicates: arguments.replicates.into(),
        records: record,
        keep_fidelity: *keep_fidelity,
        threads: threads(arguments.threads),
    };
    let execute = || -> Result<(), StudyError> {
        show_warnings(&read_scene(scene, set)?.warnings);
        range::run(&request, &context()).map(|_| ())
    };
    match execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match &error {
                StudyError::File { .. } | StudyError::OutputTaken { .. } => 1,
                StudyError::Run { .. } | StudyError::Accuracy(AccuracyError::Run { .. }) => 3,
                StudyError::Unit(_) | StudyError::Accuracy(AccuracyError::Unit(_)) => 4,
                StudyError::Scene(_)
                | StudyError::Accuracy(AccuracyError::Scene(_) | AccuracyError::Unfit { .. })
                | StudyError::Record { .. }
                | StudyError::Option { .. }
                | StudyError::Unfit { .. } => 2,
            };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}
