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
    /// File that says what is varied; docs/guide/ensembles.md explains its keys
    plan: PathBuf,

    /// Folder for samples, tables and pictures
    ///
    /// Samples that lie in it already are not run again, so that the same command goes on after an interruption, on this
    /// machine or another one.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Run only this share of the samples, such as 3/16: number 3, 19, 35, … of all; no tables
    ///
    /// For several machines with a common folder. The command without this option runs what is missing, and writes the tables.
    #[arg(long, value_name = "PART/PARTS", value_parser = clap::value_parser!(Part))]
    part: Option<Part>,

    /// Runs at the same time; by default one per core
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,

    /// Do not write report.html; `cofferdam report` makes it later
    #[arg(long)]
    no_report: bool,
}

pub const HELP: &str = "\
Runs a scene with every record, level of shaking, polarity and variation of a plan, as many at once as there are cores, each in
this process and without log. Results do not depend on the number of threads, nor on interruptions, bit for bit.

Writes into the output folder:
  samples/         a file for each run, named by the SHA-256 of what it was computed from
  results.csv, .parquet
                   a row for each run
  ensemble.md      median, 16 and 84 % of each quantity, fragility of each limit, what the variance comes from, whether
                   methods agree
  statistics.csv, fragility.csv, limits.csv, exceedance.csv, variance.csv, methods.csv
                   the same with all quantities and digits
  target.csv, spectra.svg
                   with intensity.target: factor and misfit of each record, its scaled spectrum
  polarities.csv   with both polarities: which of them governs
  ida.svg          incremental dynamic analysis: the first limit's quantity over intensity, for each record
  fragility.svg    probability of exceeding each limit, with its 95 % band
  ensemble.toml    what it was made from: records, levels, what varies, hashes, program, machine
  report.html      all of this on one page; `cofferdam report` writes it anew

Examples:
  cofferdam ensemble scenes/koyna-northridge-1994/ensemble.toml --output ensembles/koyna
  cofferdam ensemble plan.toml --output /shared/study --part 3/16
      The third of sixteen shares, as a job of an array.

Exit status: 0, 1 results could not be written, 2 the plan or its scene is wrong, 4 a unit cannot be made. Runs that fail are
listed, and left out of the statistics.";

/// Runs an ensemble and reports the result.
pub fn run(arguments: &Arguments) -> ExitCode {
    let request = Request {
        plan: &arguments.plan,
        output: &arguments.output,
        part: arguments.part,
        threads: threads(arguments.threads),
        report: !arguments.no_report,
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
