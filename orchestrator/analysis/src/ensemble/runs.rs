//! The runs of an ensemble, for its tables and pictures.

use super::Ensemble;
use super::plan::Sample;
use super::sample::Kept;
use crate::statistics::{Evidence, Exceedance, Proposal};
use cofferdam_report::has_both_directions;
use std::collections::BTreeSet;

/// Quantities in the short table in addition to those of the limits.
pub const SHOWN: [&str; 4] = ["peak crest displacement", "residual sliding", "peak sliding", "peak opening"];

/// Confidence of all intervals.
pub const CONFIDENCE: f64 = 0.95;

/// The runs of an ensemble, by sample.
pub struct Runs<'a> {
    pub ensemble: &'a Ensemble,
    pub kept: &'a [Kept],
    /// Cluster of each sample.
    pub clusters: Vec<usize>,
    /// Names and units of all quantities, in the order in which runs have them.
    pub quantities: Vec<(String, String)>,
    /// Names of the peaks that complete runs have in both directions.
    magnitudes: BTreeSet<String>,
}

impl<'a> Runs<'a> {
    /// Those of `kept`, one for each sample.
    pub fn of(ensemble: &'a Ensemble, kept: &'a [Kept]) -> Self {
        let mut quantities: Vec<(String, String)> = Vec::new();
        for number in kept.iter().flat_map(|kept| &kept.quantities) {
            if !quantities.iter().any(|(name, _)| *name == number.name) {
                quantities.push((number.name.clone(), number.unit.to_string()));
            }
        }
        let of_record = ensemble.plan.clusters();
        // Of a single record its own motions.
        let mut motions: Vec<(i64, Option<usize>)> = Vec::new();
        let mut of_motion = |sample: &Sample| {
            let motion = (sample.polarity, sample.perturbation);
            motions.iter().position(|other| *other == motion).unwrap_or_else(|| {
                motions.push(motion);
                motions.len() - 1
            })
        };
        let samples = ensemble.samples.iter();
        let clusters = match of_record.len() {
            1 => samples.map(&mut of_motion).collect(),
            _ => samples.map(|sample| of_record[sample.record]).collect(),
        };
        let complete = || kept.iter().filter(|kept| kept.is_complete());
        let names = quantities.iter().map(|(name, _)| name.clone());
        let magnitudes =
            names.filter(|name| has_both_directions(name, complete().map(|kept| kept.value(name)))).collect();
        Self { ensemble, kept, clusters, quantities, magnitudes }
    }

    /// The value of a quantity for statistics, NaN where the run has none: of a peak that runs have in both directions its magnitude.
    pub fn value(&self, index: usize, name: &str) -> f64 {
        let value = self.kept[index].value(name);
        if self.magnitudes.contains(name) { value.abs() } else { value }
    }

    /// The samples that reached their end.
    pub fn complete(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.kept.len()).filter(|index| self.kept[*index].is_complete())
    }

    /// The quantities of the short tables: name and unit.
    pub fn shown(&self) -> impl Iterator<Item = (String, String)> + '_ {
        self.quantities.iter().filter(|(name, _)| self.is_shown(name)).cloned()
    }

    pub fn is_shown(&self, name: &str) -> bool {
        let limits = &self.ensemble.plan.limits;
        SHOWN.iter().any(|shown| name.starts_with(shown)) || limits.iter().any(|limit| limit.quantity == name)
    }

    /// Whether all runs are of one record or pair: what they say of other records is unknown.
    pub fn is_of_one_record(&self) -> bool {
        self.ensemble.plan.clusters().iter().all(|cluster| *cluster == 0)
    }

    /// Number of independent records, pairs, or motions of a single record.
    pub fn independent(&self) -> usize {
        self.clusters.iter().collect::<BTreeSet<_>>().len()
    }

    /// The runs of each level; a single group without levels, or if levels are factors.
    pub fn levels(&self) -> Vec<(String, Vec<usize>)> {
        let names = self.ensemble.plan.intensity.level_names();
        let of_level = |level| self.complete().filter(|i| self.ensemble.samples[*i].level == level).collect();
        names.into_iter().enumerate().map(|(level, name)| (name, of_level(level))).collect()
    }
}

/// A limit and the results of the runs for it.
pub struct LimitResult {
    pub quantity: String,
    pub above: f64,
    pub unit: String,
    pub evidence: Evidence,
    /// The runs of each level of the plan; its intensity is the level or the factor on the records.
    pub levels: Vec<Exceedance>,
    pub proposal: Proposal,
    pub exceeding: usize,
    pub runs: usize,
    /// Runs without this quantity.
    pub left_out: usize,
}

impl LimitResult {
    pub fn name(&self) -> String {
        format!("{} > {} {}", self.quantity, self.above, self.unit)
    }
}

/// Three significant digits.
pub fn digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let places = 2 - value.abs().log10().floor() as i32;
    match places {
        0..=6 => format!("{value:.*}", places as usize),
        -3..0 => format!("{value:.0}"),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits() {
        let found = [0.0, 1234.5, 12.345, 0.012345, 1e-9, f64::INFINITY].map(digits);
        assert_eq!(found, ["0", "1234", "12.3", "0.0123", "1.00e-9", "inf"]);
    }
}
