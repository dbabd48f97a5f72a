//! From the values of all runs to the ranges of the quantities.

use super::plan::{Coordinate, Part, Planned};
use super::quantities::{Measured, Results};
use super::setting::{Factor, Values};
use crate::statistics::{Settings, quantile, rank_share};
use cofferdam_report::{Combined, RangeQuantity, Setting, Swing, VarianceShare};

/// Quantiles of the combined interval.
pub const QUANTILES: [f64; 2] = [0.05, 0.95];
/// Minimum number of runs for shares of the variance.
const LEAST: usize = 8;
/// Relative spread that is rounding.
const ROUNDING: f64 = 1e-6;

/// A run and its results; none if it failed.
pub type Finished = (Planned, Option<Results>);

/// The ranges of all quantities that the scene as it is has. The first run is the scene as it is.
pub fn ranges(factors: &[Factor], runs: &[Finished]) -> Vec<RangeQuantity> {
    let base = runs.first().and_then(|(_, results)| results.as_ref());
    base.map_or_else(Vec::new, |base| {
        base.values.iter().map(|measured| range(factors, runs, measured)).collect()
    })
}

fn range(factors: &[Factor], runs: &[Finished], Measured { name, unit, value }: &Measured) -> RangeQuantity {
    let valued: Vec<(&Planned, f64)> = runs
        .iter()
        .filter_map(|(run, results)| Some((run, results.as_ref()?.value(name))))
        .filter(|(_, value)| !value.is_nan())
        .collect();
    let mut swings: Vec<Swing> =
        factors.iter().enumerate().filter_map(|(index, factor)| swing(index, factor, &valued)).collect();
    swings.sort_by(|a, b| b.size(*value).total_cmp(&a.size(*value)));
    let combined = combined(factors, &valued);
    let widest =
        swings.iter().map(|swing| swing.interval(*value)).chain(combined.as_ref().map(|all| all.interval));
    let spread = finite(widest.flatten().chain([*value]));
    let [low, high] = spread.unwrap_or([0.0; 2]);
    let combined = combined.map(|all| {
        let varies = high - low > ROUNDING * low.abs().max(high.abs());
        if varies || all.extremes.iter().any(|value| value.is_infinite()) {
            return all;
        }
        // Shares of the variance of rounding say nothing.
        Combined { shares: Vec::new(), ..all }
    });
    RangeQuantity {
        name: name.clone(),
        unit: (*unit).to_owned(),
        as_it_is: *value,
        last_digit: last_digit([low, high]),
        swings,
        combined,
    }
}

/// Lowest and highest value with another setting of a factor alone; none without such a run.
fn swing(index: usize, factor: &Factor, valued: &[(&Planned, f64)]) -> Option<Swing> {
    let alone = valued.iter().filter(|(run, _)| run.part == Part::Alone(index));
    let mut settings: Vec<Setting> = alone
        .map(|(run, value)| Setting { setting: factor.shown(&run.coordinates[index]), value: *value })
        .collect();
    settings.sort_by(|a, b| a.value.total_cmp(&b.value));
    let [low, high] = [settings.first()?.clone(), settings.last()?.clone()];
    Some(Swing { factor: factor.about.name.clone(), kind: factor.about.kind, low, high })
}

/// Quantiles and shares of the joint sample; none with fewer than two values.
fn combined(factors: &[Factor], valued: &[(&Planned, f64)]) -> Option<Combined> {
    let joint: Vec<&(&Planned, f64)> = valued.iter().filter(|(run, _)| run.part == Part::Joint).collect();
    let values: Vec<f64> = joint.iter().map(|(_, value)| *value).collect();
    let mut ascending = values.clone();
    ascending.sort_by(f64::total_cmp);
    let ([least, .., most], runs) = (&ascending[..], values.len()) else { return None };
    let share = |(index, factor): (usize, &Factor)| {
        let settings: Vec<&Coordinate> = joint.iter().map(|(run, _)| &run.coordinates[index]).collect();
        let found = match &factor.values {
            Values::Between(_) => {
                let number = |coordinate: &&Coordinate| match coordinate {
                    Coordinate::Number(number) => *number,
                    _ => f64::NAN,
                };
                rank_share(Settings::Numbers(&settings.iter().map(number).collect::<Vec<_>>()), &values)
            }
            Values::Choices { .. } => {
                let choice = |coordinate: &&Coordinate| match coordinate {
                    Coordinate::Choice(choice) => *choice,
                    _ => usize::MAX,
                };
                rank_share(Settings::Choices(&settings.iter().map(choice).collect::<Vec<_>>()), &values)
            }
            Values::Noise(_) => None,
        }?;
        let factor = factor.about.name.clone();
        Some(VarianceShare { factor, share: found.share, significant: found.significant })
    };
    let mut shares: Vec<VarianceShare> = match runs < LEAST {
        true => Vec::new(),
        false => factors.iter().enumerate().filter_map(share).collect(),
    };
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    let interval = QUANTILES.map(|share| quantile(&ascending, share));
    Some(Combined { runs, interval, extremes: [*least, *most], shares })
}

/// The smallest and largest of the values of runs in which nothing slides away.
pub fn finite(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite()).map(|value| [value; 2]);
    finite.reduce(|[a, b], [low, high]| [a.min(low), b.max(high)])
}

/// Unit of the last digit of numbers that spread over this interval: a tenth of its length, rounded down to a power of ten; at most
/// four digits, and three of a number that does not spread.
fn last_digit([low, high]: [f64; 2]) -> f64 {
    let power = |value: f64| value.log10().floor();
    let largest = low.abs().max(high.abs());
    if largest == 0.0 {
        return 0.01;
    }
    let exponent = match high - low {
        spread if spread > ROUNDING * largest => power(spread / 10.0).max(power(largest) - 3.0),
        _ => power(largest) - 2.0,
    };
    10f64.powf(exponent)
}

#[cfg(test)]
mod tests {
    use super::super::plan::{joint, one_at_a_time};
    use super::super::setting::{Between, Choice};
    use super::*;
    use cofferdam_report::{FactorKind, RangeFactor};

    /// Nine runs of one factor; where it is large the joint slides away.
    #[test]
    fn settings_that_slide_away_count_as_infinite_and_do_not_coarsen_the_digits() {
        let factors = [number("a", 0.0, 1.0)];
        let value = |a: f64| if a > 0.7 { f64::INFINITY } else { 30.0 + 10.0 * a };
        let planned = one_at_a_time(&factors, 1).into_iter().chain(joint(&factors, 20, 1));
        let runs: Vec<Finished> = planned
            .map(|run| {
                let Coordinate::Number(a) = run.coordinates[0] else { panic!("no number") };
                let measured = Measured { name: "sliding".to_owned(), unit: "mm", value: value(a) };
                (run, Some(Results { values: vec![measured], ..Results::default() }))
            })
            .collect();
        let [sliding] = &ranges(&factors, &runs)[..] else { panic!("one quantity") };
        let combined = sliding.combined.as_ref().expect("a sample");
        assert_eq!(combined.interval[1], f64::INFINITY);
        assert_eq!(
            sliding.shown_interval(combined.interval),
            format!("{:.1} to ∞ (slides away)", combined.interval[0])
        );
        assert!(sliding.varies() && combined.shares[0].significant);
        assert_eq!(sliding.shown(sliding.swings[0].high.value), "∞ (slides away)");
        assert_eq!(sliding.shown(35.0), "35.0");
    }

    #[test]
    fn digits_follow_the_spread() {
        for (interval, expected) in [
            ([26.2, 73.1], 1.0),
            ([42.1, 43.1], 0.1),
            ([120.0, 430.0], 10.0),
            ([1.0, 1.0], 0.01),
            ([-0.3, 0.4], 0.01),
            ([0.0, 0.0], 0.01),
            // a hundredth would be five digits
            ([1000.0, 1000.5], 1.0),
        ] {
            let found = last_digit(interval);
            assert!((found / expected - 1.0).abs() < 1e-12, "{interval:?}: {found}");
        }
    }

    fn factor(name: &str, kind: FactorKind, values: Values) -> Factor {
        let [range, reason] = [String::new(), String::new()];
        Factor { about: RangeFactor { name: name.to_owned(), kind, range, reason, joint: true }, values }
    }

    fn number(name: &str, low: f64, high: f64) -> Factor {
        let sets = Box::new(|value| vec![format!("a={value}")]);
        let between =
            Between { low, high, base: 0.5 * (low + high), logarithmic: false, sets, before: "", after: "" };
        factor(name, FactorKind::Model, Values::Between(between))
    }

    /// y = 10 + 3 a + 4 b + 5 c with a and b from −1 to 1, and c ±1: variances 3, 16/3 and 25; a fourth factor has no influence, and noise
    /// adds 0.1 in one direction or the other.
    #[test]
    fn a_linear_function_has_its_interval_its_swings_and_its_shares() {
        let choice = |name: &str| Choice { name: name.to_owned(), sets: vec![format!("c={name}")] };
        let two = Values::Choices { choices: vec![choice("down"), choice("up")], base: 0 };
        let factors = [
            number("a", -1.0, 1.0),
            number("b", -1.0, 1.0),
            factor("c", FactorKind::Numerics, two),
            number("none", -1.0, 1.0),
            factor("noise", FactorKind::Motion, Values::Noise(4)),
        ];
        let value = |run: &Planned| {
            let number = |index: usize| match run.coordinates[index] {
                Coordinate::Number(value) => value,
                Coordinate::Choice(index) => 2.0 * index as f64 - 1.0,
                Coordinate::Noise(seed) => seed.map_or(0.0, |seed| if seed % 2 == 0 { 0.1 } else { -0.1 }),
            };
            10.0 + 3.0 * number(0) + 4.0 * number(1) + 5.0 * number(2) + number(4)
        };
        let planned = one_at_a_time(&factors, 1).into_iter().chain(joint(&factors, 2000, 1));
        let mut runs: Vec<Finished> = planned
            .map(|run| {
                let values = vec![Measured { name: "y".to_owned(), unit: "mm", value: value(&run) }];
                (run, Some(Results { values, ..Results::default() }))
            })
            .collect();
        let found = &ranges(&factors, &runs)[0];
        assert_eq!(found.as_it_is, 5.0);
        let swings: Vec<(&str, [f64; 2])> =
            found.swings.iter().map(|swing| (&*swing.factor, swing.interval(5.0))).collect();
        assert_eq!(
            swings,
            [
                ("c", [5.0, 15.0]),
                ("b", [1.0, 9.0]),
                ("a", [2.0, 8.0]),
                ("noise", [4.9, 5.1]),
                ("none", [5.0, 5.0])
            ]
        );
        assert_eq!(found.interval_of(FactorKind::Model), Some([1.0, 9.0]));
        assert_eq!(found.swings[0].high.setting, "up");
        let combined = found.combined.as_ref().expect("a joint sample");
        assert_eq!(combined.runs, 2000);
        // y is 5 or 15 plus a sum of two uniform numbers of ±3 and ±4: 5 % lie below −7 + s with (s²/2)/(6·8)/2 = 0.05.
        let tail = (0.05f64 * 2.0 * 2.0 * 48.0).sqrt();
        assert!((combined.interval[0] - (5.0 - 7.0 + tail)).abs() < 0.25, "{:?}", combined.interval);
        assert!((combined.interval[1] - (15.0 + 7.0 - tail)).abs() < 0.25, "{:?}", combined.interval);
        let whole = 3.0 + 16.0 / 3.0 + 25.0;
        let expected = [("c", 25.0 / whole), ("b", 16.0 / 3.0 / whole), ("a", 3.0 / whole)];
        for (share, (name, expected)) in combined.shares.iter().zip(expected) {
            assert!(share.factor == name && share.significant, "{:?}", combined.shares);
            assert!((share.share - expected).abs() < 0.04, "{share:?} for {expected}");
        }
        assert!(combined.shares[3].share < 0.01 && combined.shares.len() == 4, "{:?}", combined.shares);
        // Failed runs are missing in the count, not counted as 0.
        let last = runs.len() - 100;
        runs[last..].iter_mut().for_each(|(_, results)| *results = None);
        let fewer = ranges(&factors, &runs)[0].combined.as_ref().expect("a joint sample").runs;
        assert_eq!(fewer, 1900);
    }
}
