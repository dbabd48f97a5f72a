//! What this program asks of an instance of an FMU, whatever its version of FMI.

use super::error::FmuUnitError;
use super::model::Kind;
use cofferdam_coupling::participant::Level;
use std::sync::{Arc, Mutex, PoisonError};

/// An instance for co-simulation.
///
/// **Call order**: parameters, [`enter_initialisation`](Self::enter_initialisation), inputs,
/// [`exit_initialisation`](Self::exit_initialisation), then steps. It keeps one saved state.
pub trait Instance {
    /// Sets a parameter of `kind`.
    fn set_parameter(&mut self, reference: u32, kind: Kind, value: &Value) -> Result<(), FmuUnitError>;

    /// Enters initialisation.
    fn enter_initialisation(&mut self, experiment: Experiment) -> Result<(), FmuUnitError>;

    /// Ends initialisation.
    fn exit_initialisation(&mut self) -> Result<(), FmuUnitError>;

    /// Sets real inputs, or fixed parameters during initialisation; an array has one reference and several values.
    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmuUnitError>;

    /// Reads variables of one kind that [is a number](Kind::is_number), a flag as 0 or 1.
    fn get(&mut self, kind: Kind, references: &[u32], values: &mut [f64]) -> Result<(), FmuUnitError>;

    /// Takes a step from `time` of `length`, both s.
    fn step(&mut self, time: f64, length: f64) -> Result<(), FmuUnitError>;

    /// Saves the state in place of the one before.
    fn save(&mut self) -> Result<(), FmuUnitError>;

    /// Returns to the saved state.
    fn restore(&mut self) -> Result<(), FmuUnitError>;

    /// The present state as bytes.
    fn serialise(&mut self) -> Result<Vec<u8>, FmuUnitError>;

    /// Takes a state as bytes, in an instance that has been initialised.
    fn deserialise(&mut self, state: &[u8]) -> Result<(), FmuUnitError>;
}

/// The value of a parameter, one or several numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Numbers(Vec<f64>),
    Whole(i64),
    Flag(bool),
    Text(String),
}

/// What an instance is told of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Start time, s.
    pub start: f64,
    /// Time beyond which there is no step, s, if it is known.
    pub stop: Option<f64>,
}

impl Experiment {
    /// The error of a call by which an instance was told of this.
    pub fn refused(self, error: FmuUnitError) -> FmuUnitError {
        match (error, self.stop) {
            (FmuUnitError::Call { call, status, message }, Some(stop)) => {
                FmuUnitError::Setup { call, status, message, start: self.start, stop }
            }
            (other, _) => other,
        }
    }
}

/// What an FMU says, for the log and for the errors of its calls.
#[derive(Clone, Debug, Default)]
pub struct Said(Arc<Mutex<Lines>>);

#[derive(Debug, Default)]
struct Lines {
    /// Level, category, text.
    new: Vec<(Level, String, String)>,
    /// The last warning or error since the last call.
    last: String,
    /// Warnings and errors since they were taken.
    told: usize,
    /// Messages that are neither, of the whole run.
    information: usize,
}

/// Most warnings and errors that are kept between two calls: one that says something in every inner step would fill the memory.
const MOST: usize = 1000;
/// Most other messages of a run that are kept.
const MOST_INFORMATION: usize = 1000;
/// Longest message, bytes.
const LONGEST: usize = 1 << 14;

impl Said {
    /// Takes a message. Of those that are neither warning nor error, the first [`MOST_INFORMATION`] are kept.
    pub fn add(&self, level: Level, category: &str, text: &str) {
        let mut lines = self.lines();
        let text = shortened(text.trim_end());
        if text.is_empty() {
            return;
        }
        if level < Level::Warning {
            lines.information += 1;
            match lines.information {
                ..=MOST_INFORMATION => lines.new.push((level, category.to_owned(), text)),
                number if number == MOST_INFORMATION + 1 => {
                    let more = format!("more messages of status OK are left out, after {MOST_INFORMATION}");
                    lines.new.push((level, String::new(), more));
                }
                _ => (),
            }
            return;
        }
        text.clone_into(&mut lines.last);
        lines.told += 1;
        if lines.told <= MOST {
            lines.new.push((level, category.to_owned(), text));
        }
    }

    /// The last warning or error, which explains a failed call; it is forgotten.
    pub fn last(&self) -> String {
        std::mem::take(&mut self.lines().last)
    }

    /// The messages since the last time.
    pub fn take(&self) -> Vec<(Level, String, String)> {
        let mut lines = self.lines();
        let left_out = std::mem::take(&mut lines.told).saturating_sub(MOST);
        let mut new = std::mem::take(&mut lines.new);
        if left_out > 0 {
            new.push((Level::Warning, String::new(), format!("{left_out} more messages were left out")));
        }
        new
    }

    fn lines(&self) -> std::sync::MutexGuard<'_, Lines> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn shortened(text: &str) -> String {
    if text.len() <= LONGEST {
        return text.to_owned();
    }
    let end = (0..=LONGEST).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
    format!("{} …", &text[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_kept_up_to_their_limits() {
        let said = Said::default();
        for i in 0..MOST_INFORMATION + 500 {
            said.add(Level::Information, "logStatusOk", &format!("step {i}"));
        }
        said.add(Level::Warning, "", "take care \n");
        let taken = said.take();
        assert_eq!(taken.len(), MOST_INFORMATION + 2);
        assert_eq!(taken[0], (Level::Information, "logStatusOk".to_owned(), "step 0".to_owned()));
        assert!(taken[MOST_INFORMATION].2.contains("left out, after 1000"), "{:?}", taken[MOST_INFORMATION]);
        assert_eq!(taken[MOST_INFORMATION + 1].2, "take care");
        assert_eq!(said.last(), "take care");
        // The limit is that of the run; warnings have their own, of each call.
        said.add(Level::Information, "", "one more");
        (0..MOST + 7).for_each(|_| said.add(Level::Error, "", "wrong"));
        let taken = said.take();
        assert_eq!(taken.len(), MOST + 1);
        assert_eq!(taken[MOST].2, "7 more messages were left out");
        said.add(Level::Warning, "", &"ü".repeat(LONGEST));
        assert!(said.last().len() < LONGEST + 8);
    }
}
