//! Whether methods that the plan lists under `[numerics]` give the same distribution.

use super::plan::Plan;
use super::runs::{Runs, digits};
use crate::statistics::{Ratio, holm, ratio_of_medians};
use crate::table::Table;
use std::collections::BTreeMap;

/// Medians count as equal within this share.
const MARGIN: f64 = 0.1;
/// Probability below which methods count as equal.
const LEVEL: f64 = 0.05;
const DRAWS: usize = 2000;

/// Runs of one method: the number of the sample by realisation, level and parameters.
type OfMethod<'a> = BTreeMap<(usize, usize, &'a [String]), usize>;

/// Two methods at one level of shaking, and the medians of a quantity.
struct Pair {
    quantity: String,
    level: String,
    methods: [String; 2],
    runs: usize,
    ratio: Ratio,
}

/// The ratio of the medians of each shown quantity for every two methods, on the same motions and dams at each level; none without two
/// methods. Probabilities are Holm's over all pairs of a quantity.
pub fn compare(runs: &Runs<'_>) -> Option<Table> {
    let methods = methods(runs);
    if methods.len() < 2 {
        return None;
    }
    let names: Vec<&String> = methods.keys().collect();
    let mut table = Table::new([
        "quantity",
        "level",
        "method",
        "beside",
        "runs",
        "ratio of medians (90 %)",
        "equal within 10 %?",
    ]);
    for (quantity, unit) in runs.shown() {
        let mut pairs = Vec::new();
        for (second, name) in names.iter().enumerate() {
            for first in &names[..second] {
                let of_levels = runs.levels().into_iter().enumerate();
                pairs.extend(of_levels.filter_map(|(level, (level_name, _))| {
                    let values = values(runs, &quantity, level, [&methods[*first], &methods[*name]]);
                    let ratio = ratio_of_medians(&values, MARGIN, DRAWS, runs.ensemble.plan.seed)?;
                    Some(Pair {
                        quantity: format!("{quantity} [{unit}]"),
                        level: level_name,
                        methods: [(*first).clone(), (*name).clone()],
                        runs: values.len(),
                        ratio,
                    })
                }));
            }
        }
        let probabilities: Vec<f64> = pairs.iter().map(|pair| pair.ratio.probability).collect();
        for (Pair { quantity, level, methods: [first, second], runs, ratio }, probability) in
            pairs.into_iter().zip(holm(&probabilities))
        {
            let [low, high] = ratio.interval.map(digits);
            let verdict = match probability {
                p if p < LEVEL => format!("yes (p = {})", digits(p)),
                _ if ratio.interval[0] > 1.0 + MARGIN || ratio.interval[1] < 1.0 - MARGIN => "no".to_owned(),
                p => format!("not shown (p = {})", digits(p)),
            };
            let ratio = format!("{} ({low} to {high})", digits(ratio.value));
            table.row([quantity, level, second, first, runs.to_string(), ratio, verdict]);
        }
    }
    Some(table)
}

/// The completed runs of each method, which is called by its values of `[numerics]`.
fn methods<'a>(runs: &Runs<'a>) -> BTreeMap<String, OfMethod<'a>> {
    let Plan { parameters, numerics, .. } = &runs.ensemble.plan;
    let mut methods: BTreeMap<String, OfMethod<'a>> = BTreeMap::new();
    for index in runs.complete() {
        let sample = &runs.ensemble.samples[index];
        let (of_dam, of_method) = sample.values.split_at(parameters.len());
        let called = numerics.keys().zip(of_method).map(|(key, value)| {
            format!("{} {}", key.rsplit('.').next().unwrap_or(key), value.trim_matches('"'))
        });
        let method = methods.entry(called.collect::<Vec<_>>().join(", ")).or_default();
        method.insert((sample.draw, sample.level, of_dam), index);
    }
    methods
}

/// The magnitudes of a quantity by both methods where both have it, with their cluster: records of a pair, or motions of
/// a single record.
fn values(
    runs: &Runs<'_>,
    quantity: &str,
    level: usize,
    methods: [&OfMethod<'_>; 2],
) -> Vec<(usize, [f64; 2])> {
    let [first, second] = methods;
    let alone = runs.ensemble.plan.records.len() == 1;
    let of_pair = |(key, index): (&(usize, usize, &[String]), &usize)| {
        let values = [*index, *second.get(key)?].map(|index| runs.kept[index].value(quantity).abs());
        let cluster = if alone { key.0 } else { runs.clusters[*index] };
        values.iter().all(|value| value.is_finite()).then_some((cluster, values))
    };
    first.iter().filter(|((_, of, _), _)| *of == level).filter_map(of_pair).collect()
}
