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
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Folder to create for the tables
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Format of the tables
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Export all exchanges of all iterations, one per row
    #[arg(long)]
    iterations: bool,
}

/// Form of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Comma-separated text
    Csv,
    /// Parquet, compressed with Snappy
    Parquet,
}

pub const HELP: &str = "\
Recreates the tables of a run from its log alone: histories.csv, and one table
for each array on the wet face.

With --iterations, writes tables of all exchanges of each unit instead. Each
row of UNIT-exchanges.csv has a request and its response: step, iteration,
attempt, accepted, start and end of the step, and all values of the request and
of the response (NaN if the unit failed and returned none).

Logs of earlier versions do not contain residuals by iteration, work at the
interface and lowest pressure. These columns are then 0, and a warning is
printed.

Numbers are written with all digits, so that the values read back are
bit-identical. A log that is cut short is exported up to the cut; a damaged one
up to the damage, which is reported.

Examples:
  cofferdam log export runs/koyna --output koyna-tables
  cofferdam log export runs/koyna --output koyna-iterations \\
    --iterations --format parquet

Exit status: 0, also for a log that is cut short; 1 if it cannot be read or is
damaged, or the folder exists or cannot be written.";

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

/// Writes the table `path` as Parquet next to it, and removes the table.
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
