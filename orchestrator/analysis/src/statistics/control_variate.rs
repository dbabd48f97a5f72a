use super::quantiles::quantile;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Predicted saving from which the control is used.
pub const LEAST_SAVING: f64 = 1.2;
/// Clusters with dear runs from which the control is used: four for each coefficient.
pub const LEAST_CLUSTERS: usize = 8;
/// Shares of the runs that are told.
const SHARES: [f64; 3] = [0.16, 0.5, 0.84];

/// A motion at one level of shaking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Which motions belong together and are drawn together, such as those of one record.
    pub cluster: usize,
    /// Value by the cheap model; NaN where its run has none.
    pub cheap: f64,
    /// Value by the dear model, where it was run; NaN where its run has none.
    pub dear: Option<f64>,
}

/// What cheap and dear runs say together.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Motions with both values, n.
    pub pairs: usize,
    /// Clusters that have such.
    pub clusters: usize,
    /// Motions with a cheap value, N.
    pub motions: usize,
    /// Correlation ρ of the indicators at the medians of the pairs, a little low where they are few; 0 where one does not vary.
    pub correlation: f64,
    /// Coefficient β at the median, mean of both halves.
    pub coefficient: f64,
    /// [Saving](predicted_saving) at the best N/n.
    pub predicted: f64,
    /// That N/n.
    pub best_ratio: f64,
    /// [Saving] of the n and N that were run.
    ///
    /// [Saving]: saving()
    pub saving: f64,
    /// Median of the cheap runs.
    pub cheap: f64,
    /// From the dear runs alone.
    pub plain: Spread,
    /// With the control, or why not.
    pub controlled: Result<Spread, Declined>,
}

impl Control {
    /// What is to be quoted: with the control, else the plain estimate.
    pub fn best(&self) -> &Spread {
        self.controlled.as_ref().unwrap_or(&self.plain)
    }
}

/// Quantiles of the dear model.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// 16, 50 and 84 %.
    pub quantiles: [f64; 3],
    /// Interval of the median; none from too few values.
    pub interval: Option<[f64; 2]>,
}

/// Why the control is not used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Declined {
    /// No coefficient can be had from so few.
    #[error(
        "{clusters} records or pairs of records have dear runs, {LEAST_CLUSTERS} are needed; add records, or raise `dear.share`"
    )]
    TooFew {
        /// Clusters with dear runs.
        clusters: usize,
    },
    /// Dear runs alone are nearly as good.
    #[error(
        "it would save {predicted:.2} times, less than {LEAST_SAVING}: correlation {correlation:.2}, a dear run costs {cost} cheap ones"
    )]
    DoesNotPay {
        /// Saving at the best N/n.
        predicted: f64,
        /// Of the indicators at the median.
        correlation: f64,
        /// Cost of a dear run over that of a cheap one.
        cost: f64,
    },
}

/// How many times less the same variance costs with the control than by dear runs alone, with the best N/n, and that N/n: with the
/// `correlation` ρ of the indicators and a dear run that costs as much as `cost` cheap ones, c = 1/cost,
///
/// ```text
/// saving = 1/(√(1 − ρ²) + √(c ρ²))²,   N/n = √(ρ²/(c (1 − ρ²)))
/// ```
///
/// where that N is above n and the saving above 1; else 1, and 1: the control only costs.
///
/// **Source**: B. Peherstorfer, K. Willcox, M. Gunzburger, Optimal model management for multifidelity Monte Carlo estimation, SIAM
/// Journal on Scientific Computing 38 (2016), section 3, with two models.
pub fn predicted_saving(correlation: f64, cost: f64) -> (f64, f64) {
    let (square, c) = (correlation * correlation, 1.0 / cost);
    let ratio = (square / (c * (1.0 - square))).sqrt();
    let saving = ((1.0 - square).sqrt() + (c * square).sqrt()).powi(-2);
    if ratio > 1.0 && saving > 1.0 { (saving, ratio) } else { (1.0, 1.0) }
}

/// The same with `pairs`, n, and `motions`, N, as they are: `1/((n + c N) ((1 − ρ²)/n + ρ²/N))`.
pub fn saving(correlation: f64, cost: f64, pairs: usize, motions: usize) -> f64 {
    let (square, n, all) = (correlation * correlation, pairs as f64, motions as f64);
    1.0 / ((n + all / cost) * ((1.0 - square) / n + square / all))
}

/// Distribution of a quantity by the dear model from few dear runs and many cheap ones of the same motions, by a control variate on
/// the indicator,
///
/// ```text
/// F(x) = mean_n 1{D ≤ x} − β(x) (mean_n 1{C ≤ x'} − mean_N 1{C ≤ x'}),   β = cov(1{D ≤ x}, 1{C ≤ x'})/var(1{C ≤ x'})
/// ```
///
/// inverted to its quantiles. D and C are values by the dear and by the cheap model.
///
/// **The cheap model's x'** is that of the same rank among pairs, linear between them, not x itself: a cheap model that is wrong by
/// a factor, or by any other rising function, is as good a control as one that is right. Indicators of probabilities p < q correlate by at most
/// `√(p (1 − q)/(q (1 − p)))` (Fréchet), 1 only at equal ones.
///
/// **Coefficients of their own samples**: the clusters with dear runs are halved, and β and x' of each half serve the other one. So
/// they are independent of what they multiply, and F is unbiased. For that the cheap mean of a half leaves out the cheap runs of the
/// other half; its own count twice, so that F is the formula above where both halves have the same β and x'. β is kept from 0 to 1, where that
/// of indicators of equal probability lies unless the models disagree.
///
/// **Inversion**: F need not rise; its values are sorted (rearranged). Between dear values it is taken so that without a control its quantiles
/// are those of [`quantile`]. A quantile of an unbiased F has a bias O(1/n), as that of a sample has.
///
/// **Interval** of the median: `F⁻¹(½ ± t s)` with the standard error s of F at the median from `draws` of whole clusters, and
/// Student's t for the clusters with dear runs.
///
/// Motions without a cheap value are left out. The control is declined below [`LEAST_CLUSTERS`] and a predicted saving of 1.2.
///
/// **Source**: P.W. Glynn, R. Szechtman, Some new perspectives on the method of control variates, Monte Carlo and Quasi-Monte
/// Carlo Methods 2000 (2002); T.C. Hesterberg, B.L. Nelson, Control variates for probability and quantile estimation, Management
/// Science 44 (1998); A.N. Avramidis, J.R. Wilson, A splitting scheme for control variates, Operations Research Letters 14 (1993); V.
/// Chernozhukov, I. Fernández-Val, A. Galichon, Quantile and probability curves without crossing, Econometrica 78 (2010)
/// (rearrangement); R.S. Woodruff, Confidence intervals for medians and other position measures, Journal of the American Statistical
/// Association 47 (1952).
pub fn control(motions: &[Motion], cost: f64, confidence: f64, draws: usize, seed: u64) -> Control {
    let clusters = clusters(motions);
    let all: Vec<&Cluster> = clusters.iter().collect();
    let sample = Sample::of(&all);
    let with_pairs = clusters.iter().filter(|cluster| cluster.half.is_some()).count();
    let mut cheap: Vec<f64> = clusters.iter().flat_map(|cluster| cluster.cheap.iter().copied()).collect();
    cheap.sort_by(f64::total_cmp);
    let correlation = sample.correlation();
    let (predicted, best_ratio) = predicted_saving(correlation, cost);
    let spread = |controlled: bool| {
        let inverse = sample.inverse(controlled);
        let quantiles = SHARES.map(|share| inverse.at(share));
        let interval = interval(&clusters, &inverse, controlled, confidence, draws, seed);
        Spread { quantiles, interval }
    };
    let declined = if with_pairs < LEAST_CLUSTERS {
        Some(Declined::TooFew { clusters: with_pairs })
    } else if predicted < LEAST_SAVING {
        Some(Declined::DoesNotPay { predicted, correlation, cost })
    } else {
        None
    };
    let plain = spread(false);
    Control {
        pairs: sample.dear.len(),
        clusters: with_pairs,
        motions: cheap.len(),
        correlation,
        coefficient: sample.coefficient(plain.quantiles[1]),
        predicted,
        best_ratio,
        saving: saving(correlation, cost, sample.dear.len(), cheap.len()),
        cheap: quantile(&cheap, 0.5),
        controlled: declined.map_or_else(|| Ok(spread(true)), Err),
        plain,
    }
}

/// The motions that are drawn together.
#[derive(Debug)]
struct Cluster {
    /// Which half its pairs are in; none without pairs.
    half: Option<usize>,
    /// Cheap values of all.
    cheap: Vec<f64>,
    /// Dear and cheap values of those that have both.
    pairs: Vec<[f64; 2]>,
}

/// The motions with a cheap value by cluster. Those with pairs are in both halves by turns.
fn clusters(motions: &[Motion]) -> Vec<Cluster> {
    let mut sorted: Vec<&Motion> = motions.iter().filter(|motion| motion.cheap.is_finite()).collect();
    sorted.sort_by_key(|motion| motion.cluster);
    let mut clusters: Vec<Cluster> = Vec::new();
    let mut with_pairs = 0;
    for of_cluster in sorted.chunk_by(|a, b| a.cluster == b.cluster) {
        let of_both = of_cluster.iter().filter_map(|motion| Some([motion.dear?, motion.cheap]));
        let pairs: Vec<[f64; 2]> = of_both.filter(|[dear, _]| dear.is_finite()).collect();
        let half = (!pairs.is_empty()).then_some(with_pairs % 2);
        with_pairs += usize::from(half.is_some());
        clusters.push(Cluster { half, cheap: of_cluster.iter().map(|motion| motion.cheap).collect(), pairs });
    }
    clusters
}

/// Half of the clusters with pairs.
#[derive(Debug, Default)]
struct Half {
    /// Dear and cheap values of the pairs, and each in ascending order.
    pairs: Vec<[f64; 2]>,
    dear: Vec<f64>,
    cheap: Vec<f64>,
    /// Cheap values of all its motions, in any order: a bootstrap asks each sample once.
    all: Vec<f64>,
}

/// How many of the values in ascending order are `bound` at most.
fn up_to(ascending: &[f64], bound: f64) -> f64 {
    ascending.partition_point(|value| *value <= bound) as f64
}

impl Half {
    /// The control at x: the cheap model's x' and β; none beyond the dear values, or without a correlation.
    fn control(&self, x: f64) -> Option<(f64, f64)> {
        let rank = self.dear.partition_point(|value| *value <= x);
        let (below, above) = (rank.checked_sub(1)?, rank);
        let (from, to) = (self.dear[below], *self.dear.get(above)?);
        let share = (x - from) / (to - from);
        let bound = self.cheap[below] + share * (self.cheap[above] - self.cheap[below]);
        let n = self.dear.len() as f64;
        let both = self.pairs.iter().filter(|[dear, cheap]| *dear <= x && *cheap <= bound).count() as f64;
        let cheap = up_to(&self.cheap, bound);
        let covariance = both / n - rank as f64 / n * (cheap / n);
        let variance = cheap / n * (1.0 - cheap / n);
        let coefficient = (covariance / variance).min(1.0);
        (coefficient > 0.0).then_some((bound, coefficient))
    }
}

/// Motions, ready for the distribution.
#[derive(Debug)]
struct Sample {
    halves: [Half; 2],
    /// Cheap values of clusters without pairs, in any order.
    rest: Vec<f64>,
    /// Dear values of the pairs, ascending.
    dear: Vec<f64>,
}

impl Sample {
    fn of(clusters: &[&Cluster]) -> Self {
        let mut sample =
            Self { halves: [Half::default(), Half::default()], rest: Vec::new(), dear: Vec::new() };
        for cluster in clusters {
            match cluster.half {
                Some(half) => {
                    let half = &mut sample.halves[half];
                    half.pairs.extend(&cluster.pairs);
                    half.all.extend(&cluster.cheap);
                }
                None => sample.rest.extend(&cluster.cheap),
            }
        }
        for half in &mut sample.halves {
            half.dear = half.pairs.iter().map(|pair| pair[0]).collect();
            half.cheap = half.pairs.iter().map(|pair| pair[1]).collect();
            half.dear.sort_by(f64::total_cmp);
            half.cheap.sort_by(f64::total_cmp);
            sample.dear.extend(&half.dear);
        }
        sample.dear.sort_by(f64::total_cmp);
        sample
    }

    /// What the control adds to the distribution function of the pairs at x.
    fn correction(&self, x: f64) -> f64 {
        let [first, second] = &self.halves;
        let n = self.dear.len() as f64;
        let of = |half: &Half, other: &Half| {
            let of_half = half.dear.len() as f64;
            let Some((bound, coefficient)) = other.control(x).filter(|_| of_half > 0.0) else { return 0.0 };
            let weight = n / of_half;
            let among = |values: &[f64]| values.iter().filter(|value| **value <= bound).count() as f64;
            let count = weight * among(&half.all) + among(&self.rest);
            let mean = count / (weight * half.all.len() as f64 + self.rest.len() as f64);
            -coefficient / weight * (up_to(&half.cheap, bound) / of_half - mean)
        };
        of(first, second) + of(second, first)
    }

    /// The distribution function at x.
    fn distribution(&self, x: f64, controlled: bool) -> f64 {
        up_to(&self.dear, x) / self.dear.len() as f64 + if controlled { self.correction(x) } else { 0.0 }
    }

    /// Mean coefficient of both halves at x.
    fn coefficient(&self, x: f64) -> f64 {
        let of = |half: &Half| half.control(x).map_or(0.0, |(_, coefficient)| coefficient);
        self.halves.iter().map(of).sum::<f64>() / 2.0
    }

    /// Correlation of the indicators at the medians, where it is positive: φ of the four counts of pairs, a quarter of a pair added to each. Without
    /// it, few pairs without a disagreement would promise a perfect control (Jeffreys: half a disagreement of n + 1).
    fn correlation(&self) -> f64 {
        let pairs = || self.halves.iter().flat_map(|half| &half.pairs);
        let mut cheap: Vec<f64> = pairs().map(|pair| pair[1]).collect();
        cheap.sort_by(f64::total_cmp);
        let n = self.dear.len();
        let middle = n.div_ceil(2).max(1) - 1;
        let (Some(x), Some(bound)) = (self.dear.get(middle), cheap.get(middle)) else { return 0.0 };
        let mut counts = [[0.25_f64; 2]; 2];
        for [dear, cheap] in pairs() {
            counts[usize::from(dear <= x)][usize::from(cheap <= bound)] += 1.0;
        }
        if up_to(&self.dear, *x) == n as f64 || up_to(&cheap, *bound) == n as f64 {
            return 0.0;
        }
        let [[above, a], [b, below]] = counts;
        let margins = (above + a) * (b + below) * (above + b) * (a + below);
        ((above * below - a * b) / margins.sqrt()).max(0.0)
    }

    /// The distribution function the other way round.
    fn inverse(&self, controlled: bool) -> Inverse {
        let n = self.dear.len();
        if !controlled {
            return Inverse { shares: Vec::new(), values: self.dear.clone() };
        }
        let stretched = n as f64 / (n as f64 - 1.0);
        let middles = self.dear.windows(2).map(|pair| pair[0] + 0.5 * (pair[1] - pair[0]));
        let between: Vec<f64> = middles.map(|x| self.correction(x)).collect();
        let beside = |index: usize| between.get(index).copied().unwrap_or(0.0);
        let mut shares: Vec<f64> = (0..n)
            .map(|index| {
                let below = index.checked_sub(1).map_or(0.0, beside);
                index as f64 / (n as f64 - 1.0) + stretched * 0.5 * (below + beside(index))
            })
            .collect();
        shares.sort_by(f64::total_cmp);
        Inverse { shares, values: self.dear.clone() }
    }
}

/// Values and the shares of the distribution that lie below them, both ascending; without shares, each value has the same.
#[derive(Debug)]
struct Inverse {
    shares: Vec<f64>,
    values: Vec<f64>,
}

impl Inverse {
    /// The value at `share`, linear between values; the outermost ones beyond them, NaN without any.
    fn at(&self, share: f64) -> f64 {
        if self.shares.is_empty() {
            return quantile(&self.values, share);
        }
        let above = self.shares.partition_point(|other| *other < share);
        let at = |index: usize| (self.shares[index], self.values[index]);
        let Some(last) = self.values.len().checked_sub(1) else { return f64::NAN };
        if above == 0 || above > last {
            return self.values[above.min(last)];
        }
        let ((from, low), (to, high)) = (at(above - 1), at(above));
        low + (share - from) / (to - from) * (high - low)
    }
}

/// Interval of the median.
fn interval(
    clusters: &[Cluster],
    inverse: &Inverse,
    controlled: bool,
    confidence: f64,
    draws: usize,
    seed: u64,
) -> Option<[f64; 2]> {
    let with_pairs = clusters.iter().filter(|cluster| cluster.half.is_some()).count();
    let student = StudentsT::new(0.0, 1.0, with_pairs.checked_sub(1)? as f64).ok()?;
    let error = standard_error(clusters, inverse.at(0.5), controlled, draws, seed);
    let reach = student.inverse_cdf(0.5 + confidence / 2.0) * error;
    // Beyond the values nothing is known.
    (reach < 0.5).then(|| [0.5 - reach, 0.5 + reach].map(|share| inverse.at(share)))
}

/// Standard error of the distribution function at x by a bootstrap of whole clusters, which keep their halves.
fn standard_error(clusters: &[Cluster], x: f64, controlled: bool, draws: usize, seed: u64) -> f64 {
    let mut random = fastrand::Rng::with_seed(seed);
    let drawn = (0..draws).map(|_| {
        let drawn: Vec<&Cluster> =
            clusters.iter().map(|_| &clusters[random.usize(0..clusters.len())]).collect();
        Sample::of(&drawn).distribution(x, controlled)
    });
    // A draw without pairs has none.
    let drawn: Vec<f64> = drawn.filter(|value| value.is_finite()).collect();
    let count = drawn.len() as f64;
    let mean = drawn.iter().sum::<f64>() / count;
    (drawn.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn gauss(random: &mut fastrand::Rng) -> f64 {
        (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (TAU * random.f64()).cos()
    }

    /// Motions of which the first n are dear, too: lognormal with median 100 and dispersion 1, the cheap value a fourth of it and with
    /// another dispersion, so that neither values nor quantiles agree. Indicators at the medians correlate by ρ = 2/π asin r, r that of
    /// the logarithms (Sheppard 1899).
    fn motions(n: usize, all: usize, correlation: f64, random: &mut fastrand::Rng) -> Vec<Motion> {
        let r = (correlation * PI / 2.0).sin();
        (0..all)
            .map(|cluster| {
                let a = gauss(random);
                let b = r * a + (1.0 - r * r).sqrt() * gauss(random);
                let dear = (cluster < n).then(|| 100.0 * b.exp());
                Motion { cluster, cheap: 25.0 * (0.7 * a).exp(), dear }
            })
            .collect()
    }

    fn sample(motions: &[Motion]) -> Sample {
        Sample::of(&clusters(motions).iter().collect::<Vec<_>>())
    }

    /// Mean and standard error.
    fn mean(values: &[f64]) -> (f64, f64) {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (mean, (square / count).sqrt())
    }

    /// 1.84 and 1.09 times, as by hand, and the best of all N/n that can be tried.
    #[test]
    fn the_predicted_saving_is_the_best_of_all_allocations() {
        for (correlation, cost, wanted) in [(0.95, 5.0, 1.8405), (0.8, 5.0, 1.0901), (0.95, 30.0, 4.2391)] {
            let (predicted, ratio) = predicted_saving(correlation, cost);
            assert!((predicted - wanted).abs() < 1e-4, "{predicted} {wanted}");
            let tried =
                (100..5000).map(|all| (saving(correlation, cost, 100, all), f64::from(all as u32) / 100.0));
            let best = tried.max_by(|a, b| a.0.total_cmp(&b.0)).expect("some");
            assert!((best.0 - predicted).abs() < 1e-4 && (best.1 - ratio).abs() < 0.02, "{best:?} {ratio}");
        }
        // Nothing is to be gained, and less than nothing is not predicted.
        assert_eq!(predicted_saving(0.0, 5.0), (1.0, 1.0));
        assert_eq!(predicted_saving(0.3, 5.0), (1.0, 1.0));
        assert_eq!(predicted_saving(0.5, 5.0), (1.0, 1.0));
        assert!((predicted_saving(1.0, 5.0).0 - 5.0).abs() < 1e-12);
    }

    /// F is the truth on the mean, at any x, from as few as eight pairs: with coefficients of the pairs that they serve it is not.
    #[test]
    fn the_distribution_function_is_unbiased() {
        let mut random = fastrand::Rng::with_seed(1);
        let samples: Vec<Sample> = (0..20_000).map(|_| sample(&motions(8, 24, 0.8, &mut random))).collect();
        for (z, share) in [(-1.0, 0.15866), (-0.5, 0.30854), (0.0, 0.5), (1.0, 0.84134)] {
            let x = 100.0 * f64::exp(z);
            let errors: Vec<f64> =
                samples.iter().map(|sample| sample.distribution(x, true) - share).collect();
            let (mean, error) = mean(&errors);
            assert!(mean.abs() < 3.5 * error, "at {x}: {mean} ± {error}");
            println!("F at {share}: bias {mean:.5} ± {error:.5}");
        }
    }

    /// Both directions of a record, of which one is dear: not independent, and F is the truth on the mean still, with the standard error of a
    /// bootstrap of records.
    #[test]
    fn dependent_motions_change_nothing() {
        let mut random = fastrand::Rng::with_seed(10);
        let (mut errors, mut squares) = (Vec::new(), Vec::new());
        for study in 0..6000 {
            let mut motions = Vec::new();
            for cluster in 0..16 {
                let of_record = 0.8 * gauss(&mut random);
                for direction in 0..2 {
                    let a = of_record + 0.6 * gauss(&mut random);
                    let dear = 100.0 * (a + 0.3 * gauss(&mut random)).exp();
                    motions.push(Motion { cluster, cheap: a, dear: (direction == 0).then_some(dear) });
                }
            }
            errors.push(sample(&motions).distribution(100.0, true) - 0.5);
            if study % 40 == 0 {
                squares.push(standard_error(&clusters(&motions), 100.0, true, 50, study).powi(2));
            }
        }
        let (mean_error, of_mean) = mean(&errors);
        let (deviation, error) = (of_mean * (errors.len() as f64).sqrt(), mean(&squares).0.sqrt());
        println!("bias {mean_error:.5} ± {of_mean:.5}; standard error {error:.4}, deviation {deviation:.4}");
        assert!(mean_error.abs() < 3.5 * of_mean, "{mean_error} ± {of_mean}");
        assert!((0.84..1.3).contains(&(error / deviation)), "{error} {deviation}");
    }

    /// n times the relative bias of the median is `π/4 (1 − ρ² (1 − n/N))` for a dispersion of 1: −F″ var F/(2 F′³) with
    /// var F = ¼ (1 − ρ² (1 − n/N))/n.
    /// What is linear in F, unbiased, is taken off each median, so that few studies show it.
    #[test]
    fn the_bias_of_the_median_falls_with_the_number_of_pairs() {
        let mut random = fastrand::Rng::with_seed(2);
        let theory = PI / 4.0 * (1.0 - 0.8 * 0.8 * 0.8);
        for (n, studies) in [(8, 4000), (16, 3000), (32, 2000), (64, 1500)] {
            let errors: Vec<f64> = (0..studies)
                .map(|_| {
                    let sample = sample(&motions(n, 5 * n, 0.8, &mut random));
                    let linear = (sample.distribution(100.0, true) - 0.5) * TAU.sqrt();
                    sample.inverse(true).at(0.5) / 100.0 - 1.0 + linear
                })
                .collect();
            let (bias, error) = mean(&errors);
            let [bias, error] = [bias, error].map(|value| value * n as f64);
            println!("{n} pairs: n times the bias {bias:.3} ± {error:.3}, theory {theory:.3}");
            // Terms of the next order beside three and a half standard errors.
            assert!((bias - theory).abs() < 3.5 * error + 0.6 / n as f64, "{n}: {bias} ± {error}, {theory}");
            assert!(3.5 * error < theory, "{n}: too few studies to tell");
        }
    }

    /// The variance of F with the control over that without is `1 − ρ² (1 − n/N)`.
    #[test]
    fn the_variance_is_that_of_the_theory() {
        let mut random = fastrand::Rng::with_seed(3);
        let studies = 1500;
        for correlation in [0.95, 0.8, 0.5] {
            let values: Vec<[f64; 3]> = (0..studies)
                .map(|_| {
                    let sample = sample(&motions(64, 320, correlation, &mut random));
                    let [plain, controlled] =
                        [false, true].map(|controlled| sample.distribution(100.0, controlled));
                    [plain, controlled, sample.correlation()]
                })
                .collect();
            let said = values.iter().map(|value| value[2]).sum::<f64>() / f64::from(studies);
            println!("correlation {correlation}: {said:.3} from 64 pairs");
            // Half a disagreement of 65, and what medians of the sample add.
            assert!((said - correlation).abs() < 0.03, "{said} {correlation}");
            let [plain, controlled] = [0, 1]
                .map(|which| mean(&values.iter().map(|value| value[which]).collect::<Vec<_>>()).1.powi(2));
            let (found, theory) = (controlled / plain, 1.0 - correlation * correlation * 0.8);
            println!("correlation {correlation}: variance {found:.3} of the plain one, theory {theory:.3}");
            // Four standard errors of a ratio of independent variances; coefficients from 32 pairs add 1/32.
            let allowed = 4.0 * (4.0 / f64::from(studies)).sqrt() * theory + theory / 32.0;
            assert!((found - theory).abs() < allowed, "{found} {theory}");
            // As many times less dear runs as the saving says would give the same variance.
            let of_runs = 1.0 / (found * (1.0 + 5.0 / 5.0));
            assert!((of_runs / saving(correlation, 5.0, 64, 320) - 1.0).abs() < allowed / theory);
        }
    }

    #[test]
    fn a_useless_cheap_model_is_declined_and_costs_nothing() {
        let mut random = fastrand::Rng::with_seed(4);
        for study in 0..20 {
            let motions = motions(32, 160, 0.0, &mut random);
            let found = control(&motions, 5.0, 0.95, 100, study);
            assert!(matches!(found.controlled, Err(Declined::DoesNotPay { .. })), "{found:?}");
            let mut dear: Vec<f64> = motions.iter().filter_map(|motion| motion.dear).collect();
            dear.sort_by(f64::total_cmp);
            assert_eq!(found.best().quantiles, SHARES.map(|share| quantile(&dear, share)));
        }
        let said = Declined::DoesNotPay { predicted: 1.0901, correlation: 0.8, cost: 5.0 }.to_string();
        assert_eq!(
            said,
            "it would save 1.09 times, less than 1.2: correlation 0.80, a dear run costs 5 cheap ones"
        );
    }

    /// A cheap model that is right but for a factor and an offset, with each motion: quantiles are nearly those of all motions, of which few are
    /// dear. Compared at the same value it would say nothing: no cheap value is as large as a dear one.
    #[test]
    fn a_cheap_model_that_is_wrong_by_a_factor_is_as_good() {
        let mut random = fastrand::Rng::with_seed(5);
        let errors: Vec<[f64; 2]> = (0..200)
            .map(|seed| {
                let all: Vec<f64> = (0..200).map(|_| 100.0 * (0.5 * gauss(&mut random)).exp()).collect();
                let motions = all.iter().enumerate().map(|(cluster, value)| Motion {
                    cluster,
                    cheap: -1000.0 + 0.1 * value,
                    dear: (cluster < 20).then_some(*value),
                });
                let found = control(&motions.collect::<Vec<_>>(), 20.0, 0.95, 2, seed);
                assert!(
                    (found.correlation - (1.0 - 1.0 / 21.0)).abs() < 1e-12 && found.coefficient > 0.999,
                    "{found:?}"
                );
                let mut all = all;
                all.sort_by(f64::total_cmp);
                let of_all = quantile(&all, 0.5);
                [found.plain.quantiles[1], found.best().quantiles[1]]
                    .map(|median| (median / of_all).ln().powi(2))
            })
            .collect();
        let [plain, controlled] = [0, 1].map(|which| errors.iter().map(|e| e[which]).sum::<f64>());
        assert!(controlled < 0.1 * plain, "{controlled} {plain}");
    }

    #[test]
    fn ties_failed_runs_and_too_few_are_no_trouble() {
        let motion = |cluster: usize, cheap: f64, dear: f64| Motion { cluster, cheap, dear: Some(dear) };
        let of = |motions: &[Motion]| control(motions, 10.0, 0.95, 50, 1);
        // All equal: the value, and nothing to be controlled.
        let equal: Vec<Motion> = (0..20).map(|i| motion(i, 3.0, 7.0)).collect();
        let found = of(&equal);
        assert_eq!((found.plain.quantiles, found.correlation), ([7.0; 3], 0.0));
        assert!(found.controlled.is_err());
        // Half of the dear runs do not slide at all, as their cheap ones.
        let halves: Vec<Motion> = (0..60)
            .map(|i| {
                let value = if i % 2 == 0 { 0.0 } else { f64::from(i as u32) };
                Motion { cluster: i / 2, cheap: 2.0 * value, dear: (i % 6 < 2).then_some(value) }
            })
            .collect();
        let found = of(&halves);
        let with = found.controlled.as_ref().expect("perfect agreement");
        assert!(with.quantiles[0] == 0.0 && with.quantiles[2] > 20.0, "{found:?}");
        assert_eq!((found.pairs, found.clusters, found.motions), (20, 10, 60));
        // Failed: without a cheap value there is no motion, without a dear one no pair.
        let mut failed = halves.clone();
        failed[0].cheap = f64::NAN;
        failed[1].dear = Some(f64::NAN);
        failed[6].dear = Some(f64::INFINITY);
        let found = of(&failed);
        assert_eq!((found.pairs, found.clusters, found.motions), (17, 9, 59));
        assert!(found.best().quantiles.iter().all(|value| value.is_finite()), "{found:?}");
        let few = of(&halves[..36]);
        assert_eq!(few.controlled, Err(Declined::TooFew { clusters: 6 }));
        for nothing in
            [&[][..], &[motion(0, f64::NAN, 1.0)], &[Motion { cluster: 0, cheap: 1.0, dear: None }]]
        {
            let found = of(nothing);
            assert_eq!((found.pairs, found.controlled), (0, Err(Declined::TooFew { clusters: 0 })));
            assert!(
                found.plain.quantiles.iter().all(|value| value.is_nan()) && found.plain.interval.is_none()
            );
        }
        assert_eq!(of(&[motion(0, 1.0, 2.0)]).plain.quantiles, [2.0; 3]);
    }

    /// Intervals hold the truth about as often as they say (of 1000 studies of 16 and 32 pairs 97 to 99 %), and the standard error of F
    /// is its deviation between studies.
    #[test]
    fn intervals_hold_the_median() {
        let mut random = fastrand::Rng::with_seed(6);
        let (mut held, mut used, mut narrower) = (0, 0, 0.0);
        let (mut values, mut squares) = (Vec::new(), Vec::new());
        for study in 0..300 {
            let motions = motions(20, 100, 0.9, &mut random);
            values.push(sample(&motions).distribution(100.0, true));
            squares.push(standard_error(&clusters(&motions), 100.0, true, 50, study).powi(2));
            let found = control(&motions, 20.0, 0.95, 100, study);
            let Ok(Spread { interval: Some([low, high]), .. }) = found.controlled else { continue };
            used += 1;
            held += u32::from(low <= 100.0 && 100.0 <= high);
            let [first, last] = found.plain.interval.expect("an interval");
            narrower += (high / low).ln() / (last / first).ln();
        }
        let used_share = f64::from(used) / values.len() as f64;
        let deviation = mean(&values).1 * (values.len() as f64).sqrt();
        let error = mean(&squares).0.sqrt();
        println!(
            "{held} of {used}, {:.2} as wide as the plain ones; standard error {error:.4}, deviation {deviation:.4}",
            narrower / f64::from(used)
        );
        // Three standard deviations of 300 studies below 97 %; four of a deviation from 300 studies are 16 %.
        assert!(used_share > 0.9 && f64::from(held) > 0.94 * f64::from(used), "{held} of {used}");
        assert!(narrower < 0.8 * f64::from(used), "{narrower} {used}");
        assert!((0.84..1.3).contains(&(error / deviation)), "{error} {deviation}");
    }

    /// Each motion three times in its cluster says no more than once.
    #[test]
    fn copies_of_a_motion_make_nothing_surer_and_the_seed_decides() {
        let mut random = fastrand::Rng::with_seed(7);
        let once = motions(24, 120, 0.9, &mut random);
        let thrice: Vec<Motion> = once.iter().flat_map(|motion| [*motion; 3]).collect();
        let width = |motions: &[Motion], seed: u64| {
            let found = control(motions, 20.0, 0.95, 200, seed);
            let [low, high] = found.best().interval.expect("an interval");
            (high / low).ln()
        };
        assert_eq!(width(&once, 1), width(&once, 1));
        assert_ne!(width(&once, 1), width(&once, 2));
        let apart: Vec<Motion> =
            thrice.iter().enumerate().map(|(cluster, motion)| Motion { cluster, ..*motion }).collect();
        let [once, thrice, apart] = [&once, &thrice, &apart].map(|motions| width(motions, 1));
        assert!((thrice / once - 1.0).abs() < 0.2 && apart < 0.75 * once, "{once} {thrice} {apart}");
    }

    /// A cheap model that says the same of every motion: F is that of all motions, to the last digit.
    #[test]
    fn perfect_agreement_gives_the_distribution_of_all_motions() {
        let mut random = fastrand::Rng::with_seed(8);
        let all: Vec<f64> = (0..90).map(|_| gauss(&mut random)).collect();
        let motions = all.iter().enumerate().map(|(cluster, value)| Motion {
            cluster,
            cheap: 4.0 * value,
            dear: (cluster < 30).then_some(*value),
        });
        let sample = sample(&motions.collect::<Vec<_>>());
        for x in [-0.7, -0.2, 0.01, 0.5, 0.9] {
            let of_all = all.iter().filter(|value| **value <= x).count() as f64 / 90.0;
            let found = sample.distribution(x, true);
            assert!((found - of_all).abs() < 1e-12, "{found} {of_all}");
        }
    }

    /// The twin: values of F half-way between neighbours, sorted, and a line through them; where they fall, quantiles still rise.
    #[test]
    fn the_inverse_is_that_of_the_distribution_function() {
        let mut random = fastrand::Rng::with_seed(9);
        let mut falls = 0;
        for _ in 0..200 {
            let sample = sample(&motions(12, 60, 0.7, &mut random));
            let beside: Vec<f64> = sample.dear.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
            let of = |x: Option<&f64>, otherwise| x.map_or(otherwise, |x| sample.distribution(*x, true));
            let mut middles: Vec<f64> = (0..12)
                .map(|i: usize| {
                    (of(i.checked_sub(1).map(|below| &beside[below]), 0.0) + of(beside.get(i), 1.0)) / 2.0
                })
                .collect();
            falls += usize::from(!middles.is_sorted());
            middles.sort_by(f64::total_cmp);
            let above = middles.iter().position(|share| *share >= 0.5).expect("a half");
            let share = (0.5 - middles[above - 1]) / (middles[above] - middles[above - 1]);
            let twin = sample.dear[above - 1] + share * (sample.dear[above] - sample.dear[above - 1]);
            let inverse = sample.inverse(true);
            assert!((inverse.at(0.5) / twin - 1.0).abs() < 1e-9, "{} {twin}", inverse.at(0.5));
            let quantiles: Vec<f64> = (0..=20).map(|i| inverse.at(f64::from(i) / 20.0)).collect();
            assert!(quantiles.is_sorted(), "{quantiles:?}");
        }
        assert!(falls > 20, "{falls}");
    }
}
