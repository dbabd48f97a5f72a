//! Which polarity of a record governs.

use super::runs::{Runs, digits};
use crate::statistics::quantile;
use crate::table::Table;

/// Which polarity governs, of every quantity of the short tables: a row for each record and level, and for each level; none of one polarity.
pub fn governing(runs: &Runs<'_>) -> Option<(Table, Table)> {
    let plan = &runs.ensemble.plan;
    if plan.polarities.len() < 2 {
        return None;
    }
    let mut table = Table::new(["quantity", "level", "record", "+1", "-1", "governs"]);
    let mut short = Table::new(["quantity", "level", "+1 governs", "-1 governs", "largest", "of"]);
    for (name, unit) in runs.shown() {
        for (level, of_level) in runs.levels() {
            let (mut counts, mut largest) = ([0usize; 2], None::<(f64, String)>);
            for (number, record) in plan.records.iter().enumerate() {
                let median = |polarity: i64| {
                    let of_record = of_level.iter().filter(|index| {
                        let sample = &runs.ensemble.samples[**index];
                        sample.record == number && sample.polarity == polarity
                    });
                    let mut values: Vec<f64> =
                        of_record.map(|index| runs.kept[*index].value(&name).abs()).collect();
                    values.retain(|value| !value.is_nan());
                    values.sort_by(f64::total_cmp);
                    if values.is_empty() { f64::NAN } else { quantile(&values, 0.5) }
                };
                let both = [median(1), median(-1)];
                let governs = match both {
                    [plus, minus] if plus > minus => Some(0),
                    [plus, minus] if minus > plus => Some(1),
                    _ => None,
                };
                let words = ["+1", "-1"];
                if let Some(governs) = governs {
                    counts[governs] += 1;
                    if largest.as_ref().is_none_or(|(value, _)| both[governs] > *value) {
                        largest = Some((both[governs], format!("{}, {}", record.name, words[governs])));
                    }
                }
                let number = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
                let row = [format!("{name} [{unit}]"), level.clone(), record.name.clone()];
                let governs = governs.map_or("", |governs| words[governs]).to_owned();
                table.row(row.into_iter().chain(both.map(number)).chain([governs]));
            }
            let (value, of) = largest.unwrap_or_default();
            let counts = counts.map(|count| format!("{count} of {}", plan.records.len()));
            short.row(
                [format!("{name} [{unit}]"), level].into_iter().chain(counts).chain([digits(value), of]),
            );
        }
    }
    Some((table, short))
}
