//! Sources of the variance of an ensemble.

use super::Ensemble;
use super::runs::Runs;
use crate::statistics::main_effect;
use crate::table::Table;

/// Groups into which the values of a distribution are sorted to find its effect.
const GROUPS: usize = 5;

impl Runs<'_> {
    /// Shares of the variance about the mean of each level: record, polarity, parameters, numerics, rest.
    pub fn variance(&self) -> (Table, Option<Table>) {
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
