use statrs::distribution::{Binomial, DiscreteCDF};

/// The quantile `share` (from 0 to 1) of values in ascending order, linear between them: with n values, value number
/// `1 + share (n − 1)`; NaN of none.
///
/// **Source**: R.J. Hyndman, Y. Fan, Sample quantiles in statistical packages, The American Statistician 50 (1996),
/// definition 7.
pub fn quantile(ascending: &[f64], share: f64) -> f64 {
    let Some(last) = ascending.len().checked_sub(1) else { return f64::NAN };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let [low, high] = [below, (below + 1).min(last)].map(|index| ascending[index]);
    let share = place - below as f64;
    // also of infinite values
    if share == 0.0 || low == high { low } else { low + share * (high - low) }
}

/// Interval that holds the median of the population with at least this `confidence`, whatever its distribution, from values
/// in ascending order of which this number is `independent`, n: values number k and n + 1 − k with the largest k for which
///
/// ```text
/// P(B < k) ≤ (1 − confidence)/2,   B binomial of n and ½
/// ```
///
/// Where values come in groups, n is the number of groups, and the interval has the same quantiles of all values. It is then too
/// wide unless those of a group are equal. None if n is too small (below 6 for 95 %).
///
/// **Source**: W.J. Conover, *Practical Nonparametric Statistics*, 3rd edition (1999), section 3.2.
pub fn median_interval(ascending: &[f64], independent: usize, confidence: f64) -> Option<[f64; 2]> {
    let binomial = Binomial::new(0.5, independent as u64).ok()?;
    let tail = (1.0 - confidence) / 2.0;
    let k = (1..=independent / 2).take_while(|k| binomial.cdf(*k as u64 - 1) <= tail).last()?;
    let share = (k - 1) as f64 / (independent - 1) as f64;
    Some([share, 1.0 - share].map(|share| quantile(ascending, share)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_values() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0];
        assert_eq!(quantile(&values, 0.0), 1.0);
        assert_eq!(quantile(&values, 0.5), 4.0);
        assert_eq!(quantile(&values, 0.625), 6.0);
        assert_eq!(quantile(&values, 1.0), 16.0);
        assert!(quantile(&[], 0.5).is_nan());
        assert_eq!(quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.0), 1.0);
        assert_eq!(quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.8), f64::INFINITY);
    }

    #[test]
    fn the_interval_of_the_median_is_that_of_published_tables() {
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        // n = 20: values number 6 and 15 (95.9 %); n = 6: the first and the last (96.9 %); fewer cannot give 95 %.
        let close = |found: Option<[f64; 2]>, wanted: [f64; 2]| {
            let found = found.expect("enough values");
            assert!((found[0] - wanted[0]).abs() + (found[1] - wanted[1]).abs() < 1e-9, "{found:?}");
        };
        close(median_interval(&values, values.len(), 0.95), [6.0, 15.0]);
        // Every value twice: the same interval, with the number of pairs.
        let twice: Vec<f64> = values.iter().flat_map(|x| [*x, *x]).collect();
        let [low, high] = median_interval(&twice, 20, 0.95).expect("enough values");
        assert!((low - 6.0).abs() <= 0.5 && (high - 15.0).abs() <= 0.5, "{low} {high}");
        close(median_interval(&values[..6], 6, 0.95), [1.0, 6.0]);
        assert_eq!(median_interval(&values[..5], 5, 0.95), None);
        assert_eq!(median_interval(&[], 0, 0.95), None);
    }

    #[test]
    fn the_interval_of_the_median_holds_it_as_often_as_it_says() {
        let mut random = fastrand::Rng::with_seed(1);
        let trials = 2000;
        let held = (0..trials).filter(|_| {
            let mut values: Vec<f64> = (0..25).map(|_| -(1.0 - random.f64()).ln()).collect();
            values.sort_by(f64::total_cmp);
            let [low, high] = median_interval(&values, values.len(), 0.95).expect("enough values");
            low <= 2f64.ln() && 2f64.ln() <= high
        });
        let share = held.count() as f64 / f64::from(trials);
        // exactly 0.957 for 25 values; three standard deviations of the trials are 0.014
        assert!((share - 0.957).abs() < 0.014, "{share}");
    }
}
