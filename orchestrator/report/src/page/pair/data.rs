//! What a report of two runs shows, without a word of how it is shown.

use super::super::data::{Abscissa, Chart, Check, Row, Series};
use crate::has_both_directions;
use cofferdam_log::KeyDifference;
use serde::Serialize;

/// Everything that a report of two runs shows. Of each pair the first is of A, the reference, the second of B.
#[derive(Clone, Debug, PartialEq)]
pub struct PairData {
    /// The runs.
    pub runs: [Head; 2],
    /// What tells the dams apart, if they are different ones.
    pub dams: Option<String>,
    /// The numbers that matter first.
    pub key_figures: Vec<Compared>,
    /// How far the crests' histories are apart; none without a dam or without a common instant.
    pub crest: Option<CrestAgreement>,
    /// Keys of the scenes that differ.
    pub scene: Vec<KeyDifference>,
    /// What else differs: units, ground motion, program, machine.
    pub origin: Vec<KeyDifference>,
    /// What is equal, in words.
    pub equal: Vec<String>,
    /// What may make the results wrong or doubtful.
    pub warnings: Shared,
    /// What else must be known to read them.
    pub notes: Shared,
    /// What is not modelled.
    pub not_modelled: Shared,
    /// Times of all rows of the histories, s.
    pub times: [Vec<f64>; 2],
    /// Strength of the ground motions.
    pub ground: [Vec<Row>; 2],
    /// The ground motions; empty if they are equal.
    pub ground_charts: Vec<PairGroup>,
    /// Histories of the results.
    pub histories: Vec<PairGroup>,
    /// Response spectra of crest and ground.
    pub spectra: Vec<PairGroup>,
    /// Pressure over height at the instants of A.
    pub profiles: Vec<PairProfile>,
    /// What the runs say about themselves.
    pub checks: Vec<[Option<Check>; 2]>,
    /// The whole tables of both summaries.
    pub quantities: Vec<Compared>,
}

/// A run in a few words.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Title of the scene.
    pub title: String,
    /// Name of its folder.
    pub folder: String,
    /// How it ended.
    pub status: String,
    /// Whether it came to its planned end.
    pub complete: bool,
    /// When it began, in UTC.
    pub started: String,
    /// Simulated time that was reached, s.
    pub simulated_time: f64,
}

/// A number of two runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// What it is.
    pub name: String,
    /// Unit of both.
    pub unit: String,
    /// Its values; none of a run that does not have it.
    pub values: [Option<f64>; 2],
    /// When it occurred, s.
    pub times: [Option<f64>; 2],
    /// How one run lies in the band of the other.
    pub band: Option<Within>,
}

/// Whether the value of one run lies within the band of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within {
    /// Whose band it is: 0 of A, 1 of B.
    pub of: usize,
    /// 16 %, median and 84 % of its twins.
    pub band: [f64; 3],
    /// Whether the other run's value lies between 16 and 84 %.
    pub kept: bool,
}

impl Compared {
    /// B less A; of a peak that the two have in opposite directions, of its magnitudes.
    pub fn difference(&self) -> Option<f64> {
        let [a, b] = [self.values[0]?, self.values[1]?];
        Some(if has_both_directions(&self.name, [a, b].into_iter()) { b.abs() - a.abs() } else { b - a })
    }

    /// B less A over the magnitude of A; none where A is 0.
    pub fn relative(&self) -> Option<f64> {
        let a = self.values[0]?.abs();
        (a > 0.0).then_some(self.difference()? / a)
    }
}

/// The largest difference of the crests at instants that both runs have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrestAgreement {
    /// Largest difference of a component of the displacement, m.
    pub difference: f64,
    /// The largest magnitude of a component in either run at these instants, m.
    pub scale: f64,
    /// When the difference is largest, s.
    pub time: f64,
    /// Number of instants.
    pub instants: usize,
}

impl CrestAgreement {
    /// The difference over the scale: `log diff --tolerance` has the same.
    pub fn relative(&self) -> f64 {
        if self.difference == 0.0 { 0.0 } else { self.difference / self.scale }
    }
}

/// Sentences of both runs, or of one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shared {
    /// Of both.
    pub both: Vec<String>,
    /// Of one only.
    pub only: [Vec<String>; 2],
}

impl Shared {
    /// Sorted out of the sentences of both.
    pub fn of([a, b]: [Vec<String>; 2]) -> Self {
        let without = |own: &[String], other: &[String]| -> Vec<String> {
            own.iter().filter(|sentence| !other.contains(sentence)).cloned().collect()
        };
        let both = a.iter().filter(|sentence| b.contains(sentence)).cloned().collect();
        Self { both, only: [without(&a, &b), without(&b, &a)] }
    }
}

/// Charts that belong together: one for each line of a chart of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct PairGroup {
    /// What they show, with its unit.
    pub title: String,
    /// What must be known to read them.
    pub about: String,
    /// The charts; one without a title of its own if it is alone.
    pub charts: Vec<PairChart>,
}

/// A line of A and one of B, each over its own abscissa. A run that lacks it has no line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairChart {
    /// The line of A.
    #[serde(flatten)]
    pub first: Chart,
    /// The line of B.
    pub beside: Beside,
}

/// The second run's line of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Beside {
    /// What lies across.
    pub abscissa: Abscissa,
    /// One line or none.
    pub series: Vec<Series>,
}

/// The hydrodynamic pressure of both runs on a wet face.
#[derive(Clone, Debug, PartialEq)]
pub struct PairProfile {
    /// What the instant is in A.
    pub instant: String,
    /// Whose pressure it is: `reservoir` or `tailwater`.
    pub water: String,
    /// The instants, s; none of B where it has no pressure then.
    pub times: [Option<f64>; 2],
    /// Heights above the base of the face, m, and pressures, Pa.
    pub lines: [Vec<[f64; 2]>; 2],
}
