//! Positions of the points of one face on another.

use super::MappingError;
use cofferdam_unit::WetFace;

/// Distance of two points, m.
pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Positions of the points along the face, m from its start.
pub(super) fn arc_lengths(face: &WetFace) -> Vec<f64> {
    let mut position = 0.0;
    let further = face.points().windows(2).map(|pair| {
        position += distance(pair[0], pair[1]);
        position
    });
    std::iter::once(0.0).chain(further).collect()
}

/// Positions (m from its start) of the points of `face`, the face of the first of `units`, along the face of the
/// other.
///
/// **Errors**: a point is more than `most` (m) away from it; the furthest one is named.
pub(super) fn located(
    [unit, other]: [&str; 2],
    face: &WetFace,
    along: &WetFace,
    most: f64,
) -> Result<Vec<f64>, MappingError> {
    let positions = arc_lengths(along);
    let nearest = |&point: &[f64; 2]| {
        let on_panels = along.panels().map(|panel| {
            let (i, j) = (panel.start, panel.start + 1);
            let (a, b) = (along.points()[i], along.points()[j]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            // From 0 to 1, exact at the ends.
            let t = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy);
            let at = |a: f64, b: f64| a * (1.0 - t.clamp(0.0, 1.0)) + b * t.clamp(0.0, 1.0);
            (distance(point, [at(a[0], b[0]), at(a[1], b[1])]), at(positions[i], positions[j]))
        });
        on_panels.fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a })
    };
    let (distances, positions): (Vec<f64>, Vec<f64>) = face.points().iter().map(nearest).unzip();
    match distances.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((index, distance)) if distance > most => {
            let [x, y] = face.points()[index];
            Err(MappingError::Apart {
                unit: unit.to_owned(),
                other: other.to_owned(),
                index,
                x,
                y,
                distance,
                most,
            })
        }
        _ => Ok(positions),
    }
}

/// Refuses panels that are not longer than `least` (m) between their `positions`.
pub(super) fn check_panels(
    unit: &str,
    face: &WetFace,
    positions: &[f64],
    least: f64,
) -> Result<(), MappingError> {
    let length = |index: usize| positions[index + 1] - positions[index];
    match face.panels().map(|panel| panel.start).find(|start| length(*start) <= least) {
        Some(index) => {
            let ([x, y], length) = (face.points()[index], length(index));
            Err(MappingError::ShortPanel { unit: unit.to_owned(), index, x, y, length, least })
        }
        None => Ok(()),
    }
}
