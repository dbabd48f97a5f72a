//! Verdict on a linear analysis by the demand-capacity criterion for gravity dams.

use super::super::Quantity;
use super::super::envelopes::{LARGEST_RATIO, LONGEST_OVER, MAJOR, RATIO, SHARE_OVER};
use super::charts::stress_names;
use super::data::{Abscissa, Chart, Check, Performance, Rounded, Series};
use super::folder::RunFolder;
use super::number::plain;
use super::thinning::rounded;
use cofferdam_assembly::vtk::Grid;
use cofferdam_assembly::{DCR, DcrCriterion, Status};
use cofferdam_scene::{DamScene, SectionScene};

/// Number of steps from the ratio 1 to the largest that is allowed.
const STEPS: usize = 20;
/// Elevations of the faces that differ by less than this share of the height are the same.
const SAME: f64 = 1e-6;

/// What a run demands of its concrete.
#[derive(Clone, Debug)]
struct Demand {
    /// Largest ratio of stress to strength anywhere.
    ratio: f64,
    /// Share of the section where the ratio exceeds 1, %.
    share: f64,
    /// Longest cumulative duration above the strength anywhere, s.
    duration: f64,
    /// Stress points that exceed their strength; `None` without histories of stress points.
    points: Option<Vec<Excess>>,
}

/// A stress point that exceeds its strength.
#[derive(Clone, Debug)]
struct Excess {
    /// Its name.
    name: String,
    /// Cumulative durations above each of the [`levels`], s.
    durations: Vec<f64>,
}

/// Verdict on the `overstress` of the envelope `grid`; `None` without a tensile strength.
pub fn of(run: &RunFolder, grid: &Grid, overstress: &[Quantity]) -> Option<Performance> {
    let value = |name: &str| overstress.iter().find(|of| of.name == name).map(|of| of.value);
    let demand = Demand {
        ratio: value(LARGEST_RATIO)?,
        share: value(SHARE_OVER)?,
        duration: value(LONGEST_OVER)?,
        points: excesses(run, grid),
    };
    let criteria = criteria(&demand, &DCR);
    let mut about = format!(
        "Criterion of {} for linear-elastic analyses in the time domain. Where a re-entrant corner (heel, toe, kink of a face) \
         governs, the verdict depends on the mesh, because the stress there grows as the mesh is refined.",
        DCR.document
    );
    let dam = run.loaded.scene.dam.as_ref();
    if dam.is_some_and(|dam| !dam.cracks.is_empty() && !dam.fidelity.is_intact()) {
        about += " Cracks of this run can open and slide, which a linear analysis does not include.";
    }
    Some(Performance {
        verdict: verdict(&criteria, demand.ratio, &DCR),
        about,
        criteria,
        durations: chart(demand.points.as_deref().unwrap_or_default(), &DCR),
    })
}

/// Ratios at which durations are compared: from 1 to the largest that is allowed.
fn levels(criterion: &DcrCriterion) -> Vec<f64> {
    (0..=STEPS).map(|step| 1.0 + (criterion.largest - 1.0) * step as f64 / STEPS as f64).collect()
}

/// The parts of the criterion: ratio, area, duration anywhere and durations at the stress points.
fn criteria(demand: &Demand, criterion: &DcrCriterion) -> Vec<Check> {
    let check =
        |name: &str, found: f64, unit: &'static str, limit: String, kept: bool, status: Status| Check {
            name: name.to_owned(),
            found,
            expected: None,
            unit,
            limit,
            kept: Some(kept),
            remark: status.sentence(),
        };
    let share = 100.0 * criterion.area;
    let at_one = criterion.allowed_duration(1.0);
    vec![
        check(
            LARGEST_RATIO,
            demand.ratio,
            "1",
            format!("at most {}", plain(criterion.largest)),
            demand.ratio <= criterion.largest,
            criterion.status,
        ),
        check(
            SHARE_OVER,
            demand.share,
            "%",
            format!("below {} %", plain(share)),
            demand.share < share,
            criterion.status,
        ),
        check(
            LONGEST_OVER,
            demand.duration,
            "s",
            format!("at most {} s", plain(at_one)),
            demand.duration <= at_one,
            criterion.curve_status,
        ),
        at_points(demand.points.as_deref(), criterion),
    ]
}

/// The durations at the stress points against the performance curve, at the point and level with the least margin.
fn at_points(points: Option<&[Excess]>, criterion: &DcrCriterion) -> Check {
    let levels = levels(criterion);
    let compared = points.unwrap_or_default().iter().flat_map(|point| {
        let allowed = levels.iter().map(|level| (*level, criterion.allowed_duration(*level)));
        let rows = point.durations.iter().zip(allowed);
        rows.map(|(duration, (level, allowed))| (&*point.name, level, *duration, allowed))
    });
    // A level that is not reached says nothing about the margin.
    let reached = compared.filter(|(.., duration, _)| *duration > 0.0);
    let worst = reached.max_by(|a, b| (a.2 - a.3).total_cmp(&(b.2 - b.3)));
    let (found, expected, what) = match (points, worst) {
        (None, _) => (f64::NAN, None, "not judged: the run has no histories of stress points".to_owned()),
        (_, None) => (0.0, None, "no stress point exceeds its tensile strength".to_owned()),
        (_, Some((name, level, duration, allowed))) => (
            duration,
            Some(allowed),
            format!("{name}, above DCR {level:.2}; {}", criterion.curve_status.sentence()),
        ),
    };
    Check {
        name: "duration at the stress points".to_owned(),
        found,
        expected,
        unit: "s",
        limit: "at most the performance curve".to_owned(),
        kept: points.map(|_| expected.is_none_or(|allowed| found <= allowed)),
        remark: what,
    }
}

/// The verdict in words, for the largest `ratio` of stress to strength.
fn verdict(criteria: &[Check], ratio: f64, criterion: &DcrCriterion) -> String {
    let of = |kept: Option<bool>| -> Vec<&str> {
        criteria.iter().filter(|check| check.kept == kept).map(|check| &*check.name).collect()
    };
    let (failed, open) = (of(Some(false)), of(None));
    let words = if !failed.is_empty() {
        let failed = failed.join(", ");
        format!("not acceptable by a linear analysis: nonlinear analysis is needed (failed: {failed})")
    } else if !open.is_empty() {
        format!("none (not judged: {})", open.join(", "))
    } else if ratio <= 1.0 {
        "acceptable: minor or no damage".to_owned()
    } else {
        "acceptable: limited cracking where the strength is exceeded".to_owned()
    };
    let numbers = [("ratio and area", criterion.status), ("performance curve", criterion.curve_status)];
    let status = numbers.map(|(what, status)| format!("{what} {}", status.label()));
    format!("Verdict: {words}. {}; {}.", criterion.document, status.join(", "))
}

/// Cumulative durations over the ratio, and the performance curve; none if no point exceeds its strength.
fn chart(points: &[Excess], criterion: &DcrCriterion) -> Option<Chart> {
    if points.is_empty() {
        return None;
    }
    let levels = levels(criterion);
    let allowed: Vec<f64> = levels.iter().map(|level| criterion.allowed_duration(*level)).collect();
    let curve = format!("performance curve, {}, {}", criterion.document, criterion.curve_status.label());
    let lines = points.iter().map(|point| (point.name.clone(), &point.durations));
    Some(Chart {
        title: "Cumulative duration above a demand-capacity ratio (DCR), s".to_owned(),
        about:
            "Stress points that exceed their tensile strength; stress is linear between communication steps."
                .to_owned(),
        abscissa: Abscissa::Numbers {
            name: "DCR",
            values: levels.iter().map(|level| Rounded((level * 1e6).round() / 1e6)).collect(),
        },
        logarithmic: false,
        range: None,
        series: lines
            .chain([(curve, &allowed)])
            .map(|(name, values)| Series { name, values: rounded(values) })
            .collect(),
        marks: Vec::new(),
    })
}

/// Time during which a history, linear between its samples, is above `level`, s.
fn duration_above(time: &[f64], values: &[f64], level: f64) -> f64 {
    let steps = time.windows(2).zip(values.windows(2));
    let parts = steps.map(|(time, values)| {
        let (from, to) = (values[0] - level, values[1] - level);
        let share = match (from > 0.0, to > 0.0) {
            (true, true) => 1.0,
            (true, false) => from / (from - to),
            (false, true) => to / (to - from),
            (false, false) => 0.0,
        };
        share * (time[1] - time[0])
    });
    // An empty sum is -0.
    0.0 + parts.sum::<f64>()
}

/// The stress points whose stress exceeds the strength; `None` without histories of stress points.
fn excesses(run: &RunFolder, grid: &Grid) -> Option<Vec<Excess>> {
    let dam = run.loaded.scene.dam.as_ref()?;
    let time = run.histories.column("time")?;
    let column = |point: usize| run.histories.column(&format!("dam.major_principal_stress.{point}"));
    let histories: Vec<&[f64]> = (0..).map_while(column).collect();
    if histories.is_empty() {
        return None;
    }
    let peaks: Vec<f64> =
        histories.iter().map(|of| of.iter().copied().fold(f64::NEG_INFINITY, f64::max)).collect();
    let (strengths, names) = (strengths(dam, grid, &peaks), stress_names(run));
    let points = (0..histories.len()).filter_map(|point| {
        let strength = strengths[point].filter(|strength| peaks[point] > *strength)?;
        let above = |level: &f64| duration_above(time, histories[point], level * strength);
        Some(Excess {
            name: names.get(point).cloned().unwrap_or_else(|| format!("point {point}")),
            durations: levels(&DCR).iter().map(above).collect(),
        })
    });
    Some(points.collect())
}

/// Tensile strength at each stress point, Pa, whose largest stresses are `peaks`; `None` where there is none, or never tension.
fn strengths(dam: &DamScene, grid: &Grid, peaks: &[f64]) -> Vec<Option<f64>> {
    let general = dam.material.tensile_strength;
    let own: Vec<f64> = dam.zones.iter().filter_map(|zone| zone.tensile_strength).collect();
    if own.is_empty() {
        return vec![general; peaks.len()];
    }
    let places = stress_points(&dam.section);
    if places.len() != peaks.len() {
        // Points of another program: the lowest strength of all.
        return vec![own.into_iter().chain(general).reduce(f64::min); peaks.len()];
    }
    places.iter().zip(peaks).map(|(place, peak)| strength_at(grid, *place, *peak)).collect()
}

/// The strength with which the envelope compared the stress at the node next to `place`, Pa; where a crack divides nodes, that of the
/// node whose largest stress is next to `peak`. `None` if the stress there was never tension.
fn strength_at(grid: &Grid, [x, y]: [f64; 2], peak: f64) -> Option<f64> {
    let (major, ratio) = (grid.point_field(MAJOR)?, grid.point_field(RATIO)?);
    let away = |node: &usize| (grid.points[*node][0] - x).hypot(grid.points[*node][1] - y);
    let off = |node: &usize| (major[*node] - peak).abs();
    let nodes = 0..grid.points.len();
    let node = nodes.min_by(|a, b| away(a).total_cmp(&away(b)).then(off(a).total_cmp(&off(b))))?;
    (ratio[node] > 0.0).then(|| major[node] / ratio[node])
}

/// Where a dam with this section computes stresses: heel and toe, then both faces at each elevation at which one of them bends.
fn stress_points(section: &SectionScene) -> Vec<[f64; 2]> {
    let faces = [&section.upstream, &section.downstream];
    let mut bends: Vec<f64> = faces.iter().flat_map(|face| face.iter().map(|point| point[1])).collect();
    let height = bends.iter().copied().fold(0.0, f64::max);
    let same = SAME * height;
    bends.retain(|y| *y > same && *y < height - same);
    bends.sort_by(f64::total_cmp);
    bends.dedup_by(|a, b| *a - *b < same);
    let levels = std::iter::once(0.0).chain(bends);
    levels.flat_map(|level| faces.map(|face| on_face(face, level, same))).flatten().collect()
}

/// The lowest point of a face at an elevation; its end if it does not reach there.
fn on_face(face: &[[f64; 2]], y: f64, same: f64) -> Option<[f64; 2]> {
    if let Some(vertex) = face.iter().find(|point| (point[1] - y).abs() <= same) {
        return Some(*vertex);
    }
    let crossing = face.windows(2).find(|pair| (pair[0][1] < y) != (pair[1][1] < y));
    let within = crossing.map(|pair| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        [x0 + (x1 - x0) * (y - y0) / (y1 - y0), y]
    });
    within.or_else(|| face.last().copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_assembly::vtk::Field;

    /// All limits are kept, with the largest values that are allowed.
    fn at_the_limits() -> Demand {
        let share = 100.0 * DCR.area * (1.0 - f64::EPSILON);
        let durations = levels(&DCR).iter().map(|level| DCR.allowed_duration(*level)).collect();
        let points = Some(vec![Excess { name: "heel".to_owned(), durations }]);
        Demand { ratio: DCR.largest, share, duration: DCR.allowed_duration(1.0), points }
    }

    fn failed(demand: &Demand) -> Vec<String> {
        let criteria = criteria(demand, &DCR);
        criteria.into_iter().filter(|check| check.kept != Some(true)).map(|check| check.name).collect()
    }

    fn words(demand: &Demand) -> String {
        verdict(&criteria(demand, &DCR), demand.ratio, &DCR)
    }

    #[test]
    fn triangular_history_is_above_a_level_for_its_share_of_the_base() {
        // Two samples at the foot, and the peak anywhere between them.
        for (peak_at, width, peak) in [(1.0, 2.0, 4.0), (0.25, 1.0, 2.0), (0.5, 4.0, 8.0)] {
            let (time, stress) = ([0.0, 1.0, 1.0 + peak_at, 1.0 + width, 9.0], [0.0, 0.0, peak, 0.0, 0.0]);
            for level in [0.0, 0.5, 1.0, 1.5, 2.0] {
                let exact = width * (1.0 - level / peak);
                let found = duration_above(&time, &stress, level);
                assert!((found - exact).abs() < 1e-15, "{found} s above {level} of {peak}, exact {exact} s");
            }
            assert_eq!(duration_above(&time, &stress, peak), 0.0);
            assert_eq!(duration_above(&time, &stress, 2.0 * peak), 0.0);
        }
    }

    #[test]
    fn durations_of_all_excursions_add_up() {
        let time: Vec<f64> = (0..7).map(f64::from).collect();
        let stress = [3.0, 3.0, 1.0, -1.0, 3.0, 3.0, 2.0];
        // 1 s and 1/2 s; 1/4 s, 1 s, and 1 s until the level is reached.
        assert_eq!(duration_above(&time, &stress, 2.0), 3.75);
        assert_eq!(duration_above(&[], &[], 2.0), 0.0);
    }

    #[test]
    fn demand_at_the_limits_is_acceptable() {
        let demand = at_the_limits();
        assert!(failed(&demand).is_empty(), "{:?}", failed(&demand));
        assert!(words(&demand).starts_with("Verdict: acceptable: limited cracking"), "{}", words(&demand));
        let below = Demand { ratio: 1.0, share: 0.0, duration: 0.0, points: Some(Vec::new()) };
        let said = words(&below);
        assert!(said.starts_with("Verdict: acceptable: minor or no damage. USACE EM 1110-2-6051"), "{said}");
        assert!(said.contains("performance curve to be confirmed"), "{said}");
        assert_eq!(chart(&[], &DCR), None);
        let remark = &criteria(&below, &DCR)[3].remark;
        assert_eq!(remark, "no stress point exceeds its tensile strength");
    }

    #[test]
    fn each_criterion_fails_beyond_its_limit() {
        let kept = at_the_limits();
        let more = |value: f64| value * (1.0 + f64::EPSILON);
        let longer = |level: usize| {
            let mut points = kept.points.clone().unwrap_or_default();
            points[0].durations[level] += 1e-12;
            Demand { points: Some(points), ..kept.clone() }
        };
        for (demand, name) in [
            (Demand { ratio: more(kept.ratio), ..kept.clone() }, LARGEST_RATIO),
            (Demand { share: 100.0 * DCR.area, ..kept.clone() }, SHARE_OVER),
            (Demand { duration: more(kept.duration), ..kept.clone() }, LONGEST_OVER),
            (longer(0), "duration at the stress points"),
            (longer(7), "duration at the stress points"),
            (longer(STEPS), "duration at the stress points"),
        ] {
            assert_eq!(failed(&demand), [name]);
            let said = words(&demand);
            assert!(said.contains("nonlinear analysis is needed") && said.contains(name), "{said}");
        }
        let worst = &criteria(&longer(7), &DCR)[3];
        assert!(worst.remark.starts_with("heel, above DCR 1.35"), "{}", worst.remark);
    }

    #[test]
    fn missing_histories_give_no_verdict() {
        let demand = Demand { points: None, ..at_the_limits() };
        assert!(words(&demand).starts_with("Verdict: none"), "{}", words(&demand));
        let failing = Demand { share: 20.0, ..demand };
        assert!(words(&failing).contains(SHARE_OVER), "{}", words(&failing));
    }

    #[test]
    fn chart_has_the_points_and_the_named_curve() {
        let points = at_the_limits().points.unwrap_or_default();
        let chart = chart(&points, &DCR).expect("a chart");
        let names: Vec<&str> = chart.series.iter().map(|line| &*line.name).collect();
        assert_eq!(names, ["heel", "performance curve, USACE EM 1110-2-6051 (2003), to be confirmed"]);
        let Abscissa::Numbers { values, .. } = &chart.abscissa else { panic!("numbers") };
        assert_eq!([values[0], values[1], values[STEPS]], [1.0, 1.05, 2.0].map(Rounded));
        let curve: Vec<f64> = chart.series[1].values.iter().map(|value| value.0).collect();
        assert_eq!([curve[0], curve[10], curve[STEPS]], [0.3, 0.15, 0.0]);
    }

    #[test]
    fn stress_points_are_heel_toe_and_bends_of_both_faces() {
        let section = SectionScene {
            upstream: vec![[0.0, 0.0], [0.0, 103.0]],
            downstream: vec![[70.0, 0.0], [19.25, 66.5], [14.8, 103.0]],
            galleries: Vec::new(),
        };
        assert_eq!(stress_points(&section), [[0.0, 0.0], [70.0, 0.0], [0.0, 66.5], [19.25, 66.5]]);
    }

    #[test]
    fn strength_at_a_point_is_that_of_the_envelope() {
        // Two nodes at one place, divided by a crack.
        let grid = Grid {
            points: vec![[0.0, 0.0], [0.0, 10.0], [0.0, 10.0], [5.0, 0.0]],
            point_data: vec![
                Field::scalar(MAJOR, vec![3e6, 4e6, 1e6, -1e5]),
                Field::scalar(RATIO, vec![1.5, 4.0, 0.25, 0.0]),
            ],
            ..Grid::default()
        };
        assert_eq!(strength_at(&grid, [0.1, 0.0], 3e6), Some(2e6));
        assert_eq!(strength_at(&grid, [0.0, 10.0], 4e6), Some(1e6));
        assert_eq!(strength_at(&grid, [0.0, 10.0], 1e6), Some(4e6));
        assert_eq!(strength_at(&grid, [5.0, 0.0], -1e5), None);
    }
}
