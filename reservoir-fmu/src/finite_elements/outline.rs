use crate::{ReservoirError, ReservoirParameters};
use std::f64::consts::LN_2;

/// Most edges on the outline, before they are made small at the corners.
const MOST_EDGES: f64 = 2e4;

/// What a piece of the outline is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The dam's wet face.
    Face,
    /// The water level.
    Surface,
    /// The vertical end upstream.
    FarEnd,
    /// The bed.
    Bed,
}

/// A straight piece of the outline.
#[derive(Clone, Debug)]
pub struct Piece {
    /// What it is.
    pub part: Part,
    /// Its points (m), from its start up to, but without, its end, where the next piece starts.
    pub points: Vec<[f64; 2]>,
    /// Length of wet face below it, m; of use on the face only.
    pub arc: f64,
}

/// The water's outline, counterclockwise from the heel: up the face, upstream along the level, down the far
/// end, along the bed back to the heel; every piece divided for the triangulation.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The pieces.
    pub pieces: Vec<Piece>,
    /// Area of the water, m².
    pub area: f64,
}

impl Outline {
    /// That of the parameters' water; the far end stands `far_end_distance` upstream of the most upstream
    /// point of face and bed. Pieces of the face end at kinks and coinciding points.
    ///
    /// **Errors**: [`ReservoirError::Section`].
    pub fn new(parameters: &ReservoirParameters) -> Result<Self, ReservoirError> {
        let face = &parameters.wet_face;
        let heel = [0.0, 0.0];
        let bed: Vec<[f64; 2]> = parameters.bed.iter().copied().skip_while(|p| *p == heel).collect();
        for &[x, y] in &bed {
            if !(x.is_finite() && y < face.depth() && y.is_finite()) {
                return Err(ReservoirError::Section { x, y });
            }
        }
        let most_upstream = face.points().iter().chain(&bed).fold(0.0, |x: f64, p| x.min(p[0]));
        let far = most_upstream - parameters.far_end_distance;
        let last = bed.last().map_or(0.0, |p| p[1]);

        let size = parameters.element_size;
        let bed_size = parameters.bed_element_size.unwrap_or(size);
        let corner = parameters.corner_element_size;
        let mut corners = Vec::new();
        let mut arc = 0.0;
        for [first, end] in face.straight_pieces() {
            corners.push((face.points()[first], Part::Face, arc, size, [corner, corner]));
            arc += distance(face.points()[first], face.points()[end]);
        }
        corners.push((face.points()[face.len() - 1], Part::Surface, 0.0, bed_size, [None, None]));
        corners.push(([far, face.depth()], Part::FarEnd, 0.0, bed_size, [None, None]));
        // The far end's foot is a right angle in a smooth field: nothing to make small.
        corners.push(([far, last], Part::Bed, 0.0, bed_size, [None, corner]));
        corners.extend(bed.iter().rev().map(|p| (*p, Part::Bed, 0.0, bed_size, [corner, corner])));

        let ends: Vec<[f64; 2]> = corners.iter().map(|c| c.0).collect();
        let area = check_simple(&ends)?;
        let side = |i: usize| distance(ends[i], ends[(i + 1) % ends.len()]);
        let edges: f64 = corners.iter().enumerate().map(|(i, corner)| side(i) / corner.3).sum();
        if edges > MOST_EDGES {
            let remedy = "raise `element_size`, or lower `far_end_distance`";
            let what = "edges of finite elements on the outline";
            return Err(ReservoirError::TooMuch { what, value: edges, most: MOST_EDGES, remedy });
        }
        let pieces = corners.iter().enumerate().map(|(i, &(start, part, arc, size, corners))| {
            let end = ends[(i + 1) % ends.len()];
            let points = division(distance(start, end), size, corners)
                .into_iter()
                .map(|t| [0, 1].map(|axis| start[axis] * (1.0 - t) + end[axis] * t));
            Piece { part, points: points.collect(), arc }
        });
        Ok(Self { pieces: pieces.collect(), area })
    }
}

pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn cross(o: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

/// The polygon's area (m²), if its sides meet at their ends only and it goes round counterclockwise.
fn check_simple(corners: &[[f64; 2]]) -> Result<f64, ReservoirError> {
    let n = corners.len();
    let side = |i: usize| [corners[i], corners[(i + 1) % n]];
    // Points closer to a line than this share of the outline's extent count as on it.
    let extent = corners.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
    let nearly = 1e-12 * extent * extent;
    let beside = |[a, b]: [[f64; 2]; 2], p: [f64; 2]| {
        let c = cross(a, b, p);
        if c.abs() <= nearly { 0.0 } else { c.signum() }
    };
    let overlap = |[a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]| {
        [0, 1].iter().all(|&k| a[k].min(b[k]) <= c[k].max(d[k]) && c[k].min(d[k]) <= a[k].max(b[k]))
    };
    for i in 0..n {
        let [a, b] = side(i);
        let refused = Err(ReservoirError::Section { x: b[0], y: b[1] });
        let next = corners[(i + 2) % n];
        let back = (a[0] - b[0]) * (next[0] - b[0]) + (a[1] - b[1]) * (next[1] - b[1]);
        if distance(a, b) <= 1e-9 * extent || beside([a, b], next) == 0.0 && back > 0.0 {
            return refused;
        }
        for j in i + 2..n {
            let [c, d] = side(j);
            let adjacent = i == 0 && j == n - 1;
            let crosses = beside([a, b], c) * beside([a, b], d) <= 0.0
                && beside([c, d], a) * beside([c, d], b) <= 0.0
                && overlap([a, b], [c, d]);
            if crosses && !adjacent {
                return refused;
            }
        }
    }
    let area = (0..n).map(|i| cross([0.0; 2], side(i)[0], side(i)[1])).sum::<f64>() / 2.0;
    if area > 0.0 { Ok(area) } else { Err(ReservoirError::Section { x: corners[0][0], y: corners[0][1] }) }
}

/// Where (as a share of `length`, from 0, without 1) a piece is divided: elements no longer than `size`, of at most
/// the corner's size at an end that has one, and from there each at most twice as long as the one before.
///
/// Elements of equal share of `∫ dt/h(t)`, `h = min(size, (c + t) ln 2)`: the first is c long, the next 2c, 4c, …
fn division(length: f64, size: f64, corners: [Option<f64>; 2]) -> Vec<f64> {
    // Count of elements from an end at t = 0 up to t, and its inverse.
    let count = |corner: Option<f64>, t: f64| match corner {
        Some(c) if (c + t) * LN_2 <= size => ((c + t) / c).log2(),
        Some(c) if c * LN_2 < size => {
            let graded = size / LN_2 - c;
            ((c + graded) / c).log2() + (t - graded) / size
        }
        _ => t / size,
    };
    let position = |corner: Option<f64>, elements: f64| match corner {
        Some(c) if c * LN_2 < size => {
            let graded = size / LN_2 - c;
            let of_graded = ((c + graded) / c).log2();
            if elements <= of_graded {
                c * (elements.exp2() - 1.0)
            } else {
                graded + (elements - of_graded) * size
            }
        }
        _ => elements * size,
    };
    // Up to where the lengths grow from the start; beyond they grow from the end.
    let meeting = match corners {
        [Some(c), Some(d)] => (0.5 * (length + d - c)).clamp(0.0, length),
        [Some(_), None] => length,
        [None, Some(_)] => 0.0,
        [None, None] => 0.5 * length,
    };
    let halves = [count(corners[0], meeting), count(corners[1], length - meeting)];
    let whole = halves[0] + halves[1];
    // Rounding of the length adds no element.
    let elements = (whole * (1.0 - 1e-9)).ceil().max(1.0);
    (0..elements as usize)
        .map(|i| {
            let at = whole * i as f64 / elements;
            if at <= halves[0] {
                position(corners[0], at) / length
            } else {
                1.0 - position(corners[1], whole - at) / length
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use interface::WetFace;

    #[test]
    fn divisions_are_no_longer_than_asked_and_grow_at_most_twofold() {
        for corners in [[None, None], [Some(0.01), None], [None, Some(0.3)], [Some(0.02), Some(0.02)]] {
            for (length, size) in [(10.0, 1.0), (10.0, 2.3), (0.5, 2.0), (10.0, 100.0)] {
                let mut at = division(length, size, corners);
                assert_eq!(at[0], 0.0);
                at.push(1.0);
                let lengths: Vec<f64> = at.windows(2).map(|p| (p[1] - p[0]) * length).collect();
                assert!(lengths.iter().all(|l| *l > 0.0 && *l <= size * (1.0 + 1e-9)), "{lengths:?}");
                let ends = [lengths[0], lengths[lengths.len() - 1]];
                for (end, corner) in ends.iter().zip(corners) {
                    assert!(*end <= corner.unwrap_or(size) * (1.0 + 1e-9), "{corners:?}: {lengths:?}");
                }
                let ratio = lengths.windows(2).fold(1.0, |r: f64, p| r.max(p[1] / p[0]).max(p[0] / p[1]));
                assert!(ratio <= 2.0 + 1e-9, "{corners:?}: {lengths:?}");
            }
        }
    }

    #[test]
    fn outline_of_a_kinked_face_over_a_sloped_bed() {
        let face = WetFace::new(vec![[0.0, 0.0], [-3.0, 10.0], [-3.0, 10.0], [4.0, 20.0]]).unwrap();
        let mut parameters = ReservoirParameters {
            bed: vec![[-10.0, -4.0], [-20.0, 2.0]],
            element_size: 3.0,
            far_end_distance: 5.0,
            ..ReservoirParameters::before(face)
        };
        let outline = Outline::new(&parameters).unwrap();
        let starts: Vec<[f64; 2]> = outline.pieces.iter().map(|p| p.points[0]).collect();
        let expected =
            [[0.0, 0.0], [-3.0, 10.0], [4.0, 20.0], [-25.0, 20.0], [-25.0, 2.0], [-20.0, 2.0], [-10.0, -4.0]];
        assert_eq!(starts, expected);
        parameters.bed.insert(0, [0.0, 0.0]);
        assert_eq!(Outline::new(&parameters).unwrap().area, outline.area);
    }

    #[test]
    fn beds_that_leave_no_water_are_refused() {
        let face = || WetFace::new(vec![[0.0, 0.0], [-10.0, 10.0], [4.0, 20.0]]).unwrap();
        let refused = [
            vec![[-10.0, 21.0]],
            vec![[-10.0, 20.0]],
            vec![[-11.0, 12.0]],
            vec![[-5.0, 5.0]],
            vec![[-20.0, 0.0], [-10.0, 0.0]],
            vec![[-10.0, -5.0], [-20.0, 5.0], [-5.0, -4.0]],
            vec![[f64::NAN, 0.0]],
        ];
        for bed in refused {
            let parameters = ReservoirParameters { bed: bed.clone(), ..ReservoirParameters::before(face()) };
            let outcome = Outline::new(&parameters);
            assert!(matches!(outcome, Err(ReservoirError::Section { .. })), "{bed:?}: {outcome:?}");
        }
    }
}
