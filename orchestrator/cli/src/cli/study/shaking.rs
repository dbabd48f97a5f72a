//! `cofferdam study shaking`.

mod figure;

use super::{Arguments, CREST, SLIDING, StudyError, moments, quoted, run_all, unfit};
use crate::cli::say;
use crate::cli::table::Table;
use cofferdam_assembly::read_scene;

pub const HELP: &str = "\
Runs the scene with its record scaled by 100 factors from 0.90 to 1.10, with either polarity: how far sliding and crest motion
scatter with the shaking, which no mesh or time step changes, and whether every run reaches its end. Sliding is that of the
lowest crack.

Writes shaking.md, shaking.csv and shaking.svg.

Example:
  cofferdam study shaking scenes/koyna-northridge-1994 --output studies/shaking

Exit status: 0, 1 results could not be written, 2 the scene is wrong or does not fit, 3 a run failed, 4 a unit cannot be
made.";

/// Range of the factors.
const RANGE: [f64; 2] = [0.9, 1.1];
/// Half the width of the window over which neighbours are compared, as a factor.
const NEAR: f64 = 0.01;

/// One run: factor, largest crest motion (mm), sliding at the end (mm).
type Point = [f64; 3];

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let Some(record) = &loaded.scene.ground_motion.record else {
        return Err(unfit("the study needs a record as ground motion"));
    };
    if loaded.scene.dam.as_ref().is_none_or(|dam| dam.cracks.is_empty()) {
        return Err(unfit("the study needs a dam with a crack"));
    }
    let count = if arguments.coarse { 5 } else { 100 };
    let factors: Vec<f64> =
        (0..count).map(|i| RANGE[0] + (RANGE[1] - RANGE[0]) * f64::from(i) / f64::from(count - 1)).collect();
    let mut table = Table::new([
        "polarity",
        "runs",
        "failed",
        "steps in which another acceleration took over",
        "crest: mean, scatter",
        "sliding: mean, scatter",
        "scatter of sliding within ± 1 % of shaking",
    ]);
    let mut every =
        Table::new(["polarity", "factor", "crest, mm", "sliding, mm", "dam steps a step", "ended"]);
    let mut series = Vec::new();
    let mut failures = Vec::new();
    for polarity in [record.polarity, -record.polarity] {
        // All scenes are checked before anything is computed.
        let scenes = factors.iter().map(|factor| {
            let sets = [
                format!("ground_motion.record.scale={}", factor * record.scale),
                format!("ground_motion.record.polarity={polarity}"),
            ];
            read_scene(&arguments.scene, &[&arguments.set[..], &sets].concat())
        });
        let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
        let outcomes = run_all(&scenes)?;
        let (mut points, mut took_over, mut failed) = (Vec::new(), 0, 0);
        for (factor, outcome) in factors.iter().zip(&outcomes) {
            let crest = 1e3 * outcome.peak(CREST);
            let sliding = 1e3 * outcome.last(SLIDING);
            took_over += outcome.ending.statistics.fallbacks;
            match &outcome.failure {
                None => points.push([*factor, crest, sliding]),
                Some(why) => {
                    failed += 1;
                    failures.push(format!("polarity {polarity}, factor {factor:.4}: {why}"));
                }
            }
            every.row([
                polarity.to_string(),
                format!("{factor:.4}"),
                format!("{crest:.2}"),
                format!("{sliding:.2}"),
                format!("{:.3}", outcome.iterations(1)),
                outcome.ending.status.to_string(),
            ]);
        }
        let cell = |index: usize| {
            let [mean, deviation] = moments(points.iter().map(|point| point[index]));
            format!("{mean:.1} mm, {:.0} %", 100.0 * deviation / mean.abs())
        };
        table.row([
            polarity.to_string(),
            outcomes.len().to_string(),
            failed.to_string(),
            took_over.to_string(),
            cell(1),
            cell(2),
            format!("{:.0} %", 100.0 * local_scatter(&points)),
        ]);
        series.push((polarity, points));
    }
    let failures = if failures.is_empty() { "none".to_owned() } else { failures.join("; ") };
    let text = format!(
        "`cofferdam study shaking {}{}`: {count} factors on the shaking from {} to {}\n\n{}\n\
         Scatter: standard deviation over the mean; within ± 1 % of shaking, about the straight line through the runs there. Runs \
         that did not reach their end: {failures}.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        RANGE[0],
        RANGE[1],
        table.markdown(),
    );
    say(&text);
    arguments.write("shaking.md", &text)?;
    arguments.write_table("shaking.csv", &every)?;
    arguments.write("shaking.svg", &figure::picture(&series)?)
}

/// Root mean square over all runs of the standard deviation of sliding about a straight line through the runs whose
/// factor differs by at most [`NEAR`], over the mean there. Runs without three neighbours do not count.
fn local_scatter(points: &[Point]) -> f64 {
    let of_run = |centre: &Point| {
        let near: Vec<[f64; 2]> = points
            .iter()
            .filter(|point| (point[0] - centre[0]).abs() <= NEAR * 1.001)
            .map(|[factor, _, sliding]| [*factor, *sliding])
            .collect();
        if near.len() < 4 {
            return None;
        }
        let [x, _] = moments(near.iter().map(|point| point[0]));
        let [y, _] = moments(near.iter().map(|point| point[1]));
        let square = near.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>();
        let slope = near.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>() / square;
        let rest = near.iter().map(|point| (point[1] - y - slope * (point[0] - x)).powi(2)).sum::<f64>();
        // two parameters of the line
        Some(rest / (near.len() - 2) as f64 / (y * y))
    };
    let squares: Vec<f64> = points.iter().filter_map(of_run).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_does_not_scatter_and_noise_does() {
        let line = |noise: f64| -> Vec<Point> {
            let sign = |i: i32| if i % 2 == 0 { noise } else { -noise };
            (0..100).map(|i| [0.9 + 0.002 * f64::from(i), 0.0, 100.0 + f64::from(i) + sign(i)]).collect()
        };
        assert!(local_scatter(&line(0.0)) < 1e-10);
        let found = local_scatter(&line(15.0));
        assert!((found / 0.1 - 1.0).abs() < 0.2, "{found}");
        assert_eq!(local_scatter(&line(15.0)[..3]), 0.0);
    }
}
