use super::quantiles::quantile;

/// Confidence of the interval of a ratio: both of its ends are tests at 5 %.
const CONFIDENCE: f64 = 0.9;

/// Comparison of the medians of two methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// Median of the second over that of the first.
    pub value: f64,
    /// Its 90 % interval.
    pub interval: [f64; 2],
    /// Probability of such medians if the ratio is outside 1 ± `margin`: the larger share of bootstrap samples beyond one of
    /// its ends.
    pub probability: f64,
}

/// Ratio of the medians of two methods on the same motions: `pairs` hold the cluster and both values of each. The
/// interval is from a bootstrap of whole clusters, with the same clusters for both methods; `None` without a pair, or if a median
/// is 0.
///
/// **Source**: B. Efron, R.J. Tibshirani, *An Introduction to the Bootstrap* (1993), section 13.3 (percentiles); D.J. Schuirmann, A
/// comparison of the two one-sided tests procedure and the power approach for assessing the equivalence of average bioavailability,
/// Journal of Pharmacokinetics and Biopharmaceutics 15 (1987).
pub fn ratio_of_medians(pairs: &[(usize, [f64; 2])], margin: f64, draws: usize, seed: u64) -> Option<Ratio> {
    let mut sorted = pairs.to_vec();
    sorted.sort_by_key(|(cluster, _)| *cluster);
    let clusters: Vec<&[(usize, [f64; 2])]> = sorted.chunk_by(|a, b| a.0 == b.0).collect();
    let ratio = |drawn: &mut dyn Iterator<Item = &[f64; 2]>| {
        let [mut first, mut second] = [Vec::new(), Vec::new()];
        for [a, b] in drawn {
            first.push(*a);
            second.push(*b);
        }
        let [below, above] = [&mut first, &mut second].map(|values| {
            values.sort_by(f64::total_cmp);
            quantile(values, 0.5)
        });
        above / below
    };
    let value = ratio(&mut pairs.iter().map(|(_, values)| values));
    if !value.is_finite() || value == 0.0 {
        return None;
    }
    let mut random = fastrand::Rng::with_seed(seed);
    let mut drawn: Vec<f64> = (0..draws)
        .map(|_| {
            let clusters = clusters.iter().map(|_| clusters[random.usize(0..clusters.len())]);
            let clusters: Vec<&[(usize, [f64; 2])]> = clusters.collect();
            ratio(&mut clusters.into_iter().flatten().map(|(_, values)| values))
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let beyond = |outside: &dyn Fn(f64) -> bool| {
        (drawn.iter().filter(|ratio| outside(**ratio)).count() + 1) as f64 / (draws + 1) as f64
    };
    let tail = (1.0 - CONFIDENCE) / 2.0;
    Some(Ratio {
        value,
        interval: [tail, 1.0 - tail].map(|share| quantile(&drawn, share)),
        probability: beyond(&|ratio| ratio <= 1.0 - margin).max(beyond(&|ratio| ratio >= 1.0 + margin)),
    })
}

/// Probabilities of several tests as those of a single one: the smallest times their number n, the next times n − 1, and
/// so on, none below the one before it.
///
/// **Source**: S. Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6 (1979).
pub fn holm(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]));
    let mut adjusted = vec![0.0; probabilities.len()];
    let mut least = 0.0f64;
    for (rank, index) in order.into_iter().enumerate() {
        least = least.max(probabilities[index] * (probabilities.len() - rank) as f64).min(1.0);
        adjusted[index] = least;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(count: usize, factor: f64, noise: f64, random: &mut fastrand::Rng) -> Vec<(usize, [f64; 2])> {
        let mut value = |scale: f64| scale * (1.0 + noise * (random.f64() - 0.5));
        (0..count).map(|cluster| (cluster, [value(100.0), value(factor * 100.0)])).collect()
    }

    #[test]
    fn equal_methods_are_found_equal_and_others_are_not() {
        let mut random = fastrand::Rng::with_seed(3);
        let equal = ratio_of_medians(&pairs(64, 1.02, 0.3, &mut random), 0.1, 1000, 1).expect("a ratio");
        assert!(
            equal.probability < 0.01 && equal.interval[0] < 1.02 && 1.02 < equal.interval[1],
            "{equal:?}"
        );
        let other = ratio_of_medians(&pairs(64, 1.3, 0.3, &mut random), 0.1, 1000, 1).expect("a ratio");
        assert!(other.probability > 0.9 && other.interval[0] > 1.1, "{other:?}");
        // Too few to tell.
        let few = ratio_of_medians(&pairs(4, 1.0, 1.5, &mut random), 0.1, 1000, 1).expect("a ratio");
        assert!(few.probability > 0.05, "{few:?}");
        assert_eq!(ratio_of_medians(&[], 0.1, 10, 1), None);
        assert_eq!(ratio_of_medians(&[(0, [0.0, 1.0])], 0.1, 10, 1), None);
    }

    /// The interval holds the truth in nine of ten studies.
    #[test]
    fn intervals_of_the_ratio_hold_it_as_often_as_they_say() {
        let mut random = fastrand::Rng::with_seed(8);
        let held = (0..400).filter(|study| {
            let found = ratio_of_medians(&pairs(64, 1.05, 0.5, &mut random), 0.1, 200, *study);
            found.is_some_and(|Ratio { interval: [low, high], .. }| low <= 1.05 && 1.05 <= high)
        });
        let share = held.count() as f64 / 400.0;
        assert!((0.86..0.95).contains(&share), "{share}");
    }

    #[test]
    fn several_tests_count_as_one() {
        assert_eq!(holm(&[0.01, 0.04, 0.03]), [0.03, 0.06, 0.06]);
        assert_eq!(holm(&[0.5, 0.6]), [1.0, 1.0]);
        assert!(holm(&[]).is_empty());
    }
}
