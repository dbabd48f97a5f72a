use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::collections::BTreeMap;

/// Probability of chance alone above which a share does not stand out.
const CHANCE: f64 = 0.05;

/// The settings of a factor, one for each value of the result.
#[derive(Clone, Copy, Debug)]
pub enum Settings<'a> {
    /// A number that varies continuously.
    Numbers(&'a [f64]),
    /// One of several choices.
    Choices(&'a [usize]),
}

/// Part of the variance of the ranks of a result that follows a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankShare {
    /// The part, from 0 to 1, less that of chance.
    pub share: f64,
    /// Whether chance alone would give as much in less than 5 % of samples.
    pub significant: bool,
}

/// Ranks of values from 1; equal values have their mean rank.
pub fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    while first < order.len() {
        let equal = order[first..].iter().take_while(|index| values[**index] == values[order[first]]).count();
        // ranks first + 1 to first + equal
        let mean = first as f64 + (equal as f64 + 1.0) / 2.0;
        order[first..first + equal].iter().for_each(|index| ranks[*index] = mean);
        first += equal;
    }
    ranks
}

/// Share of a factor in the variance of the ranks of `values`: R² of their regression on the ranks of the factor's numbers, or on its
/// choices, less what chance alone would give,
///
/// ```text
/// 1 − (1 − R²) (n − 1)/(n − 1 − d),   d = 1 for numbers, the number of choices − 1 for choices,
/// ```
///
/// and not below 0. In a sample whose factors are uncorrelated, R² of numbers is the squared standardised rank regression
/// coefficient, and shares of factors without interaction add up to 1. It stands out if `F = (R²/d)/((1 − R²)/(n − 1 − d))` is above the
/// 95 % quantile of its distribution without influence. None if values or settings do not vary, or if there are too few.
///
/// **Source**: A. Saltelli, S. Tarantola, F. Campolongo, M. Ratto, *Sensitivity Analysis in Practice* (2004), section 5.5; for
/// choices W.L. Hays, *Statistics*, 5th edition (1994), Kelley's ε², on ranks.
pub fn rank_share(settings: Settings<'_>, values: &[f64]) -> Option<RankShare> {
    let of_values = ranks(values);
    let n = values.len() as f64;
    let mean = (n + 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let whole = product(&of_values, &of_values);
    let (explained, degrees) = match settings {
        Settings::Numbers(numbers) => {
            let of_numbers = ranks(numbers);
            let own = product(&of_numbers, &of_numbers);
            (product(&of_numbers, &of_values).powi(2) / own, if own > 0.0 { 1.0 } else { 0.0 })
        }
        Settings::Choices(choices) => {
            let mut groups: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
            for (choice, rank) in choices.iter().zip(&of_values) {
                let (count, sum) = groups.entry(*choice).or_default();
                (*count, *sum) = (*count + 1.0, *sum + rank - mean);
            }
            (groups.values().map(|(count, sum)| sum * sum / count).sum(), groups.len() as f64 - 1.0)
        }
    };
    let left = n - 1.0 - degrees;
    if whole <= 0.0 || degrees < 1.0 || left < 1.0 {
        return None;
    }
    let r2 = (explained / whole).min(1.0);
    let f = (r2 / degrees) / ((1.0 - r2) / left);
    let limit = FisherSnedecor::new(degrees, left).ok()?.inverse_cdf(1.0 - CHANCE);
    Some(RankShare { share: (1.0 - (1.0 - r2) * (n - 1.0) / left).max(0.0), significant: f > limit })
}

#[cfg(test)]
mod tests {
    use super::super::latin_hypercube;
    use super::*;

    #[test]
    fn equal_values_share_their_ranks() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0, 3.0]), [4.0, 1.0, 4.0, 2.0, 4.0]);
    }

    /// y = 3 a + 4 b + 5 c with a, b uniform and c one of two choices, all of variance 1: shares 9/50, 16/50, 25/50. Ranks change them
    /// by a few hundredths.
    #[test]
    fn factors_of_a_linear_function_have_their_shares_of_the_variance() {
        let points = latin_hypercube(4000, 4, 5);
        let column = |factor: usize| -> Vec<f64> { points.iter().map(|point| point[factor]).collect() };
        let choices: Vec<usize> = points.iter().map(|point| (2.0 * point[2]) as usize).collect();
        let of_unit_variance = |u: f64| 12f64.sqrt() * (u - 0.5);
        let values: Vec<f64> = points
            .iter()
            .zip(&choices)
            .map(|(p, c)| {
                3.0 * of_unit_variance(p[0]) + 4.0 * of_unit_variance(p[1]) + 10.0 * (*c as f64 - 0.5)
            })
            .collect();
        let share = |settings| rank_share(settings, &values).expect("values that vary");
        let (a, b, without) = (column(0), column(1), column(3));
        for (settings, expected) in [
            (Settings::Numbers(&a), 9.0 / 50.0),
            (Settings::Numbers(&b), 16.0 / 50.0),
            (Settings::Choices(&choices), 25.0 / 50.0),
        ] {
            let found = share(settings);
            assert!((found.share - expected).abs() < 0.03 && found.significant, "{found:?} for {expected}");
        }
        assert!(share(Settings::Numbers(&without)).share < 0.002);
        // Ranks make a monotonic function as good as a linear one.
        let cubes: Vec<f64> = a.iter().map(|u| (10.0 * u).exp()).collect();
        assert!((rank_share(Settings::Numbers(&a), &cubes).expect("values").share - 1.0).abs() < 1e-9);
    }

    #[test]
    fn noise_stands_out_as_rarely_as_is_said_and_explains_nothing_on_the_mean() {
        let mut random = fastrand::Rng::with_seed(5);
        let trials = 2000;
        let (mut standing_out, mut sum) = ([0, 0], [0.0, 0.0]);
        for _ in 0..trials {
            let values: Vec<f64> = (0..24).map(|_| random.f64()).collect();
            let numbers: Vec<f64> = (0..24).map(|_| random.f64()).collect();
            let choices: Vec<usize> = (0..24).map(|i| i / 8).collect();
            for (kind, settings) in
                [Settings::Numbers(&numbers), Settings::Choices(&choices)].into_iter().enumerate()
            {
                let found = rank_share(settings, &values).expect("values that vary");
                standing_out[kind] += usize::from(found.significant);
                sum[kind] += found.share;
            }
        }
        for (count, sum) in standing_out.into_iter().zip(sum) {
            // three standard deviations of the trials are 0.015
            assert!((f64::from(count as u32) / f64::from(trials) - 0.05).abs() < 0.015, "{count}");
            assert!(sum / f64::from(trials) < 0.04, "{sum}");
        }
    }

    #[test]
    fn what_does_not_vary_has_no_share() {
        assert_eq!(rank_share(Settings::Numbers(&[1.0, 2.0, 3.0, 4.0]), &[1.0; 4]), None);
        assert_eq!(rank_share(Settings::Numbers(&[1.0; 4]), &[1.0, 2.0, 3.0, 4.0]), None);
        assert_eq!(rank_share(Settings::Choices(&[0, 0, 0, 0]), &[1.0, 2.0, 3.0, 4.0]), None);
        assert_eq!(rank_share(Settings::Choices(&[0, 1, 2]), &[1.0, 2.0, 3.0]), None);
    }
}
