use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A row of the plan of a run: what is modelled or left out, and by which criterion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanRow {
    /// What it is about.
    pub what: String,
    /// What is done about it.
    pub verdict: String,
    /// The criterion, with its numbers.
    pub criterion: String,
}

/// The requested accuracy of a run, and the outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// `kept`, `not kept` or `cannot be kept`.
    pub verdict: String,
    /// Largest requested error, by quantity, as a share.
    pub asked: BTreeMap<String, f64>,
    /// Error that is expected against the reference, by quantity, as a share.
    pub expected: BTreeMap<String, f64>,
    /// Largest change of the result with 1 % more or less shaking, by quantity, as a share.
    pub sensitivity: BTreeMap<String, f64>,
    /// What the elements of the reference itself leave, where that can be extrapolated.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_by_reference: BTreeMap<String, f64>,
    /// Keys of the numerics that were chosen.
    pub chosen: Vec<String>,
    /// Runs of the pilot.
    pub pilot_runs: usize,
    /// Wall time of the pilot, s.
    pub pilot_time: f64,
    /// 16 %, median and 84 % of replicates within 1 % of shaking, mm, for accuracies that cannot be kept.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub band: BTreeMap<String, [f64; 3]>,
    /// Version of the table of errors.
    pub table_version: u32,
}
