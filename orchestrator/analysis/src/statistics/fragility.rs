use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// One run: how strong the shaking was, and whether the limit was exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Intensity measure, positive.
    pub intensity: f64,
    /// Whether the limit was exceeded.
    pub exceeded: bool,
    /// Clusters of dependent runs, such as those of one record.
    pub cluster: usize,
}

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

/// Results of the runs for a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fragility {
    /// A lognormal curve.
    Fit(Lognormal),
    /// None.
    None(NoFit),
}

impl Fragility {
    /// Intensity at which half of the runs exceed the limit: infinite if none does, 0 if all do, NaN where nothing can be said.
    pub fn median(&self) -> f64 {
        match self {
            Self::Fit(curve) => curve.median,
            Self::None(NoFit::NoneExceeds) => f64::INFINITY,
            Self::None(NoFit::AllExceed) => 0.0,
            Self::None(NoFit::Separated { between: [low, high] }) => (low * high).sqrt(),
            Self::None(NoFit::Falls | NoFit::Empty) => f64::NAN,
        }
    }

    /// Standard deviation of the logarithm; 0 where the curve is a step, NaN where nothing can be said.
    pub fn dispersion(&self) -> f64 {
        match self {
            Self::Fit(curve) => curve.dispersion,
            Self::None(NoFit::Falls | NoFit::Empty) => f64::NAN,
            Self::None(_) => 0.0,
        }
    }

    /// Probability at `intensity`: that of the curve, or of the step at the [`median`](Self::median).
    pub fn probability(&self, intensity: f64) -> f64 {
        match self {
            Self::Fit(curve) => curve.probability(intensity),
            Self::None(_) if self.median().is_nan() => f64::NAN,
            Self::None(_) => f64::from(u8::from(intensity >= self.median())),
        }
    }
}

/// Reason why there is no curve.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoFit {
    /// There are no runs with a value.
    #[error("no fit: no run has this quantity at its end; `cofferdam run` of one sample says why")]
    Empty,
    /// The limit was never exceeded.
    #[error("no fit: no run exceeds the limit; add stronger shaking")]
    NoneExceeds,
    /// The limit was always exceeded.
    #[error("no fit: every run exceeds the limit; add weaker shaking")]
    AllExceed,
    /// No run below an intensity exceeds the limit, and every one above: any small dispersion fits.
    #[error("no fit: {}; add levels {}", sides(between), if between[0] < between[1] { "between them" } else { "around it" })]
    Separated {
        /// The highest intensity without exceedance, and the lowest with it.
        between: [f64; 2],
    },
    /// Stronger shaking exceeds the limit less often.
    #[error("no fit: stronger shaking exceeds the limit less often; add records or levels")]
    Falls,
}

/// Steps of Newton's iteration; it needs fewer than ten.
const MOST_STEPS: usize = 100;

fn sides([low, high]: &[f64; 2]) -> String {
    if low < high {
        format!("no run up to {low:.4} exceeds the limit, and all from {high:.4} do")
    } else {
        format!("no run below {low:.4} exceeds the limit, and all above do")
    }
}

/// Runs of one intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// ln x.
    pub logarithm: f64,
    /// Numbers of runs that exceed the limit, and that do not.
    pub exceeding: f64,
    pub others: f64,
}

/// Fits a lognormal curve by maximum likelihood: each run is an independent trial,
///
/// ```text
/// Σ [e ln Φ(z) + (1 − e) ln Φ(−z)] → max,   z = a + b ln x,   median = e^(−a/b),   dispersion = 1/b
/// ```
///
/// with e = 1 where the limit was exceeded. The sum is concave in (a, b), so that Newton's iteration with halved steps finds
/// its only maximum.
///
/// **Source**: J.W. Baker, Efficient analytical fragility function fitting using dynamic structural analysis, Earthquake
/// Spectra 31 (2015), equations 10 and 11; probit regression.
pub fn fit(runs: &[Outcome]) -> Fragility {
    let mut sorted: Vec<&Outcome> = runs.iter().collect();
    sorted.sort_by(|a, b| a.intensity.total_cmp(&b.intensity));
    let levels = sorted.chunk_by(|a, b| a.intensity == b.intensity).map(|runs| {
        let exceeding = runs.iter().filter(|run| run.exceeded).count();
        Level {
            logarithm: runs[0].intensity.ln(),
            exceeding: exceeding as f64,
            others: (runs.len() - exceeding) as f64,
        }
    });
    of_levels(&levels.collect::<Vec<_>>())
}

/// The same of runs that are counted already, by ascending intensity.
pub(super) fn of_levels(levels: &[Level]) -> Fragility {
    match separation(levels) {
        Some(why) => Fragility::None(why),
        None => newton(levels),
    }
}

/// Reason why the likelihood has no maximum.
fn separation(levels: &[Level]) -> Option<NoFit> {
    let ends = |kind: fn(&Level) -> f64| {
        let mut of_kind = levels.iter().filter(move |level| kind(level) > 0.0).map(|level| level.logarithm);
        let first = of_kind.next()?;
        Some([first, of_kind.next_back().unwrap_or(first)])
    };
    match (ends(|level| level.exceeding), ends(|level| level.others)) {
        (None, None) => Some(NoFit::Empty),
        (None, _) => Some(NoFit::NoneExceeds),
        (_, None) => Some(NoFit::AllExceed),
        (Some([first, _]), Some([_, last])) if last <= first => {
            Some(NoFit::Separated { between: [last.exp(), first.exp()] })
        }
        (Some([_, last]), Some([first, _])) => (last <= first).then_some(NoFit::Falls),
    }
}

/// The maximum of the likelihood, found about the mean of ln x in units of its deviation.
fn newton(levels: &[Level]) -> Fragility {
    let moment = |of: &dyn Fn(f64) -> f64| -> f64 {
        levels.iter().map(|level| of(level.logarithm) * (level.exceeding + level.others)).sum()
    };
    let whole = moment(&|_| 1.0);
    let mean = moment(&|x| x) / whole;
    let unit = (moment(&|x| (x - mean).powi(2)) / whole).sqrt();
    let about = |line: [f64; 2]| Likelihood::of(levels, |x| (x - mean) / unit, line);
    let mut at = [0.0, 1.0];
    let mut found = about(at);
    for _ in 0..MOST_STEPS {
        let Some(step) = found.newton_step() else { break };
        let mut share = 1.0;
        let (next, likelihood) = loop {
            let next = [at[0] + share * step[0], at[1] + share * step[1]];
            let likelihood = about(next);
            if likelihood.value >= found.value || share < 1e-6 {
                break (next, likelihood);
            }
            share /= 2.0;
        };
        let moved = (next[0] - at[0]).abs().max((next[1] - at[1]).abs());
        (at, found) = (next, likelihood);
        if moved < 1e-10 * (1.0 + at[1].abs()) {
            break;
        }
    }
    let [a, b] = at;
    if b <= 0.0 {
        return Fragility::None(NoFit::Falls);
    }
    Fragility::Fit(Lognormal { median: (mean - a / b * unit).exp(), dispersion: unit / b })
}

/// The logarithm of the likelihood of `z = a + b x`, and its first and second derivatives by (a, b).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Likelihood {
    value: f64,
    pub slope: [f64; 2],
    /// By a twice, by both, by b twice.
    pub curvature: [f64; 3],
}

impl Likelihood {
    /// Of these levels at the line `[a, b]`, with x from the logarithm of the intensity.
    pub fn of(levels: &[Level], x: impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> Self {
        let mut sum = Self::default();
        for Level { logarithm, exceeding, others } in levels {
            let x = x(*logarithm);
            let z = a + b * x;
            let ([l, d, h], [m, e, k]) = (logarithm_of_probability(z), logarithm_of_probability(-z));
            let (first, second) = (exceeding * d - others * e, exceeding * h + others * k);
            sum.value += exceeding * l + others * m;
            sum.slope[0] += first;
            sum.slope[1] += first * x;
            sum.curvature[0] += second;
            sum.curvature[1] += second * x;
            sum.curvature[2] += second * x * x;
        }
        sum
    }

    /// The change of (a, b) to where the slope would be 0.
    fn newton_step(&self) -> Option<[f64; 2]> {
        let [p, q, r] = self.curvature;
        let ([s, t], determinant) = (self.slope, p * r - q * q);
        let step = [(q * t - r * s) / determinant, (q * s - p * t) / determinant];
        step.iter().all(|change| change.is_finite()).then_some(step)
    }
}

/// `ln Φ(z)` and its first two derivatives; below −30, where Φ vanishes, its asymptotic form.
fn logarithm_of_probability(z: f64) -> [f64; 3] {
    let normal = Normal::standard();
    let (value, ratio) = if z < -30.0 {
        (-z * z / 2.0 - (-z * std::f64::consts::TAU.sqrt()).ln(), -z)
    } else {
        let probability = normal.cdf(z);
        (probability.ln(), normal.pdf(z) / probability)
    };
    [value, ratio, -ratio * (z + ratio)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(of: impl IntoIterator<Item = (f64, bool)>) -> Vec<Outcome> {
        let runs = of.into_iter().enumerate();
        runs.map(|(cluster, (intensity, exceeded))| Outcome { intensity, exceeded, cluster }).collect()
    }

    /// Two levels with two kinds of run each: the likelihood is greatest where the curve goes through both shares.
    #[test]
    fn two_levels_give_the_curve_through_both_shares() {
        let level = |x: f64, exceeding: usize| (0..10).map(move |i| (x, i < exceeding));
        let Fragility::Fit(curve) = fit(&runs(level(0.2, 2).chain(level(0.6, 9)))) else {
            panic!("a fit");
        };
        assert!((curve.probability(0.2) - 0.2).abs() < 1e-9, "{curve:?}");
        assert!((curve.probability(0.6) - 0.9).abs() < 1e-9, "{curve:?}");
    }

    #[test]
    fn many_draws_from_a_curve_give_it_back() {
        let mut random = fastrand::Rng::with_seed(11);
        let truth = Lognormal { median: 0.4, dispersion: 0.5 };
        let draws = (0..40_000).map(|i| {
            let x = 0.1 * f64::from(1 + i % 10);
            (x, random.f64() < truth.probability(x))
        });
        let Fragility::Fit(curve) = fit(&runs(draws)) else { panic!("a fit") };
        assert!((curve.median / 0.4 - 1.0).abs() < 0.02, "{curve:?}");
        assert!((curve.dispersion / 0.5 - 1.0).abs() < 0.03, "{curve:?}");
    }

    #[test]
    fn where_there_is_no_curve_it_says_why() {
        let none = |of: &[(f64, bool)]| match fit(&runs(of.iter().copied())) {
            Fragility::None(why) => why,
            Fragility::Fit(curve) => panic!("{curve:?}"),
        };
        assert_eq!(none(&[]), NoFit::Empty);
        assert_eq!(none(&[(0.1, false), (0.2, false)]), NoFit::NoneExceeds);
        assert_eq!(none(&[(0.1, true), (0.2, true)]), NoFit::AllExceed);
        let between = none(&[(0.1, false), (0.2, false), (0.4, true), (0.5, true)]);
        let NoFit::Separated { between: [low, high] } = between else { panic!("{between:?}") };
        assert!((low - 0.2).abs() < 1e-12 && (high - 0.4).abs() < 1e-12);
        // Both kinds at one level only: still any small dispersion.
        assert!(matches!(
            none(&[(0.1, false), (0.2, false), (0.2, true), (0.3, true)]),
            NoFit::Separated { .. }
        ));
        assert_eq!(none(&[(0.1, true), (0.2, false)]), NoFit::Falls);
        assert_eq!(none(&[(0.1, true), (0.2, true), (0.2, false), (0.2, false), (0.3, false)]), NoFit::Falls);
        assert_eq!(
            none(&[
                (0.1, true),
                (0.1, true),
                (0.2, false),
                (0.2, true),
                (0.3, false),
                (0.3, true),
                (0.3, false)
            ]),
            NoFit::Falls
        );
    }
}
