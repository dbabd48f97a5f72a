use super::exact::clustered;
use std::collections::BTreeMap;

/// One run: how strong the shaking was, and whether the limit was exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Intensity measure, positive.
    pub intensity: f64,
    /// Number of its level of shaking.
    pub level: usize,
    /// Whether the limit was exceeded.
    pub exceeded: bool,
    /// Clusters of dependent runs, such as those of one record.
    pub cluster: usize,
}

/// Runs of one level of shaking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exceedance {
    /// Intensity, the geometric mean where the runs of the level differ.
    pub intensity: f64,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that exceed the limit.
    pub exceeding: usize,
    /// Number of independent clusters of runs.
    pub clusters: usize,
    /// Mean of the clusters' shares of runs that exceed the limit.
    pub share: f64,
    /// Its exact interval, with the clusters as trials.
    pub interval: [f64; 2],
}

impl Exceedance {
    /// Whether at least one cluster's worth of runs exceeds the limit and at least one does not: such a level says how steep the curve is.
    pub fn is_mixed(&self) -> bool {
        let (exceeding, all) = (self.share * self.clusters as f64, self.clusters as f64);
        exceeding >= 1.0 - 1e-9 && all - exceeding >= 1.0 - 1e-9
    }
}

/// Number of groups into which runs of different intensities are sorted.
const GROUPS: usize = 6;

/// Whether all runs of each level have the same intensity.
pub fn have_common_levels(runs: &[Outcome]) -> bool {
    let mut of_level: BTreeMap<usize, f64> = BTreeMap::new();
    runs.iter().all(|run| *of_level.entry(run.level).or_insert(run.intensity) == run.intensity)
}

/// The exceedances of each level, by ascending intensity: of runs whose levels are factors on records of different strength, the
/// exceedances of six equally large groups by intensity.
pub fn exceedances(runs: &[Outcome], confidence: f64) -> Vec<Exceedance> {
    let mut sorted: Vec<&Outcome> = runs.iter().collect();
    sorted.sort_by(|a, b| a.intensity.total_cmp(&b.intensity));
    let groups: Vec<&[&Outcome]> = if have_common_levels(runs) {
        sorted.chunk_by(|a, b| a.intensity == b.intensity).collect()
    } else {
        sorted.chunks(sorted.len().div_ceil(GROUPS).max(1)).collect()
    };
    groups.into_iter().map(|runs| exceedance(runs, confidence)).collect()
}

/// The exceedance of the runs of one level.
pub fn exceedance(runs: &[&Outcome], confidence: f64) -> Exceedance {
    let mut clusters: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    for run in runs {
        let [exceeding, all] = clusters.entry(run.cluster).or_default();
        *exceeding += f64::from(u8::from(run.exceeded));
        *all += 1.0;
    }
    let sum: f64 = clusters.values().map(|[exceeding, all]| exceeding / all).sum();
    let logarithms: f64 = runs.iter().map(|run| run.intensity.ln()).sum();
    let first = runs.first().map_or(f64::NAN, |run| run.intensity);
    let is_common = runs.iter().all(|run| run.intensity == first);
    Exceedance {
        intensity: if is_common { first } else { (logarithms / runs.len() as f64).exp() },
        runs: runs.len(),
        exceeding: runs.iter().filter(|run| run.exceeded).count(),
        clusters: clusters.len(),
        share: sum / clusters.len() as f64,
        interval: clustered(sum, clusters.len(), confidence),
    }
}

/// Interval that holds the intensity at which half of the runs exceed the limit with at least the confidence of the levels' intervals, for any
/// curve that rises: from the highest level whose interval lies below one half to the lowest one whose interval lies above. Its
/// ends are 0 and infinite without such a level.
///
/// Of records that are scaled to all levels, and exceed the limit at every level above their first, the share at a level is never below that
/// of a weaker one. An end is wrong only if the interval of the next level on the other side of the truth is, so that several levels do
/// not add to the error.
pub fn median_bracket(levels: &[Exceedance]) -> [f64; 2] {
    let below = levels.iter().filter(|level| level.interval[1] < 0.5);
    let above = levels.iter().filter(|level| level.interval[0] > 0.5);
    [
        below.map(|level| level.intensity).fold(0.0, f64::max),
        above.map(|level| level.intensity).fold(f64::INFINITY, f64::min),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(of: &[(f64, usize, bool)]) -> Vec<Outcome> {
        let levels = [0.1, 0.2, 0.4];
        let run = |(intensity, cluster, exceeded): &(f64, usize, bool)| Outcome {
            intensity: *intensity,
            level: levels.iter().position(|level| level == intensity).expect("a level"),
            exceeded: *exceeded,
            cluster: *cluster,
        };
        of.iter().map(run).collect()
    }

    #[test]
    fn records_count_once_however_many_runs_they_have() {
        // A record with three runs, one of which exceeds, and a record with a single run that exceeds.
        let found = exceedances(
            &runs(&[(0.2, 0, true), (0.2, 0, false), (0.2, 0, false), (0.2, 1, true), (0.1, 0, false)]),
            0.95,
        );
        assert_eq!(found.iter().map(|level| level.intensity).collect::<Vec<_>>(), [0.1, 0.2]);
        let level = found[1];
        assert_eq!((level.runs, level.exceeding, level.clusters), (4, 2, 2));
        assert!((level.share - (1.0 / 3.0 + 1.0) / 2.0).abs() < 1e-12);
        // 1.33 of 2: from the lower end of 1 to the upper end of 2.
        assert!((level.interval[0] - (1.0 - 0.975f64.sqrt())).abs() < 1e-9, "{level:?}");
        assert_eq!(level.interval[1], 1.0);
        assert!(!level.is_mixed() && !found[0].is_mixed());
    }

    #[test]
    fn six_records_bracket_the_median_and_five_do_not() {
        let of = |records: usize| -> Vec<Exceedance> {
            let runs: Vec<_> = (0..records)
                .flat_map(|record| {
                    [(0.1, record, false), (0.2, record, record % 2 == 0), (0.4, record, true)]
                })
                .collect();
            exceedances(&self::runs(&runs), 0.95)
        };
        assert_eq!(median_bracket(&of(6)), [0.1, 0.4]);
        assert_eq!(median_bracket(&of(5)), [0.0, f64::INFINITY]);
    }

    #[test]
    fn runs_of_different_intensities_are_grouped() {
        let runs: Vec<Outcome> = (0..20)
            .map(|i| Outcome { intensity: 0.1 + 0.01 * i as f64, level: 0, exceeded: i >= 10, cluster: i })
            .collect();
        assert!(!have_common_levels(&runs));
        let groups = exceedances(&runs, 0.95);
        assert_eq!(groups.iter().map(|group| group.exceeding).collect::<Vec<_>>(), [0, 0, 2, 4, 4]);
        assert!(groups.windows(2).all(|pair| pair[0].intensity < pair[1].intensity));
    }
}
