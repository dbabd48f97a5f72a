use serde::{Deserialize, Serialize};

/// The interface points on a wet face of the dam, up to the water level: of its upstream face from the heel, the origin,
/// or of its downstream face from the toe, a point downstream of it.
///
/// Fields vary linearly along the panel between two consecutive points. Where a crack
/// meets the face, two points coincide, one on either side of the crack: there the motion may jump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct WetFace {
    points: Vec<[f64; 2]>,
}

/// The straight part of the wet face between interface points `start` and `start + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// Index of the lower point; the upper one is the next.
    pub start: usize,
    /// Length, m.
    pub length: f64,
    /// Unit normal out of the water, into the dam.
    pub normal: [f64; 2],
}

/// Points or panel sizes that do not make a wet face.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WetFaceError {
    /// Fewer than two points.
    #[error("a wet face needs at least two points, {found} were given")]
    TooFew {
        /// Number of points.
        found: usize,
    },
    /// A point is not finite, or not above the one before it.
    #[error(
        "point {index} of the wet face, ({x}, {y}), is not above the point before it; list the points from the heel upwards"
    )]
    NotAscending {
        /// Index of the point, from 0.
        index: usize,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
    },
    /// The first point is neither the heel nor a toe.
    #[error(
        "the wet face starts at ({x}, {y}); it must start at the heel, the origin (0, 0), or at the toe, downstream at y = 0"
    )]
    NotAtBase {
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
    },
    /// Panels without length, or too many of them.
    #[error(
        "panels of {size:e} m would divide the wet face into {panels:e} panels; choose a length above 0 that gives at most {MOST_PANELS:e}"
    )]
    PanelSize {
        /// Largest length of a panel, m.
        size: f64,
        /// Length of the face over that.
        panels: f64,
    },
}

/// Largest number of panels of a respaced face.
const MOST_PANELS: f64 = 1e4;

/// Smallest sine of the angle between two panels that counts as a kink.
const KINK: f64 = 1e-9;

/// A vertical face of 100 m with 40 equal panels.
impl Default for WetFace {
    fn default() -> Self {
        Self { points: (0..=40).map(|i| [0.0, 2.5 * f64::from(i)]).collect() }
    }
}

impl WetFace {
    /// The wet face through `points` (m), from the heel (the origin) or from the toe (x > 0, y = 0) up.
    ///
    /// **Errors**: [`WetFaceError`]. Two consecutive points may coincide, but not three.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, WetFaceError> {
        if points.len() < 2 {
            return Err(WetFaceError::TooFew { found: points.len() });
        }
        let [x, y] = points[0];
        if !(x >= 0.0 && y == 0.0) {
            return Err(WetFaceError::NotAtBase { x, y });
        }
        let mut repeated = false;
        for (i, pair) in points.windows(2).enumerate() {
            let [x, y] = pair[1];
            let coincide = pair[0] == pair[1];
            let at_an_end = i == 0 || i + 2 == points.len();
            let follows = y > pair[0][1] || coincide && !repeated && !at_an_end;
            if !(x.is_finite() && y.is_finite() && follows) {
                return Err(WetFaceError::NotAscending { index: i + 1, x, y });
            }
            repeated = coincide;
        }
        Ok(Self { points })
    }

    /// A straight face from the heel to `top` (m) with `panels` equal panels.
    pub fn straight(top: [f64; 2], panels: usize) -> Result<Self, WetFaceError> {
        let at = |i: usize| i as f64 / panels as f64;
        Self::new((0..=panels).map(|i| [top[0] * at(i), top[1] * at(i)]).collect())
    }

    /// Coordinates of the points, m.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Number of points.
    #[allow(clippy::len_without_is_empty)] // a wet face has two points or more
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Elevation of the highest point above the heel: the depth of the water, m.
    pub fn depth(&self) -> f64 {
        self.points[self.points.len() - 1][1]
    }

    /// Whether the water is downstream of the face.
    pub fn is_downstream(&self) -> bool {
        self.points[0][0] > 0.0
    }

    /// The toe of a downstream face: its first point's x, m.
    pub fn toe(&self) -> Option<f64> {
        self.is_downstream().then_some(self.points[0][0])
    }

    /// The face mirrored at a vertical, so that x is measured from `toe` (m) against its direction: a downstream face as its
    /// water sees it, which looks at it as at an upstream one, and back.
    pub fn mirrored(&self, toe: f64) -> Self {
        Self { points: self.points.iter().map(|[x, y]| [toe - x, *y]).collect() }
    }

    /// The panels, upwards; there is no panel between coinciding points.
    pub fn panels(&self) -> impl Iterator<Item = Panel> + '_ {
        let side = if self.is_downstream() { -1.0 } else { 1.0 };
        self.points.windows(2).enumerate().filter_map(move |(start, pair)| {
            let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let length = dx.hypot(dy);
            let normal = [side * dy / length, -side * dx / length];
            (length > 0.0).then_some(Panel { start, length, normal })
        })
    }

    /// The straight pieces, upwards: indices of the first and the last point of each.
    ///
    /// A piece ends at a kink and where two points coincide. At a kink with a single point, the next piece starts
    /// with the same point.
    pub fn straight_pieces(&self) -> Vec<[usize; 2]> {
        let panels: Vec<Panel> = self.panels().collect();
        let mut pieces = Vec::new();
        let mut first = 0;
        for pair in panels.windows(2) {
            let [m, n] = [pair[0].normal, pair[1].normal];
            let (before, next) = (pair[0].start + 1, pair[1].start);
            if before != next || (m[0] * n[1] - m[1] * n[0]).abs() > KINK {
                pieces.push([first, before]);
                first = next;
            }
        }
        pieces.push([first, self.len() - 1]);
        pieces
    }

    /// The same face with other panels: every straight piece is divided into equal panels no longer than `size` (m).
    ///
    /// Kinks and coinciding points keep their coordinates bit for bit; other points may move along the face.
    ///
    /// **Errors**: [`WetFaceError::PanelSize`], and [`WetFaceError::NotAscending`] for panels so short that points
    /// coincide.
    pub fn respaced(&self, size: f64) -> Result<Self, WetFaceError> {
        let panels = self.panels().map(|panel| panel.length).sum::<f64>() / size;
        if !(size > 0.0 && panels <= MOST_PANELS) {
            return Err(WetFaceError::PanelSize { size, panels });
        }
        let mut points = vec![self.points[0]];
        let mut last_before = 0;
        for [first, last] in self.straight_pieces() {
            let (start, end) = (self.points[first], self.points[last]);
            if first != last_before {
                points.push(start);
            }
            let length = (end[0] - start[0]).hypot(end[1] - start[1]);
            // Rounding of the length must not add a panel.
            let count = (length / size * (1.0 - 1e-9)).ceil().max(1.0);
            points.extend((1..count as usize).map(|i| {
                let t = i as f64 / count;
                [0, 1].map(|axis| start[axis] * (1.0 - t) + end[axis] * t)
            }));
            points.push(end);
            last_before = last;
        }
        Self::new(points)
    }

    /// Unit normals at the points: those of the adjacent panels, weighted by their lengths.
    pub fn normals(&self) -> Vec<[f64; 2]> {
        let mut sums = vec![[0.0, 0.0]; self.len()];
        for panel in self.panels() {
            for sum in &mut sums[panel.start..panel.start + 2] {
                sum[0] += panel.length * panel.normal[0];
                sum[1] += panel.length * panel.normal[1];
            }
        }
        sums.iter().map(|n| [n[0] / n[0].hypot(n[1]), n[1] / n[0].hypot(n[1])]).collect()
    }

    /// Tributary lengths of the points, m: half of each adjacent panel. Their sum is the length of the face.
    pub fn tributary_lengths(&self) -> Vec<f64> {
        let mut lengths = vec![0.0; self.len()];
        for panel in self.panels() {
            lengths[panel.start] += panel.length / 2.0;
            lengths[panel.start + 1] += panel.length / 2.0;
        }
        lengths
    }

    /// Nodal forces (N/m) of a pressure (Pa) that is linear along every panel: `F_i = ∫ N_i p n ds`.
    ///
    /// **Shapes**: `pressure` has one value per point, the result one pair (x, y) per point.
    pub fn nodal_forces(&self, pressure: &[f64]) -> Vec<[f64; 2]> {
        let mut forces = vec![[0.0, 0.0]; self.len()];
        for Panel { start, length, normal } in self.panels() {
            let (p, q) = (pressure[start], pressure[start + 1]);
            for (force, mean) in [(start, (2.0 * p + q) / 6.0), (start + 1, (p + 2.0 * q) / 6.0)] {
                forces[force][0] += mean * length * normal[0];
                forces[force][1] += mean * length * normal[1];
            }
        }
        forces
    }
}

impl TryFrom<Vec<[f64; 2]>> for WetFace {
    type Error = WetFaceError;

    fn try_from(points: Vec<[f64; 2]>) -> Result<Self, WetFaceError> {
        Self::new(points)
    }
}

impl From<WetFace> for Vec<[f64; 2]> {
    fn from(face: WetFace) -> Self {
        face.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometry_of_a_battered_face_with_a_crack() -> Result<(), WetFaceError> {
        let face = WetFace::new(vec![[0.0, 0.0], [1.0, 10.0], [1.0, 10.0], [2.0, 20.0]])?;
        assert_eq!(face.panels().map(|p| p.start).collect::<Vec<_>>(), [0, 2]);
        let length = 2.0 * 101f64.sqrt();
        assert!((face.tributary_lengths().iter().sum::<f64>() - length).abs() < 1e-12);
        for n in face.normals() {
            assert!(
                (n[0] - 10.0 / 101f64.sqrt()).abs() < 1e-15 && (n[1] + 1.0 / 101f64.sqrt()).abs() < 1e-15
            );
        }
        Ok(())
    }

    #[test]
    fn a_downstream_face_is_an_upstream_one_in_the_mirror() -> Result<(), WetFaceError> {
        let upstream = WetFace::new(vec![[0.0, 0.0], [1.0, 10.0], [1.0, 10.0], [4.0, 20.0]])?;
        let downstream = upstream.mirrored(64.0);
        assert_eq!((upstream.toe(), downstream.toe()), (None, Some(64.0)));
        assert_eq!(downstream.points()[3], [60.0, 20.0]);
        assert_eq!(downstream.mirrored(64.0), upstream);
        assert_eq!(WetFace::new(downstream.points().to_vec())?, downstream);
        let pressure = [4.0, 3.0, 3.0, 1.0];
        let mirrored = |vectors: Vec<[f64; 2]>| -> Vec<_> { vectors.iter().map(|[x, y]| [-x, *y]).collect() };
        assert_eq!(downstream.normals(), mirrored(upstream.normals()));
        assert_eq!(downstream.nodal_forces(&pressure), mirrored(upstream.nodal_forces(&pressure)));
        assert!(downstream.normals().iter().all(|n| n[0] < 0.0 && n[1] < 0.0), "into the dam, and down");
        Ok(())
    }

    #[test]
    fn hydrostatic_force_and_moment_are_exact() -> Result<(), WetFaceError> {
        let face = WetFace::straight([0.0, 12.0], 5)?;
        let pressure: Vec<f64> = face.points().iter().map(|p| 9810.0 * (12.0 - p[1])).collect();
        let forces = face.nodal_forces(&pressure);
        let total: f64 = forces.iter().map(|f| f[0]).sum();
        let moment: f64 = forces.iter().zip(face.points()).map(|(f, p)| f[0] * p[1]).sum();
        assert!((total / (9810.0 * 72.0) - 1.0).abs() < 1e-14);
        assert!((moment / (9810.0 * 288.0) - 1.0).abs() < 1e-14);
        Ok(())
    }

    #[test]
    fn a_respaced_face_keeps_its_kinks_and_coinciding_points() -> Result<(), WetFaceError> {
        let (kink, crack, level) = ([3.0, 4.0], [3.0, 10.0], [3.0, 20.0]);
        let face = WetFace::new(vec![[0.0, 0.0], [1.5, 2.0], kink, [3.0, 9.0], crack, crack, level])?;
        assert_eq!(face.straight_pieces(), [[0, 2], [2, 4], [5, 6]]);
        // 5 m, 6 m and 10 m long.
        for (size, panels) in [(100.0, [1, 1, 1]), (5.0, [1, 2, 2]), (4.0, [2, 2, 3]), (0.1, [50, 60, 100])] {
            let again = face.respaced(size)?;
            let ends = [0, panels[0], panels[0] + panels[1]];
            let last = again.len() - 1;
            assert_eq!(again.straight_pieces(), [[0, ends[1]], [ends[1], ends[2]], [ends[2] + 1, last]]);
            assert_eq!(last, panels.iter().sum::<usize>() + 1);
            let kept = [ends[1], ends[2], ends[2] + 1, last].map(|i| again.points()[i]);
            assert_eq!(kept, [kink, crack, crack, level]);
            assert!(again.panels().all(|panel| panel.length <= size * (1.0 + 1e-9)));
            let of_first = again.panels().take(panels[0]).map(|panel| panel.length * panels[0] as f64);
            assert!(of_first.into_iter().all(|length| (length - 5.0).abs() < 1e-13));
            assert_eq!(again.respaced(size)?, again);
        }
        let doubled = WetFace::new(vec![[0.0, 0.0], kink, kink, level])?;
        assert_eq!(doubled.respaced(100.0)?, doubled);
        Ok(())
    }

    #[test]
    fn panels_of_no_length_and_too_many_are_refused() -> Result<(), WetFaceError> {
        let face = WetFace::straight([0.0, 12.0], 5)?;
        for size in [0.0, -1.0, 1e-4, f64::NAN] {
            let error = face.respaced(size).expect_err("the size is refused");
            assert!(matches!(error, WetFaceError::PanelSize { .. }), "{error}");
        }
        let error = face.respaced(1e-3).expect_err("12000 are too many");
        let said = "panels of 1e-3 m would divide the wet face into 1.2e4 panels; choose a length above 0 that gives at most 1e4";
        assert_eq!(error.to_string(), said);
        Ok(())
    }

    #[test]
    fn points_that_make_no_face_are_refused() {
        assert_eq!(WetFace::new(vec![[0.0, 0.0]]), Err(WetFaceError::TooFew { found: 1 }));
        let (x, y) = (0.0, 1.0);
        assert_eq!(WetFace::new(vec![[x, y], [0.0, 2.0]]), Err(WetFaceError::NotAtBase { x, y }));
        let falling = WetFace::new(vec![[0.0, 0.0], [0.0, 2.0], [x, y]]);
        assert_eq!(falling, Err(WetFaceError::NotAscending { index: 2, x, y }));
        assert!(WetFace::new(vec![[0.0, 0.0], [0.0, f64::NAN]]).is_err());
        assert!(WetFace::new(vec![[0.0, 0.0], [x, y], [x, y], [x, y], [0.0, 2.0]]).is_err());
        assert!(WetFace::new(vec![[0.0, 0.0], [0.0, 0.0], [0.0, 2.0]]).is_err());
    }
}
