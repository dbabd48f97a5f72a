//! `cofferdam report`.

use crate::terminal::{print, warn};
use cofferdam_report::page::{PageError, file};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam report`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of a run or an ensemble
    run: PathBuf,

    /// Folder of a second run to compare with the first, which is the reference
    other: Option<PathBuf>,

    /// File to write (default: report.html in the folder RUN; for two runs, report-OTHER.html there)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Folder of `cofferdam range` with the same scene: its intervals stand at the key figures
    #[arg(long, value_name = "DIR", conflicts_with = "other")]
    range: Option<PathBuf>,
}

pub const HELP: &str = "\
Writes a self-contained HTML page that prints on A4: key figures, warnings,
what is not modelled, the section, an animation of the dam, inputs with their
sources, ground motion, histories, response spectra, pressure over height,
checks, and the table of all results. `run` writes the same page. For a run
that failed, was killed or is still running, the page shows the data available.
An existing page is replaced.

The page is made from manifest.toml, histories.csv and log.mcap; the animation
from outline.csv and the pressures on the wet faces, if these files exist.

For two runs, A and B, the page lists the differences of their inputs, the
results of both with the differences B − A, their histories and spectra in
common charts, and their checks and warnings next to each other. Steps,
durations and dams may differ.

For a folder of `cofferdam ensemble`, the page shows the plan, how the runs
ended, the probabilities of exceeding the limits, medians with their intervals,
the contributions to the variance, and a table of all runs. It is made from
ensemble.toml and the tables and figures in the folder.

Examples:
  cofferdam report runs/koyna
      Writes runs/koyna/report.html.
  cofferdam report runs/koyna --output koyna.html
  cofferdam report runs/koyna runs/finer
      Compares both, with runs/koyna as the reference; writes
      runs/koyna/report-finer.html.
  cofferdam report ensembles/koyna
      Writes ensembles/koyna/report.html.
  cofferdam report runs/koyna --range ranges/koyna
      With the range of each key figure, and what dominates it.

Exit status: 0 written, 1 the page cannot be written, 2 RUN is not the folder
of a run or an ensemble, lacks a file, or is given twice, or the range is that
of another scene.";

/// Writes the page of a run; reports what is wrong by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    let Arguments { run, other, output, range } = arguments;
    let written = match other {
        None => file::write_folder(run, output.as_deref(), range.as_deref()),
        Some(other) => file::write_pair(run, other, output.as_deref()),
    };
    match written {
        Ok(path) => {
            print(format!("wrote {}", path.display()));
            ExitCode::SUCCESS
        }
        Err(failure) => {
            let status = if matches!(failure, PageError::Write { .. }) { 1 } else { 2 };
            warn(format!("{:?}", miette::Report::msg(failure)));
            ExitCode::from(status)
        }
    }
}
