//! Animation of the dam: data of the page's script.

use super::charts::crack_names;
use super::data::{Animation, Counted, MovingWater, Rounded, Series};
use super::folder::RunFolder;
use super::profile::points;
use super::profile_picture::tick;
use super::thinning::rounded;
use cofferdam_assembly::observer::{Histories, OutlineWriter};
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::Side;

/// Steps of a drawn value up to the largest.
const COUNTS: f64 = 4000.0;
/// Approximate maximum number of points at which the pressure on a face is drawn.
const POINTS: usize = 24;
/// Largest distance of a point of the outline from its face, m.
const NEAR: f64 = 1e-6;

/// Animation of `run`; `None` if its dam gave no outline, or the file of its motion is missing, damaged or from another run.
pub fn of(run: &RunFolder) -> Option<Animation> {
    let outline = &run.manifest.outline;
    let all: Vec<[f64; 2]> = outline.iter().flatten().copied().collect();
    let motion = Histories::read(&run.path.join(OutlineWriter::FILE)).ok()?;
    let histories = run.histories.column("time")?;
    // The histories of a killed run may end earlier.
    let last = histories.last()?;
    let times: Vec<f64> = motion.column("time")?.iter().copied().take_while(|time| time <= last).collect();
    if all.is_empty() || times.is_empty() || motion.names().len() != 1 + 2 * all.len() {
        return None;
    }
    let rows: Vec<Vec<f64>> = (0..times.len()).map(|row| motion.row(row)[1..].to_vec()).collect();
    let at = times.iter().map(|time| nearest(histories, *time)).collect::<Option<Vec<usize>>>()?;
    let reading = |name: String, column: &str, factor: f64| {
        let column = run.histories.column(column)?;
        let values: Vec<f64> = at.iter().map(|row| factor * column[*row]).collect();
        let moves = values.iter().any(|value| *value != 0.0);
        moves.then(|| Series { name, values: rounded(&values) })
    };
    let crest = run.histories.column("dam.crest_displacement.x")?;
    let out = |instant: &usize| crest[at[*instant]].abs();
    // Of equal ones the first.
    let first = (0..at.len()).rev().max_by(|a, b| out(a).total_cmp(&out(b)))?;
    let mut readings: Vec<Option<Series>> = vec![
        reading("ground, g".to_owned(), "ground_acceleration.x", 1.0 / STANDARD_GRAVITY),
        reading("ground upwards, g".to_owned(), "ground_acceleration.y", 1.0 / STANDARD_GRAVITY),
        reading("crest, mm".to_owned(), "dam.crest_displacement.x", 1e3),
    ];
    for (crack, name) in crack_names(&run.loaded.scene).into_iter().enumerate() {
        for what in ["sliding", "opening"] {
            readings.push(reading(format!("{name}: {what}, mm"), &format!("dam.crack_{what}.{crack}"), 1e3));
        }
    }
    let mut waters = Vec::new();
    let waters_of = run.loaded.scene.waters().filter(|(_, water)| !water.is_empty());
    for (side, _) in waters_of {
        let column = format!("{}.base_pressure", side.table());
        readings.push(reading(format!("{}: base pressure, kPa", side.table()), &column, 1e-3));
        waters.extend(water(run, side, &all, &at));
    }
    Some(Animation {
        outline: outline.iter().map(|of| of.iter().map(|point| point.map(Rounded)).collect()).collect(),
        first,
        motion: counted(&rows),
        waters,
        readings: readings.into_iter().flatten().collect(),
        times,
    })
}

/// The water on a `side` of the dam at the rows `at` of the histories; none if the run has no record of its pressure.
fn water(run: &RunFolder, side: Side, outline: &[[f64; 2]], at: &[usize]) -> Option<MovingWater> {
    let points = points(run, side);
    let file = run.path.join(format!("{}-interface_pressure.csv", side.table()));
    let pressures = Histories::read(&file).ok()?;
    if points.is_empty() || pressures.names().len() != 1 + points.len() {
        return None;
    }
    let step = points.len().div_ceil(POINTS);
    let mut chosen: Vec<usize> = (0..points.len()).step_by(step).collect();
    if chosen.last() != Some(&(points.len() - 1)) {
        chosen.push(points.len() - 1);
    }
    let rows: Vec<Vec<f64>> = at
        .iter()
        .filter(|row| **row < pressures.rows())
        .map(|row| pressures.row(*row))
        .map(|row| chosen.iter().map(|point| row[1 + point]).collect())
        .collect();
    if rows.len() != at.len() {
        return None;
    }
    let foot = points[0][1];
    let mut face: Vec<usize> = (0..outline.len()).filter(|point| is_on(outline[*point], points)).collect();
    face.sort_by(|a, b| outline[*a][1].total_cmp(&outline[*b][1]));
    Some(MovingWater {
        name: side.table().to_owned(),
        downstream: side == Side::Downstream,
        level: foot + run.loaded.scene.depth_of(side),
        face,
        points: chosen.iter().map(|point| points[*point].map(Rounded)).collect(),
        pressure: counted(&rows),
    })
}

/// Whether a point is on the line through `points`.
fn is_on([x, y]: [f64; 2], points: &[[f64; 2]]) -> bool {
    points.windows(2).any(|pair| {
        let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
        let (dx, dy) = (bx - ax, by - ay);
        let along = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (x - ax - along * dx).hypot(y - ay - along * dy) < NEAR
    })
}

/// The row of `times` (rising) that is nearest to `time`.
fn nearest(times: &[f64], time: f64) -> Option<usize> {
    let after = times.partition_point(|of| *of < time);
    let both = [after.checked_sub(1), Some(after).filter(|row| *row < times.len())];
    let away = |row: &usize| (times[*row] - time).abs();
    both.into_iter().flatten().min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// Rows in counts of 1, 2 or 5 times a power of ten; non-finite values count as 0.
fn counted(rows: &[Vec<f64>]) -> Counted {
    let values = rows.iter().flatten().filter(|value| value.is_finite());
    let largest = values.fold(0.0f64, |most, value| most.max(value.abs()));
    let unit = if largest > 0.0 { tick(largest, COUNTS) } else { 1.0 };
    let count = |value: &f64| if value.is_finite() { (value / unit).round() as i32 } else { 0 };
    let mut before = vec![0; rows.first().map_or(0, Vec::len)];
    let differences = |row: &Vec<f64>| {
        let counts: Vec<i32> = row.iter().map(count).collect();
        let steps = counts.iter().zip(&before).map(|(now, before)| now - before).collect();
        before = counts;
        steps
    };
    Counted { rows: rows.iter().map(differences).collect(), unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_to_the_values() {
        let rows = vec![vec![0.1234, -0.2, 0.0], vec![-0.3, f64::NAN, f64::INFINITY], vec![0.3999, 0.1, 0.2]];
        let counted = counted(&rows);
        assert_eq!(counted.unit, 1e-4, "0.4 in 4000 parts");
        let mut sum = [0; 3];
        for (row, steps) in rows.iter().zip(&counted.rows) {
            for ((value, sum), step) in row.iter().zip(&mut sum).zip(steps) {
                *sum += step;
                let value = if value.is_finite() { *value } else { 0.0 };
                assert!((f64::from(*sum) * counted.unit - value).abs() <= 0.5 * counted.unit + 1e-12);
            }
        }
        assert_eq!(super::counted(&[vec![0.0]]).rows, [[0]]);
    }

    #[test]
    fn the_nearest_row_and_points_on_a_face() {
        let times = [0.0, 1.0, 2.5];
        let found = [-1.0, 0.4, 0.6, 2.0, 9.0].map(|time| nearest(&times, time));
        assert_eq!(found, [Some(0), Some(0), Some(1), Some(2), Some(2)]);
        assert_eq!(nearest(&[], 0.0), None);
        let face = [[0.0, 0.0], [0.0, 10.0], [2.0, 20.0]];
        assert!(is_on([0.0, 3.0], &face) && is_on([1.0, 15.0], &face) && is_on([2.0, 20.0], &face));
        assert!(!is_on([0.0, 15.0], &face) && !is_on([0.0, -1.0], &face) && !is_on([2.2, 21.0], &face));
    }
}
