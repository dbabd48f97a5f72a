//! `cofferdam log export`.

mod exchanges;
mod histories;

use super::Failure;
use crate::terminal::print;
use clap::ValueEnum;
use cofferdam_analysis::parquet;
use cofferdam_log::Log;
use std::path::{Path, PathBuf};

/// Arguments of `cofferdam log export`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    log: PathBuf,
    /// Folder to make and fill
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Form of the tables
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Every exchange of every iteration, one row each
    #[arg(long)]
    iterations: bool,
}

/// Form of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Text, commas between the values
    Csv,
    /// Parquet, compressed with Snappy
    Parquet,
}

pub const HELP: &str = "\
Writes from the log alone what the run wrote beside it: histories.csv, and a table of each array over the wet face.

With --iterations, tables of all exchanges of each unit instead: UNIT-exchanges.csv has a row for each request with its
answer, with step, iteration, attempt, accepted, start and end of the step, and every value of the request and of the answer
(NaN where a unit failed and gave none).

Logs of earlier versions hold no residuals by iteration, work at the interface and lowest pressure; these columns
are then 0, which a warning says.

Numbers have all digits, so that reading them gives the same bits. A log that is cut short gives what it holds; of a damaged
one, what comes before the damage is written, and the damage reported.

Examples:
  cofferdam log export runs/koyna --output koyna-tables
  cofferdam log export runs/koyna --output koyna-iterations --iterations --format parquet

Exit status: 0, also for a log that was cut short; 1 if it cannot be read or is damaged, the folder exists, or cannot be
written.";

/// Writes the tables of a log.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    let folder = &arguments.output;
    if folder.exists() {
        return Err(Failure::Exists { path: folder.clone() });
    }
    std::fs::create_dir_all(folder).map_err(|cause| Failure::write(folder, cause))?;
    let damage =
        if arguments.iterations { exchanges::write(&log, folder)? } else { histories::write(&log, folder)? };
    let tables = tables(folder)?;
    for table in &tables {
        let table = match arguments.format {
            Format::Csv => table.clone(),
            Format::Parquet => as_parquet(table)?,
        };
        print(table.display());
    }
    damage.map_or(Ok(()), |error| Err(error.into()))
}

/// Writes the table `path` as Parquet beside it, and removes it.
fn as_parquet(path: &Path) -> Result<PathBuf, Failure> {
    let target = path.with_extension("parquet");
    parquet::write(path, &target, &[]).map_err(|cause| Failure::Write { path: target.clone(), cause })?;
    std::fs::remove_file(path).map_err(|cause| Failure::write(path, cause))?;
    Ok(target)
}

/// The tables in the folder.
fn tables(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |cause| Failure::write(folder, cause);
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>();
    let mut paths = paths.map_err(failed)?;
    paths.sort();
    Ok(paths)
}
