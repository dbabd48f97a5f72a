//! Tables of an ensemble that has been run.

use super::Ensemble;
use super::plan::HIGHEST_LEVEL;
use super::runs::{CONFIDENCE, LimitResult, Runs, digits};
use crate::statistics::{
    Curve, Evidence, Exceedance, Outcome, exceedance, median_interval, propose, quantile,
};
use crate::table::Table;
use cofferdam_report::known_digits;

/// Smallest number of independent values whose median has an interval.
const LEAST_OF_MEDIANS: usize = 6;
/// Intensities at which curves are drawn.
const POINTS: usize = 101;

impl Runs<'_> {
    pub fn opening(&self) -> String {
        let plan = &self.ensemble.plan;
        let title = if plan.title.is_empty() { "Ensemble" } else { &plan.title };
        let complete = self.complete().count();
        let mut text = format!(
            "{title}: {} runs, {} records, {complete} completed\n\n",
            self.kept.len(),
            plan.records.len()
        );
        let mut failures: Vec<String> = Vec::new();
        for (sample, kept) in self.ensemble.samples.iter().zip(self.kept).filter(|(_, k)| !k.is_complete()) {
            let name = &plan.records[sample.record].name;
            failures
                .push(format!("{name}, {:+}, scale {:.4}: {}", sample.polarity, sample.scale, kept.status));
        }
        if !failures.is_empty() {
            text.push_str(&format!("NOT COMPLETED, excluded below: {}\n\n", failures.join("; ")));
        }
        text
    }

    /// A row for each run, and the names of the columns of text.
    pub fn results(&self) -> (Table, Vec<String>) {
        let runs = self.ensemble.hashes.iter().zip(self.kept).enumerate();
        let Ensemble { plan, samples, measure, .. } = self.ensemble;
        let keys: Vec<&String> = plan.variations().map(|(key, _)| key).collect();
        let of_sample = ["sample", "hash", "status", "record", "pair", "polarity", "perturbation", "scale"]
            .map(str::to_owned);
        let mut headings = of_sample.to_vec();
        headings.push(format!("{measure} [g]"));
        headings.extend(keys.iter().map(|key| (*key).clone()));
        headings.push("simulated time [s]".to_owned());
        headings.extend(self.quantities.iter().map(|(name, unit)| format!("{name} [{unit}]")));
        headings.push("warnings".to_owned());
        let mut table = Table::new(headings);
        for (index, (hash, kept)) in runs {
            let sample = &samples[index];
            let record = &plan.records[sample.record];
            let number = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
            let mut row = vec![
                index.to_string(),
                hash.clone(),
                kept.status.clone(),
                record.name.clone(),
                record.pair.clone(),
                sample.polarity.to_string(),
                sample.perturbation.map_or_else(String::new, |number| number.to_string()),
                sample.scale.to_string(),
                sample.intensity.to_string(),
            ];
            row.extend(sample.values.iter().map(|value| value.trim_matches('"').to_owned()));
            row.push(kept.simulated_time.to_string());
            row.extend(self.quantities.iter().map(|(name, _)| number(kept.value(name))));
            row.push(kept.warnings.join(" | "));
            table.row(row);
        }
        let words =
            |column: usize| samples.iter().any(|sample| sample.values[column].parse::<f64>().is_err());
        let mut text: Vec<String> =
            ["hash", "status", "record", "pair", "warnings"].map(str::to_owned).to_vec();
        text.extend(
            keys.iter().enumerate().filter(|(column, _)| words(*column)).map(|(_, key)| (*key).clone()),
        );
        (table, text)
    }

    /// Statistics of every quantity at every level, and those that are shown.
    pub fn statistics(&self) -> (Table, Table) {
        let headings =
            ["quantity", "level", "runs", "median", "low", "high", "16 %", "84 %", "mean", "deviation"];
        let mut table = Table::new(headings);
        let mut short =
            Table::new(["quantity", "level", "runs", "median (95 %)", "16 to 84 %", "mean ± deviation"]);
        for (name, unit) in &self.quantities {
            for (level, runs) in self.levels() {
                let with_value: Vec<usize> =
                    runs.into_iter().filter(|index| !self.kept[*index].value(name).is_nan()).collect();
                let mut values: Vec<f64> = with_value.iter().map(|i| self.value(*i, name)).collect();
                values.sort_by(f64::total_cmp);
                let mut clusters: Vec<usize> = with_value.iter().map(|index| self.clusters[*index]).collect();
                clusters.sort_unstable();
                clusters.dedup();
                let interval = median_interval(&values, clusters.len(), CONFIDENCE);
                let [low, high] = interval.unwrap_or([f64::NAN; 2]);
                let [p16, median, p84] = [0.16, 0.5, 0.84].map(|share| quantile(&values, share));
                let count = values.len() as f64;
                let mean = values.iter().sum::<f64>() / count;
                let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
                let deviation = square.sqrt();
                let label = format!("{name} [{unit}]");
                let numbers = [median, low, high, p16, p84, mean, deviation];
                let number = |value: f64| if value.is_finite() { value.to_string() } else { String::new() };
                let start = [label.clone(), level.clone(), values.len().to_string()];
                table.row(start.iter().cloned().chain(numbers.map(number)));
                if self.is_shown(name) {
                    let median = match interval {
                        Some(interval) => with_interval(median, interval),
                        None => digits(median),
                    };
                    short.row(start.into_iter().chain([
                        median,
                        format!("{} to {}", digits(p16), digits(p84)),
                        match deviation.is_nan() {
                            true => digits(mean),
                            false => format!("{} ± {}", digits(mean), digits(deviation)),
                        },
                    ]));
                }
            }
        }
        (table, short)
    }

    /// Why medians have no interval, if there are too few records.
    pub fn without_intervals(&self) -> Option<String> {
        let have = self.independent();
        (have < LEAST_OF_MEDIANS).then(|| {
            format!(
                "Medians have no 95 % interval: it needs at least {LEAST_OF_MEDIANS} independent records or pairs, these are {have}."
            )
        })
    }

    /// Intensities at which curves are drawn: from the weakest shaking to the strongest.
    pub fn intensities(&self) -> Vec<f64> {
        let all = || self.ensemble.samples.iter().map(|sample| sample.intensity);
        let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        (0..POINTS).map(|i| least + (most - least) * i as f64 / (POINTS - 1) as f64).collect()
    }

    pub fn limits(&self) -> Vec<LimitResult> {
        let levels = self.ensemble.plan.intensity.values();
        let of_limit = |limit: &super::plan::Limit| {
            let with_value = self.complete().filter(|i| !self.kept[*i].value(&limit.quantity).is_nan());
            let outcomes: Vec<Outcome> = with_value
                .map(|index| Outcome {
                    intensity: self.ensemble.samples[index].intensity,
                    level: self.ensemble.samples[index].level,
                    exceeded: self.kept[index].value(&limit.quantity).abs() > limit.above,
                    cluster: self.clusters[index],
                })
                .collect();
            let unit = self.quantities.iter().find(|(name, _)| *name == limit.quantity);
            let evidence = Evidence::of(&outcomes, CONFIDENCE);
            let of_level = |(level, value): (usize, &f64)| {
                let runs: Vec<&Outcome> = outcomes.iter().filter(|run| run.level == level).collect();
                Exceedance { intensity: *value, ..exceedance(&runs, CONFIDENCE) }
            };
            let levels: Vec<_> = levels.iter().enumerate().map(of_level).collect();
            LimitResult {
                left_out: self.kept.len() - outcomes.len(),
                quantity: limit.quantity.clone(),
                above: limit.above,
                unit: unit.map_or_else(String::new, |(_, unit)| unit.clone()),
                proposal: propose(&evidence, &levels, CONFIDENCE, HIGHEST_LEVEL),
                evidence,
                levels,
                exceeding: outcomes.iter().filter(|outcome| outcome.exceeded).count(),
                runs: outcomes.len(),
            }
        };
        self.ensemble.plan.limits.iter().map(of_limit).collect()
    }
}

/// A value and its interval, with the digits that the interval leaves.
pub fn with_interval(value: f64, interval: [f64; 2]) -> String {
    let [value, low, high] = known_digits(value, interval);
    format!("{value} ({low} to {high})")
}

/// The curves and their bands between the weakest and the strongest shaking; nothing where the runs do not support one.
pub fn curves(limits: &[LimitResult], intensities: &[f64], measure: &str) -> Table {
    let of_limit = |limit: &LimitResult| {
        let name = limit.name();
        [name.clone(), format!("low: {name}"), format!("high: {name}")]
    };
    let headings = std::iter::once(format!("{measure} [g]")).chain(limits.iter().flat_map(of_limit));
    let mut table = Table::new(headings);
    for intensity in intensities {
        let mut row = vec![intensity.to_string()];
        for limit in limits {
            row.extend(match &limit.evidence.curve {
                Curve::Supported(fitted) => {
                    let (probability, [low, high]) = fitted.probability(*intensity);
                    [probability, low, high].map(|value| value.to_string())
                }
                Curve::Separated { estimate, .. } => {
                    [estimate.probability(*intensity).to_string(), String::new(), String::new()]
                }
                Curve::None(_) => Default::default(),
            });
        }
        table.row(row);
    }
    table
}
