//! Signals from outside the graph that are known before a run, such as a ground acceleration.

pub use cofferdam_unit::sampled;
use serde::{Deserialize, Serialize};

/// A sampled signal that every unit with an input of the name [`input`](Self::input) receives as one component of it.
///
/// The value at time t is linear between equally spaced samples. After the last sample it is zero, reached within one
/// interval, or stays at the last sample if the signal is [`held`](Self::held). Other components of the input are those of other
/// signals, or zero.
///
/// ```
/// use cofferdam_coupling::signal::Signal;
///
/// let signal = Signal::new("wind", "force", 0.5, vec![0.0, 2.0]);
/// let mut value = [0.0; 2];
/// signal.evaluate(0.25, &mut value);
/// assert_eq!(value, [1.0, 0.0]);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Signal {
    /// Name of the signal; its topic in a log.
    pub name: String,
    /// The input of the units that receive it.
    pub input: String,
    /// What it measures, one word; the field of its samples in a log.
    pub quantity: String,
    /// SI unit of the samples.
    pub unit: String,
    /// Where it comes from.
    pub source: String,
    /// Time between two samples, s.
    pub interval: f64,
    /// The samples; at least one.
    pub samples: Vec<f64>,
    /// Whether the last sample holds from there on.
    pub held: bool,
    /// The component of the input, counted from 0. Text formats leave out that it is the first.
    #[serde(default, skip_serializing_if = "is_first")]
    pub component: usize,
    /// Times, s, at which further parts of the signal begin, such as further records. They do not change its value.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<f64>,
}

fn is_first(component: &usize) -> bool {
    *component == 0
}

impl Signal {
    /// The signal `name` for inputs called `input`: `samples`, `interval` (s) apart, zero afterwards.
    pub fn new(name: &str, input: &str, interval: f64, samples: Vec<f64>) -> Self {
        let owned = str::to_owned;
        let (quantity, unit, source) = (owned("value"), owned("1"), String::new());
        Self {
            name: owned(name),
            input: owned(input),
            quantity,
            unit,
            source,
            interval,
            samples,
            held: false,
            component: 0,
            parts: Vec::new(),
        }
    }

    /// Time from which on the signal is zero, s; `None` if it never ends.
    pub fn zero_from(&self) -> Option<f64> {
        let endless = self.held && self.samples.last().is_some_and(|a| *a != 0.0);
        let last = self.interval * self.samples.len().saturating_sub(1) as f64;
        let fall = if self.held { 0.0 } else { self.interval };
        (!endless).then_some(last + fall)
    }

    /// Writes the value at `time` (s) to its component of `value`, if there is one.
    pub fn evaluate(&self, time: f64, value: &mut [f64]) {
        if let Some(component) = value.get_mut(self.component) {
            *component = sampled(&self.samples, self.interval, self.held, time);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_is_linear_between_samples_and_zero_or_held_afterwards() {
        let mut signal = Signal::new("s", "x", 0.5, vec![1.0, 3.0, -2.0]);
        let at = |signal: &Signal, time| {
            let mut value = [0.0; 3];
            signal.evaluate(time, &mut value);
            value
        };
        for (time, value) in [(0.0, 1.0), (0.25, 2.0), (1.0, -2.0), (1.25, -1.0), (1.5, 0.0), (9.0, 0.0)] {
            assert_eq!(at(&signal, time), [value, 0.0, 0.0], "at {time}");
        }
        assert_eq!(signal.zero_from(), Some(1.5));
        let (mut value, second) = ([7.0; 2], Signal { component: 1, ..signal.clone() });
        second.evaluate(0.25, &mut value);
        assert_eq!(value, [7.0, 2.0]);
        second.evaluate(0.25, &mut value[..1]);
        assert_eq!(value, [7.0, 2.0]);
        signal.held = true;
        assert_eq!(signal.zero_from(), None);
        assert_eq!([at(&signal, 1.25)[0], at(&signal, 9.0)[0]], [-2.0, -2.0]);
    }
}
