use super::exceedance::Outcome;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};
use std::collections::BTreeMap;

/// Probability of exceeding a limit over the intensity x: `P = Φ(ln(x/median)/dispersion)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lognormal {
    /// Intensity at which half of the runs exceed the limit.
    pub median: f64,
    /// Standard deviation of the logarithm.
    pub dispersion: f64,
}

impl Lognormal {
    /// Probability at `intensity`.
    pub fn probability(&self, intensity: f64) -> f64 {
        Normal::standard().cdf((intensity / self.median).ln() / self.dispersion)
    }
}

/// Steps of the iteration; it needs about ten.
const MOST_STEPS: usize = 200;

/// Runs of one intensity, each cluster with the weight 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Point {
    /// ln x.
    pub logarithm: f64,
    /// Sum of the clusters' shares of runs that exceed the limit, and of those that do not.
    pub exceeding: f64,
    pub others: f64,
}

/// The line `z = a + b ln x` of a curve `P = Φ(z)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub a: f64,
    pub b: f64,
}

impl Line {
    /// The curve, if it rises.
    pub fn curve(&self) -> Option<Lognormal> {
        (self.b > 0.0).then(|| Lognormal { median: (-self.a / self.b).exp(), dispersion: 1.0 / self.b })
    }
}

/// The points of each cluster, all with the same intensities in ascending order.
pub(super) fn clusters(runs: &[Outcome]) -> Vec<Vec<Point>> {
    let mut intensities: Vec<f64> = runs.iter().map(|run| run.intensity).collect();
    intensities.sort_by(f64::total_cmp);
    intensities.dedup();
    let mut clusters: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    for run in runs {
        let counts = clusters.entry(run.cluster).or_insert_with(|| vec![[0.0; 2]; intensities.len()]);
        let at = intensities.partition_point(|intensity| *intensity < run.intensity);
        counts[at][usize::from(!run.exceeded)] += 1.0;
    }
    let point = |(intensity, [exceeding, others]): (&f64, &[f64; 2])| {
        let all = (exceeding + others).max(1.0);
        Point { logarithm: intensity.ln(), exceeding: exceeding / all, others: others / all }
    };
    clusters.values().map(|counts| intensities.iter().zip(counts).map(point).collect()).collect()
}

/// The sum of the points of `clusters`.
pub(super) fn sum(clusters: &[Vec<Point>]) -> Vec<Point> {
    let mut sum = clusters.first().cloned().unwrap_or_default();
    for cluster in clusters.iter().skip(1) {
        for (sum, point) in sum.iter_mut().zip(cluster) {
            sum.exceeding += point.exceeding;
            sum.others += point.others;
        }
    }
    sum
}

/// The line of the largest penalised likelihood (Firth),
///
/// ```text
/// Σ [e ln Φ(z) + (n − e) ln Φ(−z)] + ½ ln det I → max,   z = a + b ln x
/// I = Σ n w(z) [1, ln x; ln x, ln² x],   w = φ²/(Φ(z) Φ(−z))
/// ```
///
/// with n clusters at the intensity x, a share e/n of which exceeds the limit, and the expected information I. The penalty is the
/// logarithm of Jeffreys' prior of (a, b). It removes the bias of the first order, and keeps the line finite where the likelihood alone has no
/// maximum: all runs up to a level below the limit, and all runs above it beyond. Fisher's scoring with halved steps. None with
/// fewer than two intensities.
///
/// **Source**: D. Firth, Bias reduction of maximum likelihood estimates, Biometrika 80 (1993); I. Kosmidis, D. Firth, Jeffreys-prior penalty,
/// finiteness and shrinkage in binomial-response generalized linear models, Biometrika 108 (2021), for probit and finiteness.
pub(super) fn penalised(points: &[Point], start: Option<Line>) -> Option<Line> {
    let weight = |point: &Point| point.exceeding + point.others;
    let moment = |of: &dyn Fn(f64) -> f64| -> f64 {
        points.iter().map(|point| weight(point) * of(point.logarithm)).sum()
    };
    let all = moment(&|_| 1.0);
    let mean = moment(&|x| x) / all;
    let unit = (moment(&|x| (x - mean).powi(2)) / all).sqrt();
    if unit.is_nan() || unit < 1e-12 {
        return None;
    }
    // about the mean, in units of the deviation
    let mut at = start.map_or([0.0, 1.0], |line| [line.a + line.b * mean, line.b * unit]);
    let about = |line: [f64; 2]| Penalised::of(points, |x| (x - mean) / unit, line);
    let mut found = about(at);
    for _ in 0..MOST_STEPS {
        let Some(step) = found.step() else { break };
        let mut share = 1.0;
        let (next, likelihood) = loop {
            let next = [at[0] + share * step[0], at[1] + share * step[1]];
            let likelihood = about(next);
            if likelihood.value >= found.value || share < 1e-7 {
                break (next, likelihood);
            }
            share /= 2.0;
        };
        let moved = (next[0] - at[0]).abs().max((next[1] - at[1]).abs());
        (at, found) = (next, likelihood);
        if moved < 1e-9 * (1.0 + at[1].abs()) {
            break;
        }
    }
    let b = at[1] / unit;
    Some(Line { a: at[0] - b * mean, b })
}

/// The penalised logarithm of the likelihood, its slope by (a, b), and the information of the likelihood.
#[derive(Clone, Copy, Debug)]
struct Penalised {
    value: f64,
    slope: [f64; 2],
    /// By a twice, by both, by b twice.
    information: [f64; 3],
}

impl Penalised {
    /// Of these points at the line `[a, b]`, with x from the logarithm of the intensity.
    fn of(points: &[Point], x: impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> Self {
        let (mut value, mut slope, mut information) = (0.0, [0.0; 2], [0.0; 3]);
        // Derivatives of the information by a; by b they are the next ones.
        let mut change = [0.0; 4];
        for Point { logarithm, exceeding, others } in points {
            let x = x(*logarithm);
            let z = a + b * x;
            let ([l, d], [m, e]) = (logarithm_of_probability(z), logarithm_of_probability(-z));
            value += exceeding * l + others * m;
            let first = exceeding * d - others * e;
            slope[0] += first;
            slope[1] += first * x;
            let weight = (exceeding + others) * d * e;
            let of_weight = weight * (e - d - 2.0 * z);
            for (power, sum) in information.iter_mut().enumerate() {
                *sum += weight * x.powi(power as i32);
            }
            for (power, sum) in change.iter_mut().enumerate() {
                *sum += of_weight * x.powi(power as i32);
            }
        }
        let [p, q, r] = information;
        let determinant = p * r - q * q;
        value += 0.5 * determinant.ln();
        for (by, slope) in slope.iter_mut().enumerate() {
            let [dp, dq, dr] = [change[by], change[by + 1], change[(by + 2).min(3)]];
            *slope += 0.5 * (dp * r + p * dr - 2.0 * q * dq) / determinant;
        }
        Self { value, slope, information }
    }

    /// The step of Fisher's scoring.
    fn step(&self) -> Option<[f64; 2]> {
        let [p, q, r] = self.information;
        let ([s, t], determinant) = (self.slope, p * r - q * q);
        let step = [(r * s - q * t) / determinant, (p * t - q * s) / determinant];
        step.iter().all(|change| change.is_finite()).then_some(step)
    }
}

/// `ln Φ(z)` and its derivative; below −30, where Φ vanishes, its asymptotic form.
fn logarithm_of_probability(z: f64) -> [f64; 2] {
    let normal = Normal::standard();
    if z < -30.0 {
        [-z * z / 2.0 - (-z * std::f64::consts::TAU.sqrt()).ln(), -z]
    } else {
        let probability = normal.cdf(z);
        [probability.ln(), normal.pdf(z) / probability]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(of: &[(f64, f64, f64)]) -> Vec<Point> {
        of.iter()
            .map(|(x, exceeding, others)| Point { logarithm: x.ln(), exceeding: *exceeding, others: *others })
            .collect()
    }

    /// The penalised likelihood by an independent path: Φ by Simpson's rule, the information by the expected squared score of a run.
    fn by_definition(points: &[Point], a: f64, b: f64) -> f64 {
        let density = |z: f64| (-z * z / 2.0).exp() / std::f64::consts::TAU.sqrt();
        let probability = |z: f64| {
            let (steps, from) = (400, -9.0f64);
            let h = (z - from) / f64::from(steps);
            let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            (0..=steps).map(|i| weight(i) * density(from + h * f64::from(i))).sum::<f64>() * h / 3.0
        };
        let mut value = 0.0;
        let mut information = [[0.0; 2]; 2];
        for point in points {
            let z = a + b * point.logarithm;
            let (p, slope) = (probability(z), density(z));
            value += point.exceeding * p.ln() + point.others * (1.0 - p).ln();
            // Of a run: score φ/p with probability p, −φ/(1 − p) otherwise.
            let square = p * (slope / p).powi(2) + (1.0 - p) * (slope / (1.0 - p)).powi(2);
            let direction = [1.0, point.logarithm];
            for (i, row) in information.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry += (point.exceeding + point.others) * square * direction[i] * direction[j];
                }
            }
        }
        let determinant = information[0][0] * information[1][1] - information[0][1] * information[1][0];
        value + 0.5 * determinant.ln()
    }

    /// No line of a fine grid about the one that is found is better, with and without separation.
    #[test]
    fn the_penalised_line_is_the_best_of_a_grid() {
        let separated = [(0.2, 0.0, 6.0), (0.4, 6.0, 0.0)];
        let overlapping = [(0.2, 1.0, 11.0), (0.3, 4.5, 7.5), (0.4, 5.0, 7.0), (0.6, 11.0, 1.0)];
        for of in [&separated[..], &overlapping] {
            let points = points(of);
            let Line { a, b } = penalised(&points, None).expect("a line");
            let best = by_definition(&points, a, b);
            let centre = 0.3f64.ln();
            for i in -20..=20 {
                for j in -20..=20 {
                    if (i, j) == (0, 0) {
                        continue;
                    }
                    // the slope, and the value in the middle
                    let slope = b * (1.0 + 0.02 * f64::from(j));
                    let other = a + b * centre + 0.02 * f64::from(i) - slope * centre;
                    assert!(by_definition(&points, other, slope) < best, "{of:?}: {i} {j}");
                }
            }
        }
    }

    /// With two intensities the problem falls apart into one for each z: k ln Φ(z) + (n − k) ln Φ(−z) + ½ ln w(z) → max, by golden section.
    #[test]
    fn two_intensities_are_two_problems_of_one_unknown() {
        let normal = Normal::standard();
        let best = |k: f64, n: f64| {
            let value = |z: f64| {
                let (p, q) = (normal.cdf(z), normal.cdf(-z));
                k * p.ln() + (n - k) * q.ln() + 0.5 * (normal.pdf(z).powi(2) / (p * q)).ln()
            };
            let ratio = (5f64.sqrt() - 1.0) / 2.0;
            let (mut low, mut high) = (-6.0, 6.0);
            for _ in 0..80 {
                let (left, right) = (high - ratio * (high - low), low + ratio * (high - low));
                if value(left) < value(right) { low = left } else { high = right }
            }
            (low + high) / 2.0
        };
        for [k, l] in [[0.0, 8.0], [2.0, 7.0], [0.0, 0.0]] {
            let Line { a, b } =
                penalised(&points(&[(0.2, k, 8.0 - k), (0.5, l, 8.0 - l)]), None).expect("a line");
            for (x, count) in [(0.2f64, k), (0.5, l)] {
                let (found, wanted) = (a + b * x.ln(), best(count, 8.0));
                assert!((found - wanted).abs() < 1e-6, "{count}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn many_runs_of_a_curve_give_it_back() {
        let mut random = fastrand::Rng::with_seed(11);
        let truth = Lognormal { median: 0.4, dispersion: 0.5 };
        let runs: Vec<Outcome> = (0..40_000)
            .map(|i| {
                let intensity = 0.1 * (1 + i % 10) as f64;
                let exceeded = random.f64() < truth.probability(intensity);
                Outcome { intensity, level: i % 10, exceeded, cluster: i }
            })
            .collect();
        let curve = penalised(&sum(&clusters(&runs)), None).and_then(|line| line.curve()).expect("a curve");
        assert!((curve.median / 0.4 - 1.0).abs() < 0.02, "{curve:?}");
        assert!((curve.dispersion / 0.5 - 1.0).abs() < 0.03, "{curve:?}");
    }

    /// Each record three times in its cluster says no more than once.
    #[test]
    fn copies_of_a_record_change_nothing() {
        let run = |i: usize| Outcome {
            intensity: [0.2, 0.3, 0.5][i % 3],
            level: i % 3,
            exceeded: (i * 7) % 5 < i % 3 + 1,
            cluster: i / 3,
        };
        let once: Vec<Outcome> = (0..36).map(run).collect();
        let thrice: Vec<Outcome> = once.iter().flat_map(|run| [*run; 3]).collect();
        assert_eq!(sum(&clusters(&once)), sum(&clusters(&thrice)));
        assert_eq!(penalised(&points(&[(0.2, 1.0, 3.0)]), None), None, "one intensity");
    }
}
