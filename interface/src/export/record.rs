use crate::sampled;
use serde::{Deserialize, Serialize};

/// A component of an input that the FMU drives by a record in its contents. No importer sees an input with a record, so that
/// every importer gives the unit the same motion, whatever it does with inputs; components without a record are zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Name of the input.
    pub input: String,
    /// Component of the input, counted from 0.
    pub component: usize,
    /// Time between two samples, s.
    pub interval: f64,
    /// The samples, in the unit of the input; linear in between.
    pub samples: Vec<f64>,
    /// Whether the last sample holds from there on; otherwise the input falls to zero within one interval.
    pub held: bool,
}

impl Record {
    /// The values at `time` (s) of the input `name` of `size` values; none if no record drives it.
    pub(super) fn values(records: &[Self], name: &str, size: usize, time: f64) -> Option<Vec<f64>> {
        let mut own = records.iter().filter(|record| record.input == name).peekable();
        own.peek()?;
        let mut values = vec![0.0; size];
        for Self { component, interval, samples, held, .. } in own {
            if let Some(value) = values.get_mut(*component) {
                *value = sampled(samples, *interval, *held, time);
            }
        }
        Some(values)
    }
}
