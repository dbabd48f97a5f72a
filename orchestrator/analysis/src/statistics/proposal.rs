use super::evidence::{Evidence, LEAST_CLUSTERS, LEAST_LEVELS, LEAST_MIXED};
use super::exact::trials_for_width;
use super::exceedance::Exceedance;

/// Width of the interval of a level that the proposed number of records reaches.
pub const WIDTH: f64 = 0.3;
/// Ratio of a level beyond the tested ones to the outermost one.
const BEYOND: f64 = 1.5;
/// Share of runs below which a level counts as below the transition, or as above it if so many do not exceed.
const OUTER: f64 = 0.2;
/// Levels closer than this ratio are one.
const APART: f64 = 1.03;

/// Runs that are missing for a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// Levels of shaking to add, in ascending order.
    pub levels: Vec<f64>,
    /// Number of independent records that a curve needs; no more than there are if that is enough.
    pub records: usize,
    /// Number of independent records with which the exact interval of every level is no wider than [`WIDTH`].
    pub records_for_width: usize,
}

/// The runs that are missing for a curve of `evidence`. `tested` holds its levels, with the factor on the records as intensity where levels are
/// factors; levels are at most `highest`. Where no run exceeds the limit, two stronger levels
/// (1.5 and 2.25 times the strongest); where every run does, two weaker ones. Otherwise levels in the widest gaps (in their logarithm) of the
/// transition, from the last level without exceedance to the first one with exceedances only, until there are six levels, of which three can be expected to be mixed;
/// and a level beyond an end of the tests at which more than 20 % of the runs are on the other side.
pub fn propose(evidence: &Evidence, tested: &[Exceedance], confidence: f64, highest: f64) -> Proposal {
    let mut levels = if evidence.missing().is_empty() { Vec::new() } else { added(tested) };
    levels.retain(|level| *level <= highest);
    Proposal {
        levels,
        records: evidence.clusters.max(LEAST_CLUSTERS),
        records_for_width: trials_for_width(WIDTH, confidence),
    }
}

fn added(tested: &[Exceedance]) -> Vec<f64> {
    let tested: Vec<Exceedance> = tested.iter().filter(|level| level.runs > 0).copied().collect();
    let [Some(first), Some(last)] = [tested.first(), tested.last()] else { return Vec::new() };
    let mut levels: Vec<f64> = tested.iter().map(|level| level.intensity).collect();
    if tested.iter().all(|level| level.exceeding == 0) {
        levels.extend([BEYOND, BEYOND * BEYOND].map(|ratio| last.intensity * ratio));
    } else if tested.iter().all(|level| level.exceeding == level.runs) {
        levels.extend([BEYOND, BEYOND * BEYOND].map(|ratio| first.intensity / ratio));
    } else {
        if first.share > OUTER {
            levels.push(first.intensity / BEYOND);
        }
        if last.share < 1.0 - OUTER {
            levels.push(last.intensity * BEYOND);
        }
        levels.sort_by(f64::total_cmp);
        let low = tested.iter().take_while(|level| level.exceeding == 0).last();
        let high = tested.iter().rev().take_while(|level| level.exceeding == level.runs).last();
        let low = low.map_or(levels[0], |level| level.intensity);
        let high = high.map_or(levels[levels.len() - 1], |level| level.intensity);
        let mixed = tested.iter().filter(|level| level.is_mixed()).count();
        let wanted = LEAST_MIXED.saturating_sub(mixed).max(LEAST_LEVELS.saturating_sub(levels.len()));
        for _ in 0..wanted {
            let within = levels.windows(2).filter(|pair| pair[0] >= low && pair[1] <= high);
            let widest = within.max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
            let Some(middle) = widest.map(|pair| (pair[0] * pair[1]).sqrt()) else { break };
            levels.push(middle);
            levels.sort_by(f64::total_cmp);
        }
    }
    let mut kept: Vec<f64> = tested.iter().map(|level| level.intensity).collect();
    let mut new = Vec::new();
    levels.sort_by(f64::total_cmp);
    for level in levels.into_iter().map(rounded) {
        if level > 0.0 && is_apart(level, &kept) {
            kept.push(level);
            new.push(level);
        }
    }
    new
}

/// Whether `level` is none of `others`, nor next to one.
pub fn is_apart(level: f64, others: &[f64]) -> bool {
    others.iter().all(|other| (level / other).max(other / level) > APART)
}

/// Two significant digits.
fn rounded(level: f64) -> f64 {
    format!("{level:.1e}").parse().unwrap_or(level)
}

#[cfg(test)]
mod tests {
    use super::super::exceedance::Outcome;
    use super::*;

    /// Eight runs of four records at each level, of which so many exceed the limit.
    fn evidence(of: &[(f64, usize)]) -> Evidence {
        let runs: Vec<Outcome> = of
            .iter()
            .enumerate()
            .flat_map(|(level, (intensity, exceeding))| {
                (0..8).map(move |run| Outcome {
                    intensity: *intensity,
                    level,
                    exceeded: run < *exceeding,
                    cluster: run / 2,
                })
            })
            .collect();
        Evidence::of(&runs, 0.95)
    }

    fn proposed(evidence: &Evidence) -> Proposal {
        propose(evidence, &evidence.levels, 0.95, 10.0)
    }

    #[test]
    fn levels_are_added_where_they_are_missing() {
        for (tested, wanted) in [
            (&[(0.2, 0), (0.35, 2), (0.5, 8)][..], &[0.26, 0.3, 0.42][..]),
            (&[(0.2, 0), (0.4, 0)], &[0.6, 0.9]),
            (&[(0.2, 8), (0.4, 8)], &[0.089, 0.13]),
            // separated: three in the gap
            (&[(0.1, 0), (0.2, 0), (0.4, 8), (0.8, 8)], &[0.24, 0.28, 0.34]),
            // mixed at both ends
            (&[(0.2, 3), (0.3, 4), (0.4, 5)], &[0.13, 0.49, 0.6]),
            (&[(0.1, 0), (0.2, 2), (0.3, 4), (0.4, 6), (0.5, 8), (0.6, 8)], &[]),
        ] {
            let found = proposed(&evidence(tested));
            assert_eq!(found.levels, wanted, "{tested:?}");
            assert_eq!(found.records, LEAST_CLUSTERS);
        }
        assert_eq!(proposed(&evidence(&[(5.0, 0), (6.0, 0)])).levels, [9.0]);
    }

    #[test]
    fn the_number_of_records_is_that_of_the_stated_width() {
        let found = proposed(&evidence(&[(0.2, 0), (0.4, 0)]));
        assert_eq!(found.records_for_width, trials_for_width(WIDTH, 0.95));
        assert!((40..50).contains(&found.records_for_width), "{}", found.records_for_width);
    }
}
