//! Tables of the limits: their curves, and the runs beyond them.

use super::plan::Intensity;
use super::runs::{LimitResult, Runs, digits};
use super::tables::with_interval;
use crate::statistics::{Curve, LEAST_CLUSTERS, WIDTH};
use crate::table::Table;
use cofferdam_report::{known_digits, percent};

/// What the runs support, in a word.
fn kind(limit: &LimitResult, runs: &Runs<'_>) -> &'static str {
    match limit.evidence.curve {
        Curve::Supported(_) if runs.is_of_one_record() => "one record",
        Curve::Supported(_) => "supported",
        Curve::Separated { .. } => "penalised",
        Curve::None(_) => "none",
    }
}

/// Median and dispersion, each with the ends of its interval; what is unknown is NaN. Without a curve the interval of the median is that of the
/// levels' exact intervals.
fn numbers(limit: &LimitResult) -> [[f64; 3]; 2] {
    const UNKNOWN: f64 = f64::NAN;
    let [low, high] = limit.evidence.bracket.unwrap_or([UNKNOWN; 2]);
    let bracket = [if low > 0.0 { low } else { UNKNOWN }, if high.is_finite() { high } else { UNKNOWN }];
    let estimate = limit.evidence.estimate().map_or([UNKNOWN; 2], |curve| [curve.median, curve.dispersion]);
    let [median, dispersion] = match &limit.evidence.curve {
        Curve::Supported(fitted) => {
            [fitted.median(), fitted.dispersion()].map(|interval| interval.unwrap_or([UNKNOWN; 2]))
        }
        Curve::Separated { dispersion_at_most, .. } => [bracket, [UNKNOWN, *dispersion_at_most]],
        Curve::None(_) => [bracket, [UNKNOWN; 2]],
    };
    [[estimate[0], median[0], median[1]], [estimate[1], dispersion[0], dispersion[1]]]
}

/// Why a curve is not supported, and what to add; nothing if it is.
fn remark(limit: &LimitResult, runs: &Runs<'_>) -> String {
    let mut sentences = Vec::new();
    if limit.left_out > 0 {
        sentences.push(format!(
            "{} runs lack this value, because they failed or their blocks still move, and are excluded: they are more likely to have strong shaking",
            limit.left_out
        ));
    }
    if runs.is_of_one_record() {
        sentences.push(
            "all runs are of one record or pair: other records may differ by more than any interval"
                .to_owned(),
        );
    }
    let units = |text: String| {
        if runs.is_of_one_record() { text.replace("records or pairs", "motions") } else { text }
    };
    let missing: Vec<String> =
        limit.evidence.missing().iter().map(|missing| units(missing.to_string())).collect();
    if !missing.is_empty() {
        let what = match &limit.evidence.curve {
            Curve::Separated { .. } => {
                "penalised curve without intervals, its steepness is that of the prior"
            }
            _ => "no curve",
        };
        sentences.push(format!("{what}: {}", missing.join(", ")));
        let levels = &limit.proposal.levels;
        if !levels.is_empty() {
            let names = names(levels, &runs.ensemble.plan.intensity).join(", ");
            let motions = runs.kept.len() / runs.levels().len().max(1);
            let each = if levels.len() > 1 { " each" } else { "" };
            sentences.push(format!("add {names} ({motions} runs{each}): --add-levels runs them"));
        }
        let more = limit.proposal.records.saturating_sub(limit.evidence.clusters);
        if limit.runs > 0 && more > 0 {
            sentences.push(units(format!("add {more} records or pairs")));
        }
    }
    sentences.join("; ")
}

/// Levels or factors as tables call them.
pub fn names(levels: &[f64], intensity: &Intensity) -> Vec<String> {
    let [before, after] = intensity.affixes();
    levels.iter().map(|level| format!("{before}{level}{after}")).collect()
}

/// The short tables: curves, and the exceedances of each level.
pub fn short(limits: &[LimitResult], runs: &Runs<'_>) -> [Table; 2] {
    let mut table = Table::new(["limit", "exceeded by", "median, g (95 %)", "dispersion (95 %)", "remark"]);
    let mut levels = Table::new(["limit", "level", "runs", "records", "exceeding, % (95 %)"]);
    for limit in limits {
        let LimitResult { exceeding, runs: count, .. } = limit;
        let [median, dispersion] = numbers(limit).map(interval);
        table.row([limit.name(), format!("{exceeding} of {count}"), median, dispersion, remark(limit, runs)]);
        for (name, level) in runs.ensemble.plan.intensity.level_names().into_iter().zip(&limit.levels) {
            let [share, low, high] = [level.share, level.interval[0], level.interval[1]].map(percent);
            let share = if level.runs == 0 { String::new() } else { format!("{share} ({low} to {high})") };
            let start = [limit.name(), name, format!("{} of {}", level.exceeding, level.runs)];
            levels.row(start.into_iter().chain([level.clusters.to_string(), share]));
        }
    }
    [table, levels]
}

/// A value with its interval, as far as it is known. Without a value the ends are levels.
fn interval([value, low, high]: [f64; 3]) -> String {
    match (value.is_nan(), low.is_nan(), high.is_nan()) {
        (false, false, false) => with_interval(value, [low, high]),
        (false, true, false) => {
            let [value, _, high] = known_digits(value, [0.0, high]);
            format!("{value} (below {high})")
        }
        (false, _, true) => digits(value),
        (true, false, false) => format!("{low} to {high}"),
        (true, false, true) => format!("above {low}"),
        (true, true, false) => format!("below {high}"),
        (true, true, true) => String::new(),
    }
}

/// What records are missing for the stated width of all intervals.
pub fn advice(limits: &[LimitResult]) -> Option<String> {
    let limit = limits.iter().find(|limit| !limit.evidence.missing().is_empty())?;
    let (have, wanted) = (limit.evidence.clusters, limit.proposal.records_for_width);
    (have < wanted).then(|| {
        format!(
            "The exact intervals are those of {have} independent records or pairs; they are at most {:.0} percentage points wide with {wanted}, \
             and a curve needs at least {LEAST_CLUSTERS}.",
            100.0 * WIDTH
        )
    })
}

/// The curves with all digits.
pub fn fits(limits: &[LimitResult], runs: &Runs<'_>) -> Table {
    let for_width = format!("records for {:.0} points", 100.0 * WIDTH);
    let mut table = Table::new([
        "limit",
        "quantity",
        "above",
        "unit",
        "exceeding",
        "runs",
        "left out",
        "records",
        "curve",
        "median [g]",
        "low",
        "high",
        "dispersion",
        "dispersion low",
        "dispersion high",
        "add levels",
        for_width.as_str(),
        "remark",
    ]);
    for limit in limits {
        let LimitResult { quantity, above, unit, exceeding, runs: count, left_out, proposal, .. } = limit;
        let start = [limit.name(), quantity.clone(), above.to_string(), unit.clone()];
        let counts = [exceeding, count, left_out, &limit.evidence.clusters].map(ToString::to_string);
        let values = numbers(limit).concat().into_iter().map(number);
        let added = names(&proposal.levels, &runs.ensemble.plan.intensity).join(", ");
        let end = [added, proposal.records_for_width.to_string(), remark(limit, runs)];
        table.row(
            start.into_iter().chain(counts).chain([kind(limit, runs).to_owned()]).chain(values).chain(end),
        );
    }
    table
}

/// For each limit and level of shaking the runs that exceed it, with the exact interval of their share; where levels are intensities and a
/// curve is supported, its value there with its band.
pub fn exceedance(runs: &Runs<'_>, limits: &[LimitResult]) -> Table {
    let intensity = &runs.ensemble.plan.intensity;
    let headings = [
        "limit",
        "level",
        "runs",
        "exceeding",
        "records",
        "share",
        "low",
        "high",
        "curve",
        "curve low",
        "curve high",
    ];
    let mut table = Table::new(headings);
    for limit in limits {
        for (name, level) in intensity.level_names().into_iter().zip(&limit.levels) {
            let curve = match &limit.evidence.curve {
                Curve::Supported(fitted) if !intensity.levels.is_empty() => {
                    let (value, [low, high]) = fitted.probability(level.intensity);
                    [value, low, high]
                }
                _ => [f64::NAN; 3],
            };
            let counts = [level.runs, level.exceeding, level.clusters].map(|count| count.to_string());
            let [low, high] = if level.runs == 0 { [f64::NAN; 2] } else { level.interval };
            let shares = [level.share, low, high].into_iter().chain(curve).map(number);
            table.row([limit.name(), name].into_iter().chain(counts).chain(shares));
        }
    }
    table
}

/// All digits; nothing for what is no number.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_say_what_is_known() {
        const UNKNOWN: f64 = f64::NAN;
        for (of, wanted) in [
            ([0.3127, 0.2412, 0.4159], "0.31 (0.24 to 0.42)"),
            ([UNKNOWN, 0.2, 0.5], "0.2 to 0.5"),
            ([UNKNOWN, 0.2, UNKNOWN], "above 0.2"),
            ([UNKNOWN, UNKNOWN, 0.5], "below 0.5"),
            ([0.127, UNKNOWN, 0.423], "0.1 (below 0.4)"),
            ([UNKNOWN; 3], ""),
        ] {
            assert_eq!(interval(of), wanted, "{of:?}");
        }
    }
}
