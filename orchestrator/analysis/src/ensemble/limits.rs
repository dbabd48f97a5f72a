//! Tables of the limits: their curves, and the runs beyond them.

use super::runs::{LimitCurve, Runs, digits};
use crate::statistics::Fragility;
use crate::table::Table;

/// Remark on a curve, or the reason why there is none.
fn remark(limit: &LimitCurve) -> String {
    let own = match (&limit.curve, &limit.band) {
        (Fragility::Fit(_), Some(band)) if band.fitted < 0.95 => {
            format!("only {:.0} % of the bootstrap samples gave a curve: too few runs", 100.0 * band.fitted)
        }
        (Fragility::Fit(_), Some(_)) => String::new(),
        (Fragility::Fit(_), None) => {
            "the record-to-record uncertainty is unknown: there is only one record or pair".to_owned()
        }
        (Fragility::None(why), _) => why.to_string(),
    };
    let without = match limit.left_out {
        0 => String::new(),
        count => format!(
            "{count} runs lack this value, because they failed or their blocks still move, and are excluded: they are more likely to have strong shaking; "
        ),
    };
    (without + &own).trim_end_matches("; ").to_owned()
}

fn name(limit: &LimitCurve) -> String {
    format!("{} > {} {}", limit.quantity, limit.above, limit.unit)
}

/// The short table.
pub fn table(limits: &[LimitCurve]) -> Table {
    let mut table = Table::new(["limit", "exceeded by", "median, g (95 %)", "dispersion (95 %)", ""]);
    for limit in limits {
        let LimitCurve { curve, band, exceeding, runs, .. } = limit;
        let interval = |value: f64, [low, high]: [f64; 2]| {
            format!("{} ({} to {})", digits(value), digits(low), digits(high))
        };
        let (median, dispersion) = match (curve, band) {
            (Fragility::Fit(curve), Some(band)) => {
                (interval(curve.median, band.median), interval(curve.dispersion, band.dispersion))
            }
            (Fragility::Fit(curve), None) => (digits(curve.median), digits(curve.dispersion)),
            (Fragility::None(_), _) => (String::new(), String::new()),
        };
        table.row([name(limit), format!("{exceeding} of {runs}"), median, dispersion, remark(limit)]);
    }
    table
}

/// The same with all digits.
pub fn fits(limits: &[LimitCurve]) -> Table {
    let mut table = Table::new([
        "limit",
        "quantity",
        "above",
        "unit",
        "exceeding",
        "runs",
        "left out",
        "median [g]",
        "low",
        "high",
        "dispersion",
        "dispersion low",
        "dispersion high",
        "remark",
    ]);
    for limit in limits {
        let LimitCurve { quantity, above, unit, curve, band, exceeding, runs, left_out } = limit;
        let mut numbers = [f64::NAN; 6];
        if let Fragility::Fit(curve) = curve {
            (numbers[0], numbers[3]) = (curve.median, curve.dispersion);
        }
        if let (Fragility::Fit(_), Some(band)) = (curve, band) {
            ([numbers[1], numbers[2]], [numbers[4], numbers[5]]) = (band.median, band.dispersion);
        }
        let start = [name(limit), quantity.clone(), above.to_string(), unit.clone()];
        let counts = [exceeding, runs, left_out].map(ToString::to_string);
        table.row(start.into_iter().chain(counts).chain(numbers.map(number)).chain([remark(limit)]));
    }
    table
}

/// For each limit and level of shaking the runs that exceed it; where levels are intensities, the curve there, of which the band has
/// `before` other intensities first.
pub fn exceedance(runs: &Runs<'_>, limits: &[LimitCurve], levels: &[f64], before: usize) -> Table {
    let mut table = Table::new(["limit", "level", "runs", "exceeding", "share", "curve", "low", "high"]);
    for limit in limits {
        for (index, (level, of_level)) in runs.levels().into_iter().enumerate() {
            let values: Vec<f64> =
                of_level.iter().map(|run| runs.kept[*run].value(&limit.quantity).abs()).collect();
            let count = values.iter().filter(|value| !value.is_nan()).count();
            let exceeding = values.iter().filter(|value| **value > limit.above).count();
            let fitted = levels.get(index).filter(|_| matches!(limit.curve, Fragility::Fit(_)));
            let curve = fitted.map_or(f64::NAN, |intensity| limit.curve.probability(*intensity));
            let band = limit.band.as_ref().filter(|_| index < levels.len());
            let [low, high] =
                band.and_then(|band| band.probability.get(before + index)).copied().unwrap_or([f64::NAN; 2]);
            let start = [name(limit), level, count.to_string(), exceeding.to_string()];
            let share = exceeding as f64 / count as f64;
            table.row(start.into_iter().chain([share, curve, low, high].map(number)));
        }
    }
    table
}

/// All digits; nothing for what is no number.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}
