//! The water's outline: a closed polygon of far end, bed, wet face and surface.
//!
//! Depends on `condition` and `parameters`.

use crate::condition::BoundaryCondition;
use crate::{ReservoirError, ReservoirParameters};

/// Smallest sine of the angle between two pieces that counts as a corner.
const KINK: f64 = 1e-9;

/// A straight piece of boundary; the water is on its left going from `start` to `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// First end, m.
    pub start: [f64; 2],
    /// Second end, m.
    pub end: [f64; 2],
    /// Boundary condition.
    pub condition: BoundaryCondition,
    /// Whether the first and the second end are corners, towards which a mesh may be graded.
    pub corners: [bool; 2],
}

impl Piece {
    /// Length, m.
    pub fn length(&self) -> f64 {
        (self.end[0] - self.start[0]).hypot(self.end[1] - self.start[1])
    }

    fn along(&self) -> [f64; 2] {
        let length = self.length();
        [(self.end[0] - self.start[0]) / length, (self.end[1] - self.start[1]) / length]
    }
}

/// The polygon around the near field, counter-clockwise: far end (downwards), bed (downstream), wet face
/// (upwards), surface (upstream).
///
/// The far end lies `far_end_distance` upstream of the most upstream point of face and bed; upstream of it
/// the water is a channel between the surface and the level of the bed's last corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    pieces: Vec<Piece>,
    /// The surface between face and far end.
    surface: Piece,
    waves: bool,
}

/// Length of a piece of the bed, as a share of the face's, below which its elements cannot be told apart.
const SHORTEST: f64 = 1e-6;

impl Outline {
    /// The outline of the parameters' water.
    ///
    /// **Errors**: [`ReservoirError::BedCorner`] for a corner that is not finite or not below the surface,
    /// [`ReservoirError::BedCrosses`] for a bed that crosses or touches itself or the face.
    pub fn new(parameters: &ReservoirParameters) -> Result<Self, ReservoirError> {
        let (face, bed) = (&parameters.wet_face, &parameters.bed);
        let level = face.depth();
        for (corner, &[x, y]) in bed.iter().enumerate() {
            if !(x.is_finite() && y.is_finite() && y < level) {
                return Err(ReservoirError::BedCorner { corner: corner + 1, x, y, level });
            }
        }
        let most_upstream = face.points().iter().chain(bed).fold(0.0, |x: f64, p| x.min(p[0]));
        let upstream = most_upstream - parameters.far_end_distance;
        let floor = bed.last().map_or(0.0, |p| p[1]);
        let piece = |start, end, condition| Piece { start, end, condition, corners: [false; 2] };
        let mut pieces = vec![piece([upstream, level], [upstream, floor], BoundaryCondition::Radiation)];
        let mut from = [upstream, floor];
        for &corner in bed.iter().rev().chain(&[[0.0, 0.0]]) {
            pieces.push(piece(from, corner, BoundaryCondition::AbsorbingBed));
            from = corner;
        }
        for [first, last] in face.straight_pieces() {
            pieces.push(piece(face.points()[first], face.points()[last], BoundaryCondition::WetFace));
        }
        let surface =
            piece(face.points()[face.len() - 1], [upstream, level], BoundaryCondition::SurfaceWaves);
        check(&pieces)?;
        let waves = parameters.surface_waves;
        mark_corners(&mut pieces, waves);
        let surface = Piece { corners: [true, true], ..surface };
        if waves {
            pieces.push(surface);
        }
        Ok(Self { pieces, surface, waves })
    }

    /// The pieces to be meshed; the surface only if there are waves on it.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Whether the water carries gravity waves.
    pub fn has_waves(&self) -> bool {
        self.waves
    }

    /// Whether `point` (m) lies in the near field, at more than the rounding error from its boundary.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        let mut inside = false;
        let closing = (!self.waves).then_some(&self.surface);
        for Piece { start: [x0, y0], end: [x1, y1], .. } in self.pieces.iter().chain(closing) {
            if distance(point, [*x0, *y0], [*x1, *y1]) <= 1e-12 * (self.surface.start[1] + point[0].abs()) {
                return false;
            }
            if (*y0 > point[1]) != (*y1 > point[1]) && point[0] < x0 + (point[1] - y0) / (y1 - y0) * (x1 - x0)
            {
                inside = !inside;
            }
        }
        inside
    }
}

/// Marks as corners the heel, kinks, and the top of the face; with gravity waves also the top of the far end.
fn mark_corners(pieces: &mut [Piece], waves: bool) {
    for i in 0..pieces.len() - 1 {
        let (a, b) = (pieces[i].along(), pieces[i + 1].along());
        let kink = (a[0] * b[1] - a[1] * b[0]).abs() > KINK || a[0] * b[0] + a[1] * b[1] < 0.0;
        // The foot of the far end is not a corner of the water, because the channel continues.
        if kink && pieces[i].condition != BoundaryCondition::Radiation {
            pieces[i].corners[1] = true;
            pieces[i + 1].corners[0] = true;
        }
    }
    pieces[0].corners[0] = waves;
    let last = pieces.len() - 1;
    pieces[last].corners[1] = true;
}

/// Refuses pieces of the bed without length, or with a point in common with a piece that is not a neighbour.
fn check(pieces: &[Piece]) -> Result<(), ReservoirError> {
    let bed: Vec<usize> =
        (0..pieces.len()).filter(|&i| pieces[i].condition == BoundaryCondition::AbsorbingBed).collect();
    // Corners count from the heel, 0, upstream.
    let corner = |i: usize| bed[bed.len() - 1] - i;
    let refused = |i: usize, other: usize| ReservoirError::BedCrosses {
        corner: corner(i),
        x: pieces[i].end[0],
        y: pieces[i].end[1],
        other: pieces[other].condition,
        start: pieces[other].start,
        end: pieces[other].end,
    };
    let depth = pieces
        .iter()
        .filter(|piece| piece.condition == BoundaryCondition::WetFace)
        .map(Piece::length)
        .sum::<f64>();
    if let Some(&i) = bed.iter().rev().find(|&&i| pieces[i].length() < SHORTEST * depth) {
        return Err(refused(i, i));
    }
    for &i in bed.iter().rev() {
        for (j, piece) in pieces.iter().enumerate() {
            if j == i {
                continue;
            }
            let (a, b) = (pieces[i].along(), piece.along());
            let neighbours = j + 1 == i || i + 1 == j;
            let turns_back = (a[0] * b[1] - a[1] * b[0]).abs() <= KINK && a[0] * b[0] + a[1] * b[1] < 0.0;
            if if neighbours { turns_back } else { meet(&pieces[i], piece) } {
                return Err(refused(i, j));
            }
        }
    }
    Ok(())
}

/// Whether two pieces have a point in common.
fn meet(a: &Piece, b: &Piece) -> bool {
    let scale = a.length().max(b.length());
    let ends = [(a.start, b), (a.end, b), (b.start, a), (b.end, a)];
    if ends.iter().any(|(p, piece)| distance(*p, piece.start, piece.end) <= 1e-12 * scale) {
        return true;
    }
    let side = |p: [f64; 2], piece: &Piece| {
        (piece.end[0] - piece.start[0]) * (p[1] - piece.start[1])
            - (piece.end[1] - piece.start[1]) * (p[0] - piece.start[0])
            > 0.0
    };
    side(a.start, b) != side(a.end, b) && side(b.start, a) != side(b.end, a)
}

/// Distance (m) of a point from the straight piece between two others.
fn distance(point: [f64; 2], start: [f64; 2], end: [f64; 2]) -> f64 {
    let along = [end[0] - start[0], end[1] - start[1]];
    let from = [point[0] - start[0], point[1] - start[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let t = if square > 0.0 { (from[0] * along[0] + from[1] * along[1]) / square } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    (from[0] - t * along[0]).hypot(from[1] - t * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::WetFace;

    fn water(bed: &[[f64; 2]]) -> ReservoirParameters {
        let face = WetFace::new(vec![[0.0, 0.0], [-2.0, 5.0], [-2.0, 20.0]]).unwrap();
        ReservoirParameters { bed: bed.to_vec(), ..ReservoirParameters::before(face) }
    }

    #[test]
    fn a_bed_that_is_none_is_refused_with_its_corner() {
        let error = |bed: &[[f64; 2]]| Outline::new(&water(bed)).unwrap_err();
        for (bed, corner) in [(vec![[-10.0, 2.0], [-20.0, 20.0]], 2), (vec![[f64::NAN, 2.0]], 1)] {
            let error = error(&bed);
            assert!(matches!(error, ReservoirError::BedCorner { corner: c, .. } if c == corner), "{error}");
        }
        for (what, bed, corner) in [
            ("no length at the heel", vec![[0.0, 0.0]], 0),
            ("no length", vec![[-5.0, 0.0], [-5.0, 0.0]], 1),
            ("next to none", vec![[-5.0, 0.0], [-5.0, 1e-9]], 1),
            ("crosses the face", vec![[1.0, 4.0], [-8.0, 4.0]], 1),
            ("along the face", vec![[-1.0, 2.5]], 0),
            ("crosses itself", vec![[-8.0, 0.0], [-8.0, 4.0], [-4.0, -4.0]], 0),
            ("turns back", vec![[-8.0, 0.0], [-4.0, 0.0]], 0),
            ("touches the heel", vec![[-8.0, 3.0], [-8.0, -3.0], [4.0, 0.0], [-9.0, 0.0]], 0),
        ] {
            let error = error(&bed);
            println!("{what}: {error}");
            assert!(matches!(error, ReservoirError::BedCrosses { corner: c, .. } if c == corner), "{what}");
        }
        // An overhang, a hole under the dam and a step upwards are allowed.
        for bed in
            [vec![[-8.0, 0.0], [-6.0, 4.0]], vec![[3.0, -4.0], [-9.0, -4.0]], vec![[-3.0, 0.0], [-3.0, 9.0]]]
        {
            assert!(Outline::new(&water(&bed)).is_ok(), "{bed:?}");
        }
    }

    #[test]
    fn corners_and_what_lies_between_them() {
        let parameters = water(&[[-10.0, 0.0], [-20.0, 6.0]]);
        let outline = Outline::new(&parameters).unwrap();
        let corners: Vec<_> = outline.pieces().iter().map(|p| p.corners).collect();
        let [none, both] = [[false, false], [true, true]];
        assert_eq!(corners, [none, [false, true], both, both, both, both]);
        assert_eq!(outline.pieces()[0].end, [-30.0, 6.0]);
        for (point, inside) in [
            ([-5.0, 1.0], true),
            ([-1.9, 3.0], true),
            ([-0.5, 3.0], false),
            ([-29.0, 5.9], false),
            ([-29.0, 6.1], true),
            ([-2.0, 10.0], false),
            ([-5.0, 20.0], false),
            ([-31.0, 10.0], false),
        ] {
            assert_eq!(outline.contains(point), inside, "{point:?}");
        }
        let waves = Outline::new(&ReservoirParameters { surface_waves: true, ..parameters }).unwrap();
        assert_eq!(waves.pieces().len(), outline.pieces().len() + 1);
        assert_eq!(waves.pieces()[0].corners, [true, false]);
    }
}
