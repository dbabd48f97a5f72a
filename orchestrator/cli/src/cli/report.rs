//! `cofferdam report`, and the report at the end of a run or an ensemble.

use super::{complain, say, section};
use cofferdam_assembly::observer::Histories;
use cofferdam_log::LogReadError;
use cofferdam_report::Manifest;
use cofferdam_report::page::ensemble::{self, EnsembleData, EnsembleFolder};
use cofferdam_report::page::{ReportData, ReportError, RunFolder, html, pair};
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
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

/// Name of the page in the folder of a run.
const NAME: &str = "report.html";

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error(transparent)]
    Run(#[from] ReportError),
    #[error(transparent)]
    Log(#[from] LogReadError),
    #[error("{} is given twice; give the folders of two runs", path.display())]
    Twice { path: PathBuf },
    #[error("{}: {cause}; {}", path.display(), remedy(cause))]
    Write { path: PathBuf, cause: Error },
}

fn remedy(cause: &Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "make the folder first, or choose another --output",
        ErrorKind::FileTooLarge => "raise the limit of file sizes (`ulimit -f`)",
        _ => "free some space or choose another --output",
    }
}

/// Writes the page of a run; reports what is wrong by the exit status.
pub fn run(arguments: &Arguments) -> ExitCode {
    let written = match &arguments.other {
        None => of_one(arguments),
        Some(other) => of_two(arguments, other),
    };
    match written {
        Ok(path) => {
            say(format!("wrote {}", path.display()));
            ExitCode::SUCCESS
        }
        Err(failure) => {
            let status = if matches!(failure, Failure::Write { .. }) { 1 } else { 2 };
            complain(format!("{:?}", miette::Report::msg(failure)));
            ExitCode::from(status)
        }
    }
}

fn of_one(arguments: &Arguments) -> Result<PathBuf, Failure> {
    let path = arguments.output.clone().unwrap_or_else(|| arguments.run.join(NAME));
    if EnsembleFolder::is(&arguments.run) {
        save(&ensemble::html(&EnsembleData::of(&EnsembleFolder::read(&arguments.run)?)), &path)?;
    } else {
        write(RunFolder::read(&arguments.run)?, &path)?;
    }
    Ok(path)
}

fn of_two(arguments: &Arguments, other: &Path) -> Result<PathBuf, Failure> {
    let runs = [RunFolder::read(&arguments.run)?, RunFolder::read(other)?];
    let whole = [&*arguments.run, other].map(|path| path.canonicalize().unwrap_or_else(|_| path.to_owned()));
    if whole[0] == whole[1] {
        return Err(Failure::Twice { path: other.to_owned() });
    }
    let names = whole.map(|path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned());
    let path =
        arguments.output.clone().unwrap_or_else(|| arguments.run.join(format!("report-{}.html", names[1])));
    let [a, b] = &runs;
    save(&pair::html(&pair::PairData::of([a, b], names)?), &path)?;
    Ok(path)
}

/// Writes the page of an ensemble into its `folder`.
///
/// **Errors**: [`Failure`].
pub fn of_ensemble(folder: &Path) -> Result<(), Failure> {
    save(&ensemble::html(&EnsembleData::of(&EnsembleFolder::read(folder)?)), &folder.join(NAME))
}

/// Writes the page of a run that has just ended in `folder`.
///
/// **Errors**: [`Failure`]; there is nothing to show of a run without a step, which is none.
pub fn of_run(folder: &Path, manifest: &Manifest, histories: &Histories) -> Result<(), Failure> {
    match RunFolder::of(manifest.clone(), histories.clone(), &folder.join("log.mcap")) {
        Err(ReportError::NoStep { .. }) => Ok(()),
        run => write(run?, &folder.join(NAME)),
    }
}

fn write(run: RunFolder, path: &Path) -> Result<(), Failure> {
    // A mesh that can no longer be made leaves the picture out, not the page.
    let picture = section::figure(&run.loaded.scene).ok();
    save(&html(&ReportData::of(&run, picture)?), path)
}

/// Writes a page whole or not at all.
fn save(text: &str, path: &Path) -> Result<(), Failure> {
    let mut draft = path.as_os_str().to_owned();
    draft.push(".part");
    std::fs::write(&draft, text).and_then(|()| std::fs::rename(&draft, path)).map_err(|cause| {
        // The error of writing is reported, not one of removing.
        let _ = std::fs::remove_file(&draft);
        Failure::Write { path: path.to_owned(), cause }
    })
}
