use serde::{Deserialize, Serialize};

/// The interface points on the dam's wet face, from the heel up to the water level.
///
/// Fields vary linearly along the panel between two consecutive points. Where a crack
/// meets the face two points coincide, one on either side: there the motion may jump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct WetFace {
    points: Vec<[f64; 2]>,
}

/// The straight piece of wet face between interface points `start` and `start + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// Index of the lower point; the upper one is the next.
    pub start: usize,
    /// Length, m.
    pub length: f64,
    /// Unit normal out of the water, into the dam.
    pub normal: [f64; 2],
}

/// Points that do not make a wet face.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WetFaceError {
    /// Fewer than two points.
    #[error("a wet face needs two points or more, {found} were given")]
    TooFew {
        /// Number of points.
        found: usize,
    },
    /// A point is not finite, or not above the one before it.
    #[error("point {index} of the wet face, ({x}, {y}), does not follow the one before it upwards")]
    NotAscending {
        /// Index of the point, from 0.
        index: usize,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
    },
    /// The first point is not the heel.
    #[error("the wet face starts at ({x}, {y}), not at the heel, which is the origin")]
    NotAtHeel {
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
    },
}

impl WetFace {
    /// The wet face through `points` (m), from the heel (the origin) up.
    ///
    /// **Errors**: [`WetFaceError`]; two consecutive points may coincide, never three.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, WetFaceError> {
        if points.len() < 2 {
            return Err(WetFaceError::TooFew { found: points.len() });
        }
        let [x, y] = points[0];
        if x != 0.0 || y != 0.0 {
            return Err(WetFaceError::NotAtHeel { x, y });
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

    /// The panels, upwards; coinciding points have none between them.
    pub fn panels(&self) -> impl Iterator<Item = Panel> + '_ {
        self.points.windows(2).enumerate().filter_map(|(start, pair)| {
            let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let length = dx.hypot(dy);
            (length > 0.0).then(|| Panel { start, length, normal: [dy / length, -dx / length] })
        })
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

    /// Tributary lengths of the points, m: half of each adjacent panel. They sum to the face's length.
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
    /// **Shapes**: `pressure` one value a point; the result one (x, y) pair a point.
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
    fn points_that_make_no_face_are_refused() {
        assert_eq!(WetFace::new(vec![[0.0, 0.0]]), Err(WetFaceError::TooFew { found: 1 }));
        let (x, y) = (0.0, 1.0);
        assert_eq!(WetFace::new(vec![[x, y], [0.0, 2.0]]), Err(WetFaceError::NotAtHeel { x, y }));
        let falling = WetFace::new(vec![[0.0, 0.0], [0.0, 2.0], [x, y]]);
        assert_eq!(falling, Err(WetFaceError::NotAscending { index: 2, x, y }));
        assert!(WetFace::new(vec![[0.0, 0.0], [0.0, f64::NAN]]).is_err());
        assert!(WetFace::new(vec![[0.0, 0.0], [x, y], [x, y], [x, y], [0.0, 2.0]]).is_err());
        assert!(WetFace::new(vec![[0.0, 0.0], [0.0, 0.0], [0.0, 2.0]]).is_err());
    }
}
