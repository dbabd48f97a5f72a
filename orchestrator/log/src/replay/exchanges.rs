//! The exchanges of one unit in a log.

use super::ReplayError;
use crate::{Entries, Entry, Log, LogReadError, LoggedExchange, LoggedUnit};
use cofferdam_coupling::scheme::UnitId;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Reads the exchanges of a unit, from after a step on, in the order of the run. A thread of its own reads ahead.
pub struct Exchanges<'a> {
    pub unit: &'a LoggedUnit,
    /// In a branch, the last step whose answers are those of the units of the run that it left.
    pub of_others: Option<u64>,
    read: Receiver<Batch>,
    batch: std::vec::IntoIter<LoggedExchange>,
    /// What comes after the batch, if it is the last.
    end: Option<End>,
    next: Option<LoggedExchange>,
    /// The last step that was taken.
    pub last: Option<u64>,
    /// How the log ends, once all is taken: the run's status, or the byte at which it is cut short.
    pub ending: Option<Result<String, u64>>,
}

/// How a log ends, or why it cannot be read on.
type End = Result<Result<String, u64>, LogReadError>;

/// Exchanges, and what comes after the last of all.
#[derive(Default)]
struct Batch {
    exchanges: Vec<LoggedExchange>,
    end: Option<End>,
}

/// Exchanges that are handed over at once: one by one would cost more than reading them.
const BATCH: usize = 64;
/// Batches that are read ahead.
const AHEAD: usize = 8;

impl<'a> Exchanges<'a> {
    /// The exchanges of unit `id` after step `after`, or all.
    ///
    /// **Errors**: the log cannot be read, or has no such unit; no thread can be made.
    pub fn of(log: &'a Log, id: UnitId, after: Option<u64>) -> Result<Self, ReplayError> {
        let units = &log.head().units;
        let unit = units.get(id.0).ok_or(ReplayError::NoUnit { id, units: units.len() })?;
        let entries = match after {
            Some(step) => log.entries_from(step + 1),
            None => log.entries(),
        };
        let entries = entries.map_err(|cause| ReplayError::Log { identical: 0, cause })?;
        let ((write, read), path) = (sync_channel(AHEAD), log.path().to_owned());
        let wanted = move |exchange: &LoggedExchange| {
            exchange.unit == id && after.is_none_or(|after| exchange.occasion.step > after)
        };
        let thread = std::thread::Builder::new().spawn(move || read_ahead(path, entries, wanted, &write));
        thread.map_err(|cause| ReplayError::Thread { cause })?;
        let batch = Vec::new().into_iter();
        let of_others = log.head().parent.as_ref().map(|parent| parent.step);
        Ok(Self { unit, of_others, read, batch, end: None, next: None, last: None, ending: None })
    }

    /// The next exchange of a step up to `until`; `None` if a later one follows, or none.
    ///
    /// **Errors**: the log cannot be read on.
    pub fn next(&mut self, until: u64) -> Result<Option<LoggedExchange>, LogReadError> {
        if self.next.is_none() {
            self.next = self.take()?;
        }
        let next = self.next.take_if(|exchange| exchange.occasion.step <= until);
        self.last = next.as_ref().map(|exchange| exchange.occasion.step).or(self.last);
        Ok(next)
    }

    fn take(&mut self) -> Result<Option<LoggedExchange>, LogReadError> {
        loop {
            if let Some(exchange) = self.batch.next() {
                return Ok(Some(exchange));
            }
            if let Some(end) = self.end.take() {
                self.ending = Some(end?);
            }
            // The thread ends after it has sent the end.
            let Ok(Batch { exchanges, end }) = self.read.recv() else { return Ok(None) };
            (self.batch, self.end) = (exchanges.into_iter(), end);
        }
    }
}

/// Sends what is `wanted` until the log ends or nobody takes it any more.
fn read_ahead(
    path: PathBuf,
    entries: Entries,
    wanted: impl Fn(&LoggedExchange) -> bool,
    write: &SyncSender<Batch>,
) {
    let mut batch = Batch::default();
    for entry in entries {
        match entry {
            Ok(Entry::Exchange(exchange)) if wanted(&exchange) => batch.exchanges.push(exchange),
            Ok(Entry::Damage(damage)) => {
                batch.end = Some(Err(LogReadError::Missing { path: path.clone(), damage }));
            }
            Ok(Entry::End(end)) => batch.end = Some(Ok(Ok(end.status))),
            Ok(Entry::Cut(position)) => batch.end = Some(Ok(Err(position))),
            Err(error) => batch.end = Some(Err(error)),
            Ok(_) => (),
        }
        if (batch.exchanges.len() == BATCH || batch.end.is_some())
            && write.send(std::mem::take(&mut batch)).is_err()
        {
            return;
        }
    }
}
