//! Contents of a report of two runs, independent of their layout.

use super::super::data::{Abscissa, Chart, Check, Row, Series};
use crate::has_both_directions;
use cofferdam_log::KeyDifference;
use serde::Serialize;

/// Contents of a report of two runs. The first of each pair belongs to A, the reference, the second to B.
#[derive(Clone, Debug, PartialEq)]
pub struct PairData {
    /// The runs.
    pub runs: [Head; 2],
    /// Difference of the dams, if there is one.
    pub dams: Option<String>,
    /// The key figures.
    pub key_figures: Vec<Compared>,
    /// Difference of the crest histories; `None` without a dam or a common instant.
    pub crest: Option<CrestAgreement>,
    /// Keys of the scenes that differ.
    pub scene: Vec<KeyDifference>,
    /// Other differences: units, ground motion, program, machine.
    pub origin: Vec<KeyDifference>,
    /// Descriptions of equal inputs.
    pub equal: Vec<String>,
    /// Warnings.
    pub warnings: Shared,
    /// Notes.
    pub notes: Shared,
    /// Limitations of the model.
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
    /// Self-checks of the runs.
    pub checks: Vec<[Option<Check>; 2]>,
    /// The whole tables of both summaries.
    pub quantities: Vec<Compared>,
}

/// Summary of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Title of the scene.
    pub title: String,
    /// Name of its folder.
    pub folder: String,
    /// Status at the end.
    pub status: String,
    /// Whether the run reached its planned end.
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
    /// Its values; `None` for a run without the quantity.
    pub values: [Option<f64>; 2],
    /// When it occurred, s.
    pub times: [Option<f64>; 2],
    /// Comparison of one run with the band of the other.
    pub band: Option<Within>,
}

/// Whether the value of one run is within the band of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within {
    /// Owner of the band: 0 for A, 1 for B.
    pub of: usize,
    /// 16 %, median and 84 % of its replicates.
    pub band: [f64; 3],
    /// Whether the value of the other run is between 16 and 84 %.
    pub kept: bool,
}

impl Compared {
    /// B minus A; for peaks in opposite directions, of the magnitudes.
    pub fn difference(&self) -> Option<f64> {
        let [a, b] = [self.values[0]?, self.values[1]?];
        Some(if has_both_directions(&self.name, [a, b].into_iter()) { b.abs() - a.abs() } else { b - a })
    }

    /// B minus A over the magnitude of A; `None` if A is 0.
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
    /// The difference over the scale, as in `log diff --tolerance`.
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
    /// Separates the sentences of both runs from those of one run.
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
    /// Explanation.
    pub about: String,
    /// The charts; one without a title of its own if it is alone.
    pub charts: Vec<PairChart>,
}

/// A line of A and a line of B, each over its own abscissa. A run without the quantity has no line.
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
    /// The abscissa.
    pub abscissa: Abscissa,
    /// One line or none.
    pub series: Vec<Series>,
}

/// The hydrodynamic pressure of both runs on a wet face.
#[derive(Clone, Debug, PartialEq)]
pub struct PairProfile {
    /// Name of the instant in A.
    pub instant: String,
    /// Name of the water: `reservoir` or `tailwater`.
    pub water: String,
    /// The instants, s; `None` if B has no pressure at that instant.
    pub times: [Option<f64>; 2],
    /// Heights above the base of the face, m, and pressures, Pa.
    pub lines: [Vec<[f64; 2]>; 2],
}
