//! Whether a plan can be carried out.

use super::{EnsembleError, HIGHEST_LEVEL, Intensity, Measure, Perturbation, Plan, Target};
use std::path::Path;

/// Maximum number of samples of an ensemble.
const MOST: usize = 1_000_000;

impl Plan {
    /// Checks every value.
    ///
    /// **Errors**: [`EnsembleError::Value`].
    pub(in super::super) fn check(&self, path: &Path) -> Result<(), EnsembleError> {
        let wrong = |key: &str, value: String, remedy: &str| {
            let (path, key, remedy) = (path.to_owned(), key.to_owned(), remedy.to_owned());
            Err(EnsembleError::Value { path, key, value, remedy })
        };
        if self.records.is_empty() {
            return wrong("records", "an empty list".into(), "give at least one record");
        }
        let names: Vec<&str> = self.records.iter().map(|record| &*record.name).collect();
        if let Some(twice) = (1..names.len()).find(|i| names[..*i].contains(&names[*i])) {
            return wrong("records", format!("{:?} twice", names[twice]), "give them different names");
        }
        if let Some(record) =
            self.records.iter().find(|record| !(record.factor > 0.0 && record.factor.is_finite()))
        {
            return wrong("records.factor", record.factor.to_string(), "it must be greater than 0");
        }
        let Intensity { measure, period, levels, scales, target } = &self.intensity;
        if let Some(Target { range: range @ [from, to], .. }) = target {
            if !(*from > 0.0 && from < to && to.is_finite()) {
                let remedy = "two positive multiples of the period, the first the smaller one";
                return wrong("intensity.target.range", format!("{range:?}"), remedy);
            }
            if !levels.is_empty() {
                let remedy = "a target scales the records; `scales` are multiples of it";
                return wrong("intensity.levels", format!("{levels:?}"), remedy);
            }
            if let Some(record) = self.records.iter().find(|record| record.factor != 1.0) {
                let remedy = "a target has factors of its own; leave one of them out";
                return wrong("records.factor", record.factor.to_string(), remedy);
            }
        }
        if !levels.is_empty() && !scales.is_empty() {
            return wrong("intensity.scales", format!("{scales:?}"), "give either `levels` or `scales`");
        }
        for (key, values) in [("intensity.levels", levels), ("intensity.scales", scales)] {
            let ascend = values.windows(2).all(|pair| pair[0] < pair[1]);
            if !ascend || values.iter().any(|x| !(*x > 0.0 && x.is_finite())) {
                return wrong(key, format!("{values:?}"), "they must be positive and ascend");
            }
        }
        if levels.iter().any(|level| *level > HIGHEST_LEVEL) {
            let remedy = "they are in g, not in % or m/s²; 20 % of g is 0.2";
            return wrong("intensity.levels", format!("{levels:?}"), remedy);
        }
        if let Some(period) = period
            && !(*period > 0.0 && period.is_finite() && (*measure == Measure::Sa || target.is_some()))
        {
            let remedy = "a positive period belongs to `measure = \"sa\"` or to a target";
            return wrong("intensity.period", period.to_string(), remedy);
        }
        if let Some(key) = self.set.iter().find(|set| set.trim_start().starts_with("ground_motion")) {
            let remedy =
                "give the keys of the motion in each of `records`, in `intensity` or in `polarities`";
            return wrong("set", format!("{key:?}"), remedy);
        }
        let polarities = &self.polarities;
        if !matches!(polarities[..], [1 | -1] | [1, -1] | [-1, 1]) {
            return wrong("polarities", format!("{polarities:?}"), "give [1], [-1] or [1, -1]");
        }
        for (table, variations) in [("parameters", &self.parameters), ("numerics", &self.numerics)] {
            for (key, variation) in variations {
                if let Some(remedy) = variation.problem() {
                    return wrong(&format!("{table}.\"{key}\""), format!("{variation:?}"), remedy);
                }
                if key.starts_with("ground_motion") {
                    let remedy = "`records`, `intensity` and `polarities` vary the ground motion";
                    return wrong(&format!("{table}.\"{key}\""), "a key of it".into(), remedy);
                }
            }
        }
        if let Some(key) = self.parameters.keys().find(|key| self.numerics.contains_key(*key)) {
            return wrong(
                &format!("numerics.\"{key}\""),
                "also in [parameters]".into(),
                "leave one of them out",
            );
        }
        if let Some(Perturbation { count, noise }) = self.perturbation
            && !(count > 0 && noise > 0.0 && noise <= 1.0)
        {
            let remedy = "`count` must be at least 1, `noise` between 0 and 1";
            return wrong("perturbation", format!("{{ count = {count}, noise = {noise} }}"), remedy);
        }
        if self.samples == 0 || (self.samples > 1 && self.distributed().next().is_none()) {
            let remedy = "give 1, or more if a key of [parameters] has a distribution; without one all samples are equal";
            return wrong("samples", self.samples.to_string(), remedy);
        }
        for limit in &self.limits {
            if !(limit.above > 0.0 && limit.above.is_finite()) {
                return wrong("limits.above", limit.above.to_string(), "it must be greater than 0");
            }
        }
        match self.count() {
            Some(count) if count <= MOST => {}
            _ => return wrong("samples", format!("more than {MOST} in all"), "vary less"),
        }
        Ok(())
    }
}
