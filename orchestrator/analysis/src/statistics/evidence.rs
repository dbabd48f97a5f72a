use super::exceedance::{Exceedance, Outcome, exceedances, have_common_levels, median_bracket};
use super::fragility::{Lognormal, clusters, penalised, sum};
use super::jackknife::Fitted;
use statrs::distribution::{ContinuousCDF, Normal};

/// Smallest number of independent records or pairs of a curve.
pub const LEAST_CLUSTERS: usize = 12;
/// Smallest number of levels of shaking of a curve.
pub const LEAST_LEVELS: usize = 6;
/// Smallest number of levels with runs on both sides of the limit.
pub const LEAST_MIXED: usize = 3;

/// What the runs say about a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// The runs of each level, by ascending intensity; of six groups by intensity where levels are factors.
    pub levels: Vec<Exceedance>,
    /// Number of independent records or pairs.
    pub clusters: usize,
    /// Interval of the median by the exact intervals of the levels, see [`median_bracket`]; unknown ends are 0 and infinite. None where
    /// levels are factors.
    pub bracket: Option<[f64; 2]>,
    /// What can be drawn.
    pub curve: Curve,
}

/// What can be drawn through the levels.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// A curve with intervals.
    Supported(Fitted),
    /// No run up to a level exceeds the limit, every run from the next level on does, and at least six records say so.
    Separated {
        /// The penalised curve: its steepness is that of the prior.
        estimate: Lognormal,
        /// The largest dispersion that the runs allow, with at least the confidence of the intervals.
        dispersion_at_most: f64,
        /// Reasons why it is not supported.
        missing: Vec<Missing>,
    },
    /// None.
    None(Vec<Missing>),
}

/// What is missing for a curve.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Missing {
    /// No run has a value.
    #[error("no run has this quantity at its end; `cofferdam run` of one sample says why")]
    Runs,
    /// Too few records.
    #[error("{have} independent records or pairs, at least {LEAST_CLUSTERS} are needed")]
    Clusters {
        /// Their number.
        have: usize,
    },
    /// Too few levels.
    #[error("{have} levels of shaking, at least {LEAST_LEVELS} are needed")]
    Levels {
        /// Their number.
        have: usize,
    },
    /// No run exceeds the limit.
    #[error("no run exceeds the limit")]
    Exceeding,
    /// Every run exceeds the limit.
    #[error("every run exceeds the limit")]
    Others,
    /// Too few levels with runs on both sides.
    #[error("{have} levels with runs on both sides of the limit, at least {LEAST_MIXED} are needed")]
    Mixed {
        /// Their number.
        have: usize,
    },
    /// The exact intervals of the levels leave open where the median is.
    #[error("no level whose exceedance is certainly below 50 %")]
    Below,
    /// The same above.
    #[error("no level whose exceedance is certainly above 50 %")]
    Above,
    /// The slope may be 0.
    #[error("stronger shaking does not exceed the limit significantly more often")]
    Slope,
}

impl Evidence {
    /// Of these runs. A curve is supported with at least [`LEAST_CLUSTERS`] clusters, [`LEAST_LEVELS`] levels, [`LEAST_MIXED`] levels with at
    /// least one cluster's worth of runs on either side ([`Exceedance::is_mixed`]), a level whose exact interval lies below one half and
    /// one above, and a slope whose interval is positive. Of studies that meet this criterion, 93 to 98 % of the intervals at 95 % hold the
    /// truth if the levels are no further apart than the dispersion.
    pub fn of(runs: &[Outcome], confidence: f64) -> Self {
        let levels = exceedances(runs, confidence);
        let clusters = clusters(runs);
        let bracket = median_bracket(&levels);
        let mut missing = missing(&levels, clusters.len(), bracket);
        let mut curve = None;
        if missing.is_empty() {
            curve = Fitted::of(&clusters, confidence).filter(|fitted| fitted.median().is_some());
            if curve.is_none() {
                missing.push(Missing::Slope);
            }
        }
        let is_common = have_common_levels(runs);
        let curve = match (curve, separation(&levels).filter(|_| is_common)) {
            (Some(fitted), _) => Curve::Supported(fitted),
            (None, Some(gap)) if bracket == gap => {
                let estimate = penalised(&sum(&clusters), None).and_then(|line| line.curve());
                match estimate {
                    Some(estimate) => Curve::Separated {
                        estimate,
                        dispersion_at_most: dispersion_at_most(gap, clusters.len(), confidence),
                        missing,
                    },
                    None => Curve::None(missing),
                }
            }
            (None, _) => Curve::None(missing),
        };
        Self { levels, clusters: clusters.len(), bracket: is_common.then_some(bracket), curve }
    }

    /// What is missing for a curve with intervals.
    pub fn missing(&self) -> &[Missing] {
        match &self.curve {
            Curve::Supported(_) => &[],
            Curve::Separated { missing, .. } | Curve::None(missing) => missing,
        }
    }

    /// The estimate of the curve, with or without support.
    pub fn estimate(&self) -> Option<Lognormal> {
        match &self.curve {
            Curve::Supported(fitted) => fitted.curve(),
            Curve::Separated { estimate, .. } => Some(*estimate),
            Curve::None(_) => None,
        }
    }
}

fn missing(levels: &[Exceedance], clusters: usize, bracket: [f64; 2]) -> Vec<Missing> {
    let [exceeding, all] = [|level: &Exceedance| level.exceeding, |level: &Exceedance| level.runs]
        .map(|of| levels.iter().map(of).sum::<usize>());
    if all == 0 {
        return vec![Missing::Runs];
    }
    let mut missing = Vec::new();
    let mixed = levels.iter().filter(|level| level.is_mixed()).count();
    let by_outcome = match exceeding {
        0 => vec![Missing::Exceeding],
        _ if exceeding == all => vec![Missing::Others],
        _ => {
            let mut found = Vec::new();
            if mixed < LEAST_MIXED {
                found.push(Missing::Mixed { have: mixed });
            }
            // With fewer records no level can be certain.
            if clusters >= LEAST_CLUSTERS {
                found.extend((bracket[0] == 0.0).then_some(Missing::Below));
                found.extend(bracket[1].is_infinite().then_some(Missing::Above));
            }
            found
        }
    };
    if clusters < LEAST_CLUSTERS {
        missing.push(Missing::Clusters { have: clusters });
    }
    if levels.len() < LEAST_LEVELS {
        missing.push(Missing::Levels { have: levels.len() });
    }
    missing.extend(by_outcome);
    missing
}

/// The neighbouring levels such that all runs up to the first stay below the limit and all runs from the second on exceed it.
fn separation(levels: &[Exceedance]) -> Option<[f64; 2]> {
    let first = levels.iter().position(|level| level.exceeding > 0)?;
    let separated = first > 0 && levels[first..].iter().all(|level| level.exceeding == level.runs);
    separated.then(|| [levels[first - 1].intensity, levels[first].intensity])
}

/// The largest dispersion β of a lognormal curve such that the capacities of so many independent records lie between two levels `gap` with
/// a probability of `1 − confidence` or more,
///
/// ```text
/// [2 Φ(ln(x₂/x₁)/2β) − 1]^(n−1) = 1 − confidence
/// ```
///
/// The bracket is the largest probability of a gap, that of one about the median. With the exponent n − 1 instead of n the statement also
/// holds for all gaps of a study together: `Σ p_i^n ≤ max p_i^(n−1) Σ p_i`, and the probabilities of gaps that do not overlap add up to at
/// most 1.
fn dispersion_at_most([low, high]: [f64; 2], records: usize, confidence: f64) -> f64 {
    let probability = (1.0 - confidence).powf(1.0 / (records.max(2) - 1) as f64);
    (high / low).ln() / (2.0 * Normal::standard().inverse_cdf((1.0 + probability) / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records whose capacities are the quantiles of a lognormal distribution of the median 0.4.
    fn runs(records: usize, dispersion: f64, levels: &[f64]) -> Vec<Outcome> {
        let of = |record: usize| {
            let quantile = Normal::standard().inverse_cdf((record as f64 + 0.5) / records as f64);
            let capacity = 0.4 * (dispersion * quantile).exp();
            levels.iter().enumerate().map(move |(level, intensity)| Outcome {
                intensity: *intensity,
                level,
                exceeded: *intensity > capacity,
                cluster: record,
            })
        };
        (0..records).flat_map(of).collect()
    }

    const LEVELS: [f64; 6] = [0.15, 0.25, 0.35, 0.45, 0.6, 0.8];

    #[test]
    fn many_records_about_the_limit_support_a_curve() {
        let evidence = Evidence::of(&runs(20, 0.4, &LEVELS), 0.95);
        let Curve::Supported(fitted) = &evidence.curve else { panic!("{evidence:?}") };
        let curve = fitted.curve().expect("a curve");
        assert!((curve.median / 0.4 - 1.0).abs() < 0.05, "{curve:?}");
        assert!((curve.dispersion / 0.4 - 1.0).abs() < 0.2, "{curve:?}");
        assert!(evidence.missing().is_empty());
    }

    #[test]
    fn where_there_is_no_curve_it_says_what_is_missing() {
        let missing = |runs: &[Outcome]| match Evidence::of(runs, 0.95).curve {
            Curve::None(missing) => missing,
            other => panic!("{other:?}"),
        };
        assert_eq!(missing(&[]), [Missing::Runs]);
        assert_eq!(missing(&runs(20, 0.4, &[0.01, 0.02, 0.03, 0.04, 0.05, 0.06])), [Missing::Exceeding]);
        assert_eq!(missing(&runs(20, 0.4, &[3.0, 4.0, 5.0, 6.0, 7.0, 8.0])), [Missing::Others]);
        assert_eq!(missing(&runs(4, 0.4, &LEVELS)), [Missing::Clusters { have: 4 }]);
        assert_eq!(
            missing(&runs(4, 0.4, &[0.26, 0.4, 0.7])),
            [Missing::Clusters { have: 4 }, Missing::Levels { have: 3 }, Missing::Mixed { have: 2 }]
        );
        assert_eq!(missing(&runs(20, 0.4, &[0.2, 0.25, 0.3, 0.33, 0.36, 0.4])), [Missing::Above]);
        assert_eq!(missing(&runs(20, 0.4, &[0.4, 0.45, 0.5, 0.6, 0.7, 0.8])), [Missing::Below]);
        assert_eq!(missing(&runs(20, 0.1, &[0.1, 0.2, 0.3, 0.42, 0.6, 0.8])), [Missing::Mixed { have: 1 }]);
        for words in ["4 independent records", "at least 12"] {
            assert!(Missing::Clusters { have: 4 }.to_string().contains(words));
        }
    }

    #[test]
    fn separated_runs_have_a_penalised_curve_and_a_largest_dispersion() {
        let separated = Evidence::of(&runs(8, 0.1, &[0.1, 0.15, 0.2, 0.8, 1.0, 1.2]), 0.95);
        let Curve::Separated { estimate, dispersion_at_most, missing } = &separated.curve else {
            panic!("{separated:?}")
        };
        assert_eq!(missing, &[Missing::Clusters { have: 8 }, Missing::Mixed { have: 0 }]);
        assert_eq!(separated.bracket, Some([0.2, 0.8]));
        assert!(0.2 < estimate.median && estimate.median < 0.8, "{estimate:?}");
        assert!(estimate.dispersion < *dispersion_at_most, "{estimate:?} {dispersion_at_most}");
        // Of five records the levels leave the median open.
        assert!(matches!(
            Evidence::of(&runs(5, 0.1, &[0.1, 0.15, 0.2, 0.8, 1.0, 1.2]), 0.95).curve,
            Curve::None(_)
        ));
        // All of eight records in the gap, at the largest dispersion: 5 % with seven.
        let normal = Normal::standard();
        let of_one = 2.0 * normal.cdf(4f64.ln() / 2.0 / dispersion_at_most) - 1.0;
        assert!((of_one.powi(7) - 0.05).abs() < 1e-9, "{of_one}");
    }

    /// Records as they are: every run has an intensity of its own.
    #[test]
    fn records_of_different_strength_support_a_curve_too() {
        let runs: Vec<Outcome> = (0..60)
            .map(|record| {
                let intensity = 0.1 * 1.05f64.powi(record);
                let capacity = [0.15, 0.25, 0.4, 0.6, 1.0][(record % 5) as usize];
                Outcome { intensity, level: 0, exceeded: intensity > capacity, cluster: record as usize }
            })
            .collect();
        let evidence = Evidence::of(&runs, 0.95);
        assert!(matches!(evidence.curve, Curve::Supported(_)), "{evidence:?}");
        assert_eq!((evidence.bracket, evidence.levels.len()), (None, 6));
    }
}
