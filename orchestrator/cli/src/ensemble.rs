//! `cofferdam ensemble`.

use crate::context::context;
use crate::terminal::warn;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::ensemble::{self, EnsembleError, Part, Request};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam ensemble`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Ensemble plan (.toml); docs/guide/ensembles.md documents its keys
    plan: PathBuf,

    /// Folder for samples, tables and figures
    ///
    /// Samples that exist in the folder are not run again. The same command therefore continues after an
    /// interruption, on the same or another machine.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Run only this share of the samples, such as 3/16 (samples 3, 19, 35, …), and write no tables
    ///
    /// For several machines with a shared folder. Afterwards, the command without this option runs any
    /// missing samples and writes the tables.
    #[arg(long, value_name = "PART/PARTS", value_parser = clap::value_parser!(Part))]
    part: Option<Part>,

    /// Add the levels of shaking that the fragility curves lack, and run them
    ///
    /// Where the runs do not support a curve, the page says which levels are missing. This option adds them
    /// to the plan's levels, for all limits, in the output folder (added.toml); later commands keep them.
    #[arg(long, conflicts_with = "part")]
    add_levels: bool,

    /// Number of simultaneous runs (default: one per core)
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,

    /// Do not write report.html; `cofferdam report` can write it later
    #[arg(long)]
    no_report: bool,
}

pub const HELP: &str = "\
Runs a scene with every record, intensity level, polarity and variation of a
plan, in this process and without logs, with one simultaneous run per core.
Results are bit-identical for any number of threads and after any interruption.

Files in the output folder:
  samples/         one file per run, named by the SHA-256 of its inputs
  results.csv, .parquet
                   one row per run
  ensemble.md      median, 16 and 84 % quantiles of each quantity, fragility of
                   each limit, contributions to the variance, agreement of
                   methods
  statistics.csv, fragility.csv, limits.csv, exceedance.csv, variance.csv,
  methods.csv
                   the same with all quantities and digits
  target.csv, spectra.svg
                   with intensity.target: scale factor, misfit and scaled
                   spectrum of each record
  polarities.csv   with both polarities: the governing polarity
  joints.csv       with several joints: the one that governs the sliding
  added.toml       levels that --add-levels added
  ida.svg          incremental dynamic analysis: the quantity of the first
                   limit over intensity, for each record
  fragility.svg    share of runs that exceed each limit, with exact 95 %
                   intervals; curve and band where the runs support them
  ensemble.toml    records, levels, variations, hashes, program and machine
  report.html      all of this on one page; `cofferdam report` writes it again

Examples:
  cofferdam ensemble scenes/koyna-northridge-1994/ensemble.toml \\
    --output ensembles/koyna
  cofferdam ensemble plan.toml --output /shared/study --part 3/16
      The third of sixteen shares, as one job of a job array.
  cofferdam ensemble plan.toml --output study --add-levels
      The levels that fragility curves lack, and everything with them.

Exit status: 0 completed, 1 results could not be written, 2 the plan or its
scene is invalid, 4 a unit cannot be created. Failed runs are listed and
excluded from the statistics.";

/// Runs an ensemble and reports the result.
pub fn run(arguments: &Arguments) -> ExitCode {
    let request = Request {
        plan: &arguments.plan,
        output: &arguments.output,
        part: arguments.part,
        threads: threads(arguments.threads),
        report: !arguments.no_report,
        add_levels: arguments.add_levels,
    };
    match ensemble::run(&request, &context()) {
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match error {
                EnsembleError::Plan { .. }
                | EnsembleError::Value { .. }
                | EnsembleError::Record(_)
                | EnsembleError::Target(_)
                | EnsembleError::Unreadable { .. }
                | EnsembleError::Added { .. }
                | EnsembleError::Scene(_) => 2,
                EnsembleError::Unit(_) => 4,
                EnsembleError::Run { .. }
                | EnsembleError::OutputTaken { .. }
                | EnsembleError::File { .. }
                | EnsembleError::Report(_)
                | EnsembleError::Format(_) => 1,
            };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}
