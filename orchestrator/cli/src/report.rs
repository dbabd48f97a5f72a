//! `cofferdam report`.

use crate::terminal::{print, warn};
use cofferdam_report::page::{PageError, file};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `cofferdam report`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder of a run, or of an ensemble
    run: PathBuf,

    /// The folder of another run, to be laid beside it; the first is the reference
    other: Option<PathBuf>,

    /// The page; by default report.html in the folder, of two runs report-OTHER.html there
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub const HELP: &str = "\
One HTML page that needs nothing else: what matters first, warnings, what is not modelled, the section, the dam in motion,
inputs with provenance, ground motion, histories, response spectra, pressure over height, checks, the whole table. It
prints on A4. `run` writes it too. Of a run that failed, was killed or goes on it shows what there is. A page that exists
is replaced.

It is made of manifest.toml, histories.csv and log.mcap; the dam in motion of outline.csv and the pressures on wet faces,
where they are.

Of two runs, A and B, the page says what differs in their inputs, and shows their numbers with the differences B − A, their
histories and spectra in the same charts, and their checks and warnings side by side. Steps, durations and dams may differ.

Of the folder of `cofferdam ensemble` the page shows the plan, how the runs ended, probabilities of exceeding the limits,
medians with their intervals, what the variance comes from, and all runs in a table. It is made of ensemble.toml and the
tables and pictures there.

Examples:
  cofferdam report runs/koyna
      Writes runs/koyna/report.html.
  cofferdam report runs/koyna --output koyna.html
  cofferdam report runs/koyna runs/finer
      Both side by side, with runs/koyna as the reference: writes runs/koyna/report-finer.html.
  cofferdam report ensembles/koyna
      Writes ensembles/koyna/report.html.

Exit status: 0 written, 1 the page cannot be written, 2 RUN is not the folder of a run or an ensemble, lacks a file, or is
given twice.";

/// Writes the page of a run; reports what is wrong by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    let Arguments { run, other, output } = arguments;
    let written = match other {
        None => file::write_folder(run, output.as_deref()),
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
