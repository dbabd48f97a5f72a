//! Tables and pictures of an ensemble that has been run.

use super::runs::{CONFIDENCE, DRAWS, LimitCurve, Runs, SHOWN, digits};
use super::sample::Kept;
use super::{Ensemble, EnsembleError, control, figure, limits, manifest, methods, target};
use crate::cli::table::Table;
use crate::cli::{parquet, say};
use cofferdam_analysis::statistics::{Outcome, band, fit, main_effect, median_interval, quantile};
use std::path::Path;

/// Intensities at which curves are drawn, and their range beyond the runs'.
const POINTS: usize = 101;
const BEYOND: f64 = 1.25;
/// Groups into which the values of a distribution are sorted to find its effect.
const GROUPS: usize = 5;
/// Writes everything of an ensemble whose plan has this text.
pub fn write(
    ensemble: &Ensemble,
    kept: &[Kept],
    dear: &[Kept],
    plan: &str,
    folder: &Path,
) -> Result<(), EnsembleError> {
    let runs = Runs::of(ensemble, kept, dear);
    let save = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|cause| EnsembleError::File { path, cause: cause.into() })
    };
    let save_table = |name: &str, table: &Table| save(name, &table.csv().map_err(EnsembleError::Format)?);
    let (results, text_columns) = runs.results();
    save_table("results.csv", &results)?;
    let target = folder.join("results.parquet");
    let text_columns: Vec<&str> = text_columns.iter().map(String::as_str).collect();
    parquet::write(&folder.join("results.csv"), &target, &text_columns)
        .map_err(|cause| EnsembleError::File { path: target, cause })?;
    let (statistics, short) = runs.statistics();
    save_table("statistics.csv", &statistics)?;
    let intensities = runs.intensities();
    let levels = &ensemble.plan.intensity.levels;
    let limits = runs.limits(&[&intensities[..], levels].concat());
    save_table("fragility.csv", &curves(&limits, &intensities, &ensemble.measure))?;
    save_table("limits.csv", &limits::fits(&limits))?;
    save_table("exceedance.csv", &limits::exceedance(&runs, &limits, levels, intensities.len()))?;
    let manifest = toml::to_string(&manifest::of(&runs, plan)?);
    save("ensemble.toml", &manifest.map_err(|cause| EnsembleError::Format(cause.into()))?)?;
    let (variance, shares) = runs.variance();
    save_table("variance.csv", &variance)?;
    let mut text = runs.opening();
    if let Some(scaled) = &ensemble.scaled {
        let (table, short) = scaled.tables(&ensemble.plan.records);
        text.push_str(&scaled.about());
        text.push_str(&short.markdown());
        text.push('\n');
        save_table("target.csv", &table)?;
        save("spectra.svg", &figure::spectra(scaled)?)?;
    }
    text.push_str(&short.markdown());
    if let Some((table, short)) = target::governing(&runs) {
        text.push_str(
            "\nWhich polarity governs: the larger magnitude, the median where it has several runs.\n\n",
        );
        text.push_str(&short.markdown());
        save_table("polarities.csv", &table)?;
    }
    if !limits.is_empty() {
        text.push_str(&format!(
            "\nProbability of exceeding a limit over {}: lognormal, maximum likelihood; 95 % intervals by a bootstrap of whole \
             records or pairs.\n\n{}",
            ensemble.measure,
            limits::table(&limits).markdown()
        ));
    }
    if let Some(shares) = shares {
        text.push_str(&format!(
            "\nWhat the variance at one level of shaking comes from, %: main effects; the rest is what they do together.\n\n{}",
            shares.markdown()
        ));
    }
    if let Some(table) = methods::compare(&runs) {
        text.push_str(&format!(
            "\nWhether methods agree: medians on the same motions, 90 % intervals by a bootstrap; p by Holm over all pairs of a quantity.\n\n{}",
            table.markdown()
        ));
        save_table("methods.csv", &table)?;
    }
    if let Some((table, short)) = control::tables(&runs) {
        text.push_str(&control::about(&runs));
        text.push_str(&short.markdown());
        save_table("control.csv", &table)?;
        save_table("dear.csv", &runs.dear_results().0)?;
    }
    say(&text);
    save("ensemble.md", &text)?;
    if let Some(picture) = runs.analysis()? {
        save("ida.svg", &picture)?;
    }
    if !limits.is_empty() {
        save("fragility.svg", &figure::fragility(&ensemble.measure, &intensities, &limits)?)?;
    }
    Ok(())
}

impl Runs<'_> {
    fn opening(&self) -> String {
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
        for (index, kept) in self.ensemble.dear.iter().zip(self.dear).filter(|(_, k)| !k.is_complete()) {
            let sample = &self.ensemble.samples[*index];
            let name = &plan.records[sample.record].name;
            failures.push(format!(
                "dear run of {name}, {:+}, scale {:.4}: {}",
                sample.polarity, sample.scale, kept.status
            ));
        }
        if !failures.is_empty() {
            text.push_str(&format!("NOT COMPLETED, and left out below: {}\n\n", failures.join("; ")));
        }
        text
    }

    /// A row for each run, and the names of the columns of text.
    fn results(&self) -> (Table, Vec<String>) {
        self.results_of(self.ensemble.hashes.iter().zip(self.kept).enumerate())
    }

    /// The same of the dear runs.
    fn dear_results(&self) -> (Table, Vec<String>) {
        let Ensemble { dear, dear_hashes, .. } = self.ensemble;
        self.results_of(dear.iter().copied().zip(dear_hashes.iter().zip(self.dear)))
    }

    /// The same of runs that are given by the numbers of their samples, their hashes and what is kept of them.
    fn results_of<'b>(
        &self,
        runs: impl Iterator<Item = (usize, (&'b String, &'b Kept))>,
    ) -> (Table, Vec<String>) {
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
    fn statistics(&self) -> (Table, Table) {
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
                    let interval = interval.map_or_else(
                        || "too few runs".to_owned(),
                        |[low, high]| format!("{} to {}", digits(low), digits(high)),
                    );
                    short.row(start.into_iter().chain([
                        format!("{} ({interval})", digits(median)),
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

    /// Intensities at which curves are drawn: up to beyond the strongest shaking.
    fn intensities(&self) -> Vec<f64> {
        let most = self.ensemble.samples.iter().fold(0.0f64, |most, sample| most.max(sample.intensity));
        (1..=POINTS).map(|i| BEYOND * most * i as f64 / POINTS as f64).collect()
    }

    fn limits(&self, intensities: &[f64]) -> Vec<LimitCurve> {
        let of_limit = |limit: &super::plan::Limit| {
            let with_value = self.complete().filter(|i| !self.kept[*i].value(&limit.quantity).is_nan());
            let outcomes: Vec<Outcome> = with_value
                .map(|index| Outcome {
                    intensity: self.ensemble.samples[index].intensity,
                    exceeded: self.kept[index].value(&limit.quantity).abs() > limit.above,
                    cluster: self.clusters[index],
                })
                .collect();
            let unit = self.quantities.iter().find(|(name, _)| *name == limit.quantity);
            LimitCurve {
                left_out: self.kept.len() - outcomes.len(),
                quantity: limit.quantity.clone(),
                above: limit.above,
                unit: unit.map_or_else(String::new, |(_, unit)| unit.clone()),
                curve: fit(&outcomes),
                band: band(&outcomes, intensities, CONFIDENCE, DRAWS, self.ensemble.plan.seed),
                exceeding: outcomes.iter().filter(|outcome| outcome.exceeded).count(),
                runs: outcomes.len(),
            }
        };
        self.ensemble.plan.limits.iter().map(of_limit).collect()
    }

    /// Shares of the variance about the mean of each level: record, polarity, parameters, numerics, rest.
    fn variance(&self) -> (Table, Option<Table>) {
        let Ensemble { plan, samples, .. } = self.ensemble;
        let mut factors: Vec<(String, Vec<usize>)> = Vec::new();
        if plan.records.len() > 1 {
            factors.push(("record".to_owned(), samples.iter().map(|sample| sample.record).collect()));
        }
        if plan.polarities.len() > 1 {
            let of_sample = samples.iter().map(|sample| usize::from(sample.polarity < 0)).collect();
            factors.push(("polarity".to_owned(), of_sample));
        }
        for (column, (key, _)) in plan.variations().enumerate() {
            let kind = if column < plan.parameters.len() { "" } else { " (numerics)" };
            let groups = groups(&samples.iter().map(|sample| &*sample.values[column]).collect::<Vec<_>>());
            factors.push((format!("{key}{kind}"), groups));
        }
        let headings =
            std::iter::once("quantity".to_owned()).chain(factors.iter().map(|(name, _)| name.clone()));
        let headings: Vec<String> = headings.chain(["rest".to_owned()]).collect();
        let (mut table, mut short) = (Table::new(headings.clone()), Table::new(headings));
        for (name, unit) in &self.quantities {
            let mut about_mean: Vec<(usize, f64)> = Vec::new();
            for (_, runs) in self.levels() {
                let values = runs.into_iter().map(|index| (index, self.value(index, name)));
                let values: Vec<(usize, f64)> = values.filter(|(_, value)| !value.is_nan()).collect();
                let mean = values.iter().map(|(_, value)| value).sum::<f64>() / values.len() as f64;
                about_mean.extend(values.into_iter().map(|(index, value)| (index, value - mean)));
            }
            let effect = |groups: &Vec<usize>| {
                let grouped: Vec<(usize, f64)> =
                    about_mean.iter().map(|(index, value)| (groups[*index], *value)).collect();
                main_effect(&grouped)
            };
            let effects: Vec<Option<f64>> = factors.iter().map(|(_, groups)| effect(groups)).collect();
            let rest = (1.0 - effects.iter().flatten().sum::<f64>()).max(0.0);
            let all = || effects.iter().copied().chain([Some(rest)]);
            let label = format!("{name} [{unit}]");
            let exact = all().map(|share| share.map_or_else(String::new, |share| share.to_string()));
            table.row(std::iter::once(label.clone()).chain(exact));
            if self.is_shown(name) {
                let percent = |share: Option<f64>| share.map_or("?".into(), |s| format!("{:.0}", 100.0 * s));
                short.row(std::iter::once(label).chain(all().map(percent)));
            }
        }
        let telling = factors.len() > 1 || factors.iter().any(|(name, _)| name != "record");
        (table, telling.then_some(short))
    }

    /// The picture of the first limit's quantity, else of the first one that is shown, over intensity; none of one level.
    fn analysis(&self) -> Result<Option<String>, EnsembleError> {
        let of_limit = self.ensemble.plan.limits.first().map(|limit| limit.quantity.clone());
        let shown = self.quantities.iter().map(|(name, _)| name.clone());
        let mut shown = shown.filter(|name| SHOWN[1..].iter().any(|shown| name.starts_with(shown)));
        let Some(name) = of_limit.or_else(|| shown.next()) else { return Ok(None) };
        let levels = self.levels();
        if levels.len() < 2 {
            return Ok(None);
        }
        let unit = self.quantities.iter().find(|(other, _)| *other == name);
        let label = format!("{name}, {}", unit.map_or("", |(_, unit)| unit));
        // Runs of one motion and dam lie one after the other.
        let of_motion = (0..self.kept.len()).collect::<Vec<_>>();
        let lines = of_motion.chunks(levels.len()).map(|runs| {
            let complete = runs.iter().filter(|index| self.kept[**index].is_complete());
            let points =
                complete.map(|i| (self.kept[*i].value(&name).abs(), self.ensemble.samples[*i].intensity));
            points.filter(|(value, _)| !value.is_nan()).collect()
        });
        let of_level = |runs: &Vec<usize>| {
            let mut values: Vec<f64> = runs
                .iter()
                .map(|i| self.kept[*i].value(&name).abs())
                .filter(|value| !value.is_nan())
                .collect();
            values.sort_by(f64::total_cmp);
            let intensity =
                runs.iter().map(|i| self.ensemble.samples[*i].intensity).sum::<f64>() / runs.len() as f64;
            (!values.is_empty()).then(|| (intensity, [0.16, 0.5, 0.84].map(|share| quantile(&values, share))))
        };
        let summary: Vec<(f64, [f64; 3])> = levels.iter().filter_map(|(_, runs)| of_level(runs)).collect();
        figure::analysis(&self.ensemble.measure, &label, &lines.collect::<Vec<_>>(), &summary).map(Some)
    }
}

/// The number of the group of each value: equal words together; of more numbers than groups, equal shares by their order.
fn groups(values: &[&str]) -> Vec<usize> {
    let mut different: Vec<&str> = values.to_vec();
    let number = |value: &str| value.parse::<f64>().unwrap_or(f64::NAN);
    different.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
    different.dedup();
    let place = |value: &&str| different.iter().position(|other| other == value).unwrap_or(0);
    let are_numbers = different.iter().all(|value| !number(value).is_nan());
    match different.len() {
        count if count > GROUPS && are_numbers => {
            values.iter().map(|value| GROUPS * place(value) / count).collect()
        }
        _ => values.iter().map(place).collect(),
    }
}

/// The curves and their bands.
fn curves(limits: &[LimitCurve], intensities: &[f64], measure: &str) -> Table {
    let of_limit = |limit: &LimitCurve| {
        let name = format!("{} > {} {}", limit.quantity, limit.above, limit.unit);
        [name.clone(), format!("low: {name}"), format!("high: {name}")]
    };
    let headings = std::iter::once(format!("{measure} [g]")).chain(limits.iter().flat_map(of_limit));
    let mut table = Table::new(headings);
    for (index, intensity) in intensities.iter().enumerate() {
        let mut row = vec![intensity.to_string()];
        for LimitCurve { curve, band, .. } in limits {
            let number = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
            let [low, high] = band.as_ref().map_or([f64::NAN; 2], |band| band.probability[index]);
            row.extend([curve.probability(*intensity), low, high].map(number));
        }
        table.row(row);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_sorted_into_groups() {
        assert_eq!(groups(&["b", "a", "b"]), [1, 0, 1]);
        assert_eq!(groups(&["10", "9", "10"]), [1, 0, 1]);
        let many: Vec<String> = (0..20).rev().map(|i| i.to_string()).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(groups(&many), (0..20).rev().map(|i| i / 4).collect::<Vec<_>>());
    }
}
