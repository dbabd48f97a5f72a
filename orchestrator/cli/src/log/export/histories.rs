//! Restores from a log the tables that a run writes next to it.

use crate::log::Failure;
use crate::terminal::warn;
use cofferdam_assembly::observer::HistoriesWriter;
use cofferdam_coupling::observer::{Observer, ObserverError, Past};
use cofferdam_log::{Log, LogReadError, shaped_outputs};
use std::path::Path;

/// Writes the tables by the observer that writes them during a run; returns why the log could not be read to its end.
pub fn write(log: &Log, folder: &Path) -> Result<Option<LogReadError>, Failure> {
    let failed = |cause: ObserverError| Failure::write(folder, cause);
    let units = &log.head().units;
    let outputs: Vec<_> = units.iter().map(|unit| shaped_outputs(&unit.outputs)).collect();
    let units = units.iter().zip(&outputs);
    let units: Vec<_> = units.map(|(unit, outputs)| (&*unit.name, [&unit.inputs, outputs])).collect();
    let mut writer = HistoriesWriter::new(folder);
    writer.open(&units, &log.head().signals).map_err(failed)?;
    let (mut damage, mut old) = (None, false);
    for past in log.reports()? {
        match past {
            Ok(Past::Window(report)) => {
                old |= report.step() > 0 && report.is_accepted() && report.outcome.is_empty();
                writer.window(&report).map_err(failed)?;
            }
            Ok(Past::Checkpoint(_)) => {}
            Err(error) => damage = Some(error),
        }
    }
    writer.finish().map_err(failed)?;
    if old {
        warn(format_args!(
            "warning: {}: cofferdam {} (commit {}) wrote it, whose logs hold no residuals by iteration, work at the \
             interface and lowest pressure: these columns are 0",
            log.path().display(),
            log.head().version,
            log.head().commit
        ));
    }
    Ok(damage)
}
