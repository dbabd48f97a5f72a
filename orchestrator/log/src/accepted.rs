use super::{Entries, Entry, Log, LogReadError, LoggedExchange, LoggedStep};
use std::collections::BTreeMap;

/// A step that the run continued with, and what was exchanged in it then.
#[derive(Clone, Debug, PartialEq)]
pub struct AcceptedStep {
    /// The step; step 0 is initialisation.
    pub step: LoggedStep,
    /// The accepted exchange of each unit, by its number.
    pub exchanges: Vec<LoggedExchange>,
}

/// The accepted steps of a log in their order; an error is the last item.
///
/// A log that is cut short gives the steps that it holds whole.
pub struct AcceptedSteps {
    entries: Entries,
    units: usize,
    /// Accepted exchanges of steps whose end is still to come.
    open: BTreeMap<u64, Vec<Option<LoggedExchange>>>,
    ending: Option<String>,
}

impl AcceptedSteps {
    /// The accepted steps of `log`.
    ///
    /// **Errors**: the log can no longer be opened.
    pub fn of(log: &Log) -> Result<Self, LogReadError> {
        let (entries, units) = (log.entries()?, log.head().units.len());
        Ok(Self { entries, units, open: BTreeMap::new(), ending: None })
    }

    /// How the log ends, once its end is reached.
    pub fn ending(&self) -> Option<&str> {
        self.ending.as_deref()
    }
}

impl Iterator for AcceptedSteps {
    type Item = Result<AcceptedStep, LogReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.entries.next()? {
                Err(error) => return Some(Err(error)),
                Ok(Entry::Exchange(exchange)) if exchange.accepted => {
                    let empty = || vec![None; self.units];
                    let (step, unit) = (exchange.occasion.step, exchange.unit.0);
                    self.open.entry(step).or_insert_with(empty)[unit] = Some(exchange);
                }
                Ok(Entry::Step(step)) if step.accepted => {
                    let exchanges = self.open.remove(&step.occasion.step).unwrap_or_default();
                    if !exchanges.is_empty()
                        && let Some(exchanges) = exchanges.into_iter().collect()
                    {
                        return Some(Ok(AcceptedStep { step, exchanges }));
                    }
                }
                Ok(Entry::Damage(damage)) => return Some(Err(self.entries.missing(damage))),
                Ok(Entry::End(end)) => self.ending = Some(end.status),
                Ok(Entry::Cut(position)) => self.ending = Some(format!("cut short at byte {position}")),
                Ok(_) => {}
            }
        }
    }
}
