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

    /// Enters initialisation at `start_time`, s.
    fn enter_initialisation(&mut self, start_time: f64) -> Result<(), FmuUnitError>;

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

/// What an FMU says, for the log and for the errors of its calls.
#[derive(Clone, Debug, Default)]
pub struct Said(Arc<Mutex<Lines>>);

#[derive(Debug, Default)]
struct Lines {
    /// Level, category, text.
    new: Vec<(Level, String, String)>,
    /// The last warning or error since the last call.
    last: String,
    told: usize,
}

/// Most messages that are kept between two calls: one that says something in every inner step would fill the memory.
const MOST: usize = 1000;

impl Said {
    /// Takes a message; what is neither warning nor error is not kept.
    pub fn add(&self, level: Level, category: &str, text: &str) {
        let mut lines = self.lines();
        let text = text.trim_end();
        if level < Level::Warning || text.is_empty() {
            return;
        }
        text.clone_into(&mut lines.last);
        lines.told += 1;
        if lines.new.len() < MOST {
            lines.new.push((level, category.to_owned(), text.to_owned()));
        }
    }

    /// The last warning or error, which explains a failed call; it is forgotten.
    pub fn last(&self) -> String {
        std::mem::take(&mut self.lines().last)
    }

    /// The messages since the last time.
    pub fn take(&self) -> Vec<(Level, String, String)> {
        let mut lines = self.lines();
        let left_out = std::mem::take(&mut lines.told).saturating_sub(lines.new.len());
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
