//! Every exchange of a unit as a row of a table.

use crate::log::Failure;
use cofferdam_coupling::participant::Layout;
use cofferdam_log::{Entry, Log, LogReadError, LoggedExchange, LoggedUnit};
use csv::Writer;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A table, and the number of values of a response.
struct Table {
    path: PathBuf,
    writer: Writer<File>,
    outputs: usize,
}

impl Table {
    fn create(folder: &Path, unit: &LoggedUnit) -> Result<Self, Failure> {
        let path = folder.join(format!("{}-exchanges.csv", unit.name));
        let failed = |cause: csv::Error| Failure::write(&path, cause);
        let mut writer = Writer::from_path(&path).map_err(failed)?;
        let occasion = ["step", "iteration", "attempt", "accepted", "start_time [s]", "end_time [s]"];
        let header = occasion.map(str::to_owned).into_iter();
        let header = header.chain(names("request", &unit.inputs)).chain(names("answer", &unit.outputs));
        writer.write_record(header).map_err(failed)?;
        Ok(Self { path, writer, outputs: unit.outputs.size() })
    }

    fn write(&mut self, exchange: &LoggedExchange) -> Result<(), Failure> {
        let at = exchange.occasion;
        let numbers = (at.step, at.iteration, at.attempt, u8::from(exchange.accepted), at.time, at.end());
        let none = vec![f64::NAN; if exchange.outputs.is_none() { self.outputs } else { 0 }];
        let row = (numbers, &exchange.inputs, exchange.outputs.as_ref().unwrap_or(&none));
        self.writer.serialize(row).map_err(|cause| Failure::write(&self.path, cause))
    }
}

/// Names of columns: with an index where a variable is an array.
fn names(half: &str, layout: &Layout) -> Vec<String> {
    let of_channel = layout.channels().flat_map(|(channel, range)| {
        (0..range.len()).map(move |index| {
            let index = if channel.shape.is_array() { format!(".{index}") } else { String::new() };
            format!("{half}.{}{index} [{}]", channel.name, channel.unit)
        })
    });
    of_channel.collect()
}

/// Writes a table for each unit; returns why the log could not be read to its end.
pub fn write(log: &Log, folder: &Path) -> Result<Option<LogReadError>, Failure> {
    let tables = log.head().units.iter().map(|unit| Table::create(folder, unit));
    let mut tables = tables.collect::<Result<Vec<_>, _>>()?;
    let mut damage = None;
    for entry in log.entries()? {
        match entry {
            Ok(Entry::Exchange(exchange)) => tables[exchange.unit.0].write(&exchange)?,
            Ok(Entry::Damage(missing)) => {
                damage = Some(LogReadError::Missing { path: log.path().to_owned(), damage: missing });
            }
            Ok(_) => {}
            Err(error) => damage = Some(error),
        }
    }
    for table in &mut tables {
        table.writer.flush().map_err(|cause| Failure::write(&table.path, cause))?;
    }
    Ok(damage)
}
