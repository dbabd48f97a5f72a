use statrs::function::beta::beta_reg;

/// Steps of the bisection: below the last digit of a probability.
const STEPS: usize = 60;

/// Exact interval of a probability from `successes` in `trials` independent trials (Clopper–Pearson): the ends p at which
/// so many or more, or so few or fewer, have the probability `(1 − confidence)/2`,
///
/// ```text
/// I_p(k, n − k + 1) = (1 − confidence)/2   below,   I_p(k + 1, n − k) = (1 + confidence)/2   above
/// ```
///
/// with the regularised incomplete beta function I. Its coverage is at least `confidence` for every probability, and more for most:
/// the counts are discrete. From 0 to 1 without trials.
///
/// **Source**: C.J. Clopper, E.S. Pearson, The use of confidence or fiducial limits illustrated in the case of the binomial, Biometrika 26
/// (1934).
pub fn clopper_pearson(successes: usize, trials: usize, confidence: f64) -> [f64; 2] {
    let tail = (1.0 - confidence) / 2.0;
    let (k, n) = (successes.min(trials) as f64, trials as f64);
    let low = if successes == 0 { 0.0 } else { root(|p| beta_reg(k, n - k + 1.0, p) - tail) };
    let high = if successes >= trials { 1.0 } else { root(|p| beta_reg(k + 1.0, n - k, p) - 1.0 + tail) };
    [low, high]
}

/// The interval of the mean of `clusters` independent shares between 0 and 1 whose sum is `sum`: that of [`clopper_pearson`] with the clusters
/// as trials, the sum rounded down for the lower end and up for the upper one.
///
/// Of runs that come in clusters, such as both polarities of a record, only the clusters are independent. The share of a cluster varies
/// less than a trial that is 0 or 1, so that the interval is exact if all runs of a cluster agree, and conservative otherwise.
pub fn clustered(sum: f64, clusters: usize, confidence: f64) -> [f64; 2] {
    // Shares such as 1/3 + 2/3 add up to whole numbers but for their last digits.
    const ROUNDING: f64 = 1e-9;
    let low = clopper_pearson((sum + ROUNDING).floor() as usize, clusters, confidence)[0];
    let high = clopper_pearson((sum - ROUNDING).ceil().max(0.0) as usize, clusters, confidence)[1];
    [low, high]
}

/// The smallest number of independent trials whose [`clopper_pearson`] interval is no wider than `width`, whatever their outcome.
pub fn trials_for_width(width: f64, confidence: f64) -> usize {
    let widest = |trials: usize| {
        let [low, high] = clopper_pearson(trials / 2, trials, confidence);
        high - low
    };
    let mut trials = 1;
    while widest(trials) > width && trials < 100_000 {
        trials += 1;
    }
    trials
}

/// The root of a rising function between 0 and 1.
fn root(of: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..STEPS {
        let middle = (low + high) / 2.0;
        *(if of(middle) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{Binomial, Discrete};

    /// Tables of the 95 % interval; 0 of n: 1 − 0.025^(1/n).
    #[test]
    fn intervals_are_those_of_published_tables() {
        for (successes, trials, wanted) in [
            (1, 8, [0.00316, 0.52651]),
            (2, 8, [0.03185, 0.65086]),
            (0, 4, [0.0, 1.0 - 0.025f64.powf(0.25)]),
            (5, 10, [0.18709, 0.81291]),
            (10, 10, [0.69150, 1.0]),
            (0, 0, [0.0, 1.0]),
        ] {
            let found = clopper_pearson(successes, trials, 0.95);
            let error = (found[0] - wanted[0]).abs().max((found[1] - wanted[1]).abs());
            assert!(error < 1e-5, "{successes} of {trials}: {found:?}");
        }
    }

    #[test]
    fn the_width_of_so_many_trials_is_below_the_stated_one() {
        let trials = trials_for_width(0.3, 0.95);
        let widest = |trials: usize| {
            let widths = (0..=trials).map(|successes| {
                let [low, high] = clopper_pearson(successes, trials, 0.95);
                high - low
            });
            widths.fold(0.0, f64::max)
        };
        assert!(widest(trials) <= 0.3 && widest(trials - 1) > 0.3, "{trials}");
    }

    /// Coverage, exactly: clusters of two runs that agree more or less often. The sum of the shares has half-integer steps; its
    /// distribution is that of a trinomial.
    #[test]
    fn clusters_of_two_runs_are_covered_whatever_their_correlation() {
        for clusters in [4, 6, 12, 22] {
            let intervals: Vec<[f64; 2]> =
                (0..=2 * clusters).map(|twice| clustered(twice as f64 / 2.0, clusters, 0.95)).collect();
            for correlation in [0.0, 0.25, 0.5, 0.75, 1.0] {
                for p in (1..100).map(|percent| f64::from(percent) / 100.0) {
                    // Of a cluster: both exceed, and only one of both.
                    let both = p * p + correlation * p * (1.0 - p);
                    let one = (2.0 * (p - both)).clamp(0.0, 1.0);
                    let probability = |twice: usize| -> f64 {
                        // so many clusters with one, the rest of the sum with both
                        let ways =
                            (0..=clusters).filter(|ones| *ones <= twice && (twice - ones).is_multiple_of(2));
                        ways.map(|ones| {
                            let of_both = ((twice - ones) / 2) as u64;
                            let others = (clusters - ones) as u64;
                            if of_both > others {
                                return 0.0;
                            }
                            let ones_of = Binomial::new(one, clusters as u64).expect("a share");
                            let share = if one < 1.0 { (both / (1.0 - one)).clamp(0.0, 1.0) } else { 0.0 };
                            let both_of = Binomial::new(share, others).expect("a share");
                            ones_of.pmf(ones as u64) * both_of.pmf(of_both)
                        })
                        .sum()
                    };
                    let covered: f64 = (0..=2 * clusters)
                        .filter(|twice| intervals[*twice][0] <= p && p <= intervals[*twice][1])
                        .map(probability)
                        .sum();
                    assert!(covered >= 0.95 - 1e-9, "{clusters} {correlation} {p}: {covered}");
                }
            }
        }
    }

    /// Twelve runs of four records say no more than four.
    #[test]
    fn runs_of_the_same_record_do_not_narrow_the_interval() {
        assert_eq!(clustered(2.0, 4, 0.95), clopper_pearson(2, 4, 0.95));
        let [low, high] = clustered(1.0 / 3.0 + 2.0 / 3.0, 4, 0.95);
        assert_eq!([low, high], clopper_pearson(1, 4, 0.95));
        assert_eq!(clustered(0.5, 4, 0.95), [0.0, clopper_pearson(1, 4, 0.95)[1]]);
    }
}
