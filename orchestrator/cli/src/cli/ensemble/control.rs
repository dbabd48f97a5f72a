//! What few dear runs and many cheap ones say together.

use super::runs::{CONFIDENCE, DRAWS, Runs, digits};
use crate::cli::table::Table;
use cofferdam_analysis::statistics::{Control, Motion, control};
use std::collections::BTreeMap;

/// What the tables show, for `ensemble.md`.
pub fn about(runs: &Runs<'_>) -> String {
    let Some(dear) = &runs.ensemble.plan.dear else { return String::new() };
    format!(
        "\nDistribution by the dear model ({}) from few dear runs and all cheap ones: a control variate, 95 % intervals by a bootstrap of \
         whole records or pairs. A dear run costs {} cheap ones, as the plan says; the saving is beside dear runs alone of the same \
         cost.\n\n",
        dear.set.join(", "),
        dear.cost()
    )
}

/// A row for each quantity of the short tables at each level, with all digits and in short; none without dear runs.
pub fn tables(runs: &Runs<'_>) -> Option<(Table, Table)> {
    let plan = &runs.ensemble.plan;
    let cost = plan.dear.as_ref()?.cost();
    let mut table = Table::new([
        "quantity",
        "level",
        "pairs",
        "motions",
        "correlation",
        "coefficient",
        "predicted saving",
        "best motions a pair",
        "saving of these runs",
        "control",
        "median",
        "low",
        "high",
        "16 %",
        "84 %",
        "dear alone",
        "dear alone low",
        "dear alone high",
        "cheap alone",
        "remark",
    ]);
    let mut short = Table::new([
        "quantity",
        "level",
        "dear of cheap",
        "ρ",
        "saving predicted",
        "median (95 %)",
        "dear alone (95 %)",
        "cheap alone",
        "control",
    ]);
    for (name, unit) in runs.shown() {
        for (level, (level_name, _)) in runs.levels().into_iter().enumerate() {
            let found = control(&motions(runs, &name, level), cost, CONFIDENCE, DRAWS, plan.seed);
            let Control { pairs, motions, correlation, coefficient, predicted, plain, .. } = &found;
            let best = found.best();
            let (used, why) = match &found.controlled {
                Ok(_) => ("used", String::new()),
                Err(why) => ("declined", why.to_string()),
            };
            let [low, high] = best.interval.unwrap_or([f64::NAN; 2]);
            let [plain_low, plain_high] = plain.interval.unwrap_or([f64::NAN; 2]);
            let start = [format!("{name} [{unit}]"), level_name];
            let shares = [*correlation, *coefficient, *predicted, found.best_ratio, found.saving];
            let medians = [best.quantiles[1], low, high, best.quantiles[0], best.quantiles[2]];
            let alone = [plain.quantiles[1], plain_low, plain_high, found.cheap];
            table.row(
                (start.iter().cloned())
                    .chain([pairs, motions].map(ToString::to_string))
                    .chain(shares.map(number))
                    .chain([used.to_owned()])
                    .chain(medians.into_iter().chain(alone).map(number))
                    .chain([why.clone()]),
            );
            let with_interval = |median: f64, interval: Option<[f64; 2]>| match interval {
                Some([low, high]) => format!("{} ({} to {})", digits(median), digits(low), digits(high)),
                None => format!("{} (too few runs)", digits(median)),
            };
            short.row(start.into_iter().chain([
                format!("{pairs} of {motions}"),
                format!("{correlation:.2}"),
                format!("{predicted:.2}"),
                with_interval(best.quantiles[1], best.interval),
                with_interval(plain.quantiles[1], plain.interval),
                digits(found.cheap),
                if why.is_empty() { used.to_owned() } else { format!("{used}: {why}") },
            ]));
        }
    }
    Some((table, short))
}

/// The motions of a level with the values of a quantity by both models.
fn motions(runs: &Runs<'_>, quantity: &str, level: usize) -> Vec<Motion> {
    let ensemble = runs.ensemble;
    let clusters = ensemble.clusters();
    let value = |kept: &super::sample::Kept| {
        if kept.is_complete() { runs.value_of(kept, quantity) } else { f64::NAN }
    };
    let dear: BTreeMap<usize, f64> = ensemble.dear.iter().copied().zip(runs.dear.iter().map(value)).collect();
    let of_level = ensemble.samples.iter().enumerate().filter(|(_, sample)| sample.level == level);
    of_level
        .map(|(index, _)| Motion {
            cluster: clusters[index],
            cheap: value(&runs.kept[index]),
            dear: dear.get(&index).copied(),
        })
        .collect()
}

/// All digits; nothing for what is no number.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}
