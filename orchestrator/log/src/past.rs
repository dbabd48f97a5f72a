//! What observers of a run were told, from its log.

use super::{Entries, Entry, Log, LogReadError, LoggedExchange, LoggedStep};
use cofferdam_coupling::observer::{Checkpoint, Past};
use cofferdam_coupling::scheme::{Exchange, Interval, WindowReport};
use std::iter::Peekable;
use std::path::PathBuf;
use std::time::Duration;

/// Reads a log window by window, as the reports that observers had; wall times are rounded. A window without its last `/step`,
/// because the log ends before, is left out.
pub struct Reports {
    path: PathBuf,
    entries: Peekable<Entries>,
    done: bool,
}

impl Log {
    /// The windows and checkpoints from the first on.
    ///
    /// **Errors**: the log can no longer be opened.
    pub fn reports(&self) -> Result<Reports, LogReadError> {
        let path = self.path().to_owned();
        Ok(Reports { path, entries: self.entries()?.peekable(), done: false })
    }
}

impl Log {
    /// The last checkpoint at the end of step `until` or before, as far as the log can be read; of each unit, with the last state
    /// that it gave until then, in a branch since it left its run.
    ///
    /// **Errors**: the log can no longer be opened.
    pub fn checkpoint(&self, until: u64) -> Result<Option<LastCheckpoint>, LogReadError> {
        let before = |step: u64| {
            Ok(match self.last_before("/checkpoint", step)? {
                Some(Entry::Checkpoint(checkpoint)) => Some(checkpoint),
                _ => None,
            })
        };
        let Some(Checkpoint { step, time, run, units }) = before(until)? else { return Ok(None) };
        let state = |state: Option<Vec<u8>>| state.map(|state| (step, state));
        let mut units: Vec<_> = units.into_iter().map(state).collect();
        let mut earliest = step;
        let own = self.head().parent.as_ref().map_or(0, |parent| parent.step);
        let of_same_run = |earlier: u64| earlier >= own || step < own;
        while units.contains(&None)
            && let Some(earlier) = earliest.checked_sub(1)
            && let Some(checkpoint) = before(earlier)?
            && of_same_run(checkpoint.step)
        {
            earliest = checkpoint.step;
            for (unit, state) in units.iter_mut().zip(checkpoint.units) {
                *unit = unit.take().or(state.map(|state| (earliest, state)));
            }
        }
        Ok(Some(LastCheckpoint { step, time, run, units }))
    }
}

impl Log {
    /// Reads the log up to its end, or up to where it is cut or damaged.
    ///
    /// **Errors**: the log can no longer be opened, or the disk is failing: what follows may be there.
    pub fn extent(&self) -> Result<Extent, LogReadError> {
        let mut extent = Extent::default();
        for entry in self.entries()? {
            match entry {
                Ok(Entry::Checkpoint(checkpoint)) => extent.take(checkpoint),
                Ok(Entry::End(end)) => extent.status = Some(end.status),
                Ok(Entry::Damage(damage)) => {
                    extent.damage = Some(LogReadError::Missing { path: self.path().to_owned(), damage });
                    break;
                }
                Err(error @ (LogReadError::Open { .. } | LogReadError::Read { .. })) => return Err(error),
                Err(error) => extent.damage = Some(error),
                Ok(_) => {}
            }
        }
        Ok(extent)
    }
}

/// How far a log can be read, from its beginning.
#[derive(Debug, Default)]
pub struct Extent {
    /// The last checkpoint up to there.
    pub checkpoint: Option<LastCheckpoint>,
    /// How the run ended; `None` if the log does not come as far.
    pub status: Option<String>,
    /// What it cannot be read beyond.
    pub damage: Option<LogReadError>,
}

impl Extent {
    /// Keeps of each unit the last state that it gave.
    fn take(&mut self, checkpoint: Checkpoint) {
        let Checkpoint { step, time, run, units } = checkpoint;
        let mut before = self.checkpoint.take().map_or_else(Vec::new, |checkpoint| checkpoint.units);
        before.resize(units.len(), None);
        let units = units.into_iter().zip(before);
        let units = units.map(|(state, before)| state.map(|state| (step, state)).or(before)).collect();
        self.checkpoint = Some(LastCheckpoint { step, time, run, units });
    }
}

/// From where a run can go on.
#[derive(Clone, Debug, PartialEq)]
pub struct LastCheckpoint {
    /// Number of the last step before.
    pub step: u64,
    /// Its end, s.
    pub time: f64,
    /// The state of the run.
    pub run: Vec<u8>,
    /// Of each unit the step at whose end it gave its last state, and that state; `None` where it gave none.
    pub units: Vec<Option<(u64, Vec<u8>)>>,
}

impl Reports {
    /// The next window or checkpoint; `None` at the end.
    fn read(&mut self) -> Result<Option<Past>, LogReadError> {
        let mut report = WindowReport::default();
        let mut steps: Vec<LoggedStep> = Vec::new();
        loop {
            // The steps of a window stand together.
            let goes_on = match self.entries.peek() {
                Some(Ok(Entry::Step(step))) => {
                    steps.first().is_none_or(|first| first.occasion.attempt == step.occasion.attempt)
                }
                _ => steps.is_empty(),
            };
            if !goes_on {
                return Ok(Some(Past::Window(self.window(report, &steps))));
            }
            match self.entries.next().transpose()? {
                None | Some(Entry::End(_) | Entry::Cut(_)) => return Ok(None),
                Some(Entry::Damage(damage)) => {
                    return Err(LogReadError::Missing { path: self.path.clone(), damage });
                }
                Some(Entry::Checkpoint(checkpoint)) => return Ok(Some(Past::Checkpoint(checkpoint))),
                Some(Entry::Exchange(logged)) => report.exchanges.push(exchange(logged)),
                Some(Entry::Message(message)) => report.messages.push(message),
                Some(Entry::Iteration(iteration)) => report.iterates.push(iteration.report),
                Some(Entry::Step(step)) => steps.push(step),
            }
        }
    }

    /// The report with what its steps say.
    fn window(&self, mut report: WindowReport, steps: &[LoggedStep]) -> WindowReport {
        for step in steps {
            let occasion = step.occasion;
            report.attempt = occasion.attempt;
            report.steps.push(Interval::new(occasion.step, occasion.time, occasion.communication_step));
            if step.accepted {
                report.interfaces.push(step.interfaces.clone());
            }
            report.converged = step.converged;
            report.outcome.clone_from(&step.outcome);
            report.fallbacks = step.fallbacks;
            report.interpolation_error = step.interpolation_error;
            report.largest = step.largest;
            report.rounding_floor = step.rounding_floor;
            report.solver_time.resize(step.unit_times.len(), Duration::ZERO);
            for (sum, time) in report.solver_time.iter_mut().zip(&step.unit_times) {
                *sum += seconds(*time);
            }
        }
        report
    }
}

impl Iterator for Reports {
    type Item = Result<Past, LogReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let item = self.read().transpose();
        self.done = !matches!(item, Some(Ok(_)));
        item
    }
}

fn exchange(logged: LoggedExchange) -> Exchange {
    let LoggedExchange { unit, occasion, accepted, inputs, outputs, wall_time, .. } = logged;
    let [sent, answered] = wall_time.map(seconds);
    Exchange { unit, occasion, accepted, inputs, outputs: outputs.unwrap_or_default(), sent, answered }
}

/// Wall time in seconds; nothing where that is none.
fn seconds(time: f64) -> Duration {
    Duration::try_from_secs_f64(time).unwrap_or_default()
}
