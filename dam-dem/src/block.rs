use std::ops::Range;

/// A deformable block between cracks: consecutive nodes and cells of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its nodes.
    pub nodes: Range<usize>,
    /// Its cells.
    pub cells: Range<usize>,
}

/// Rigid rotation that is the least-squares fit to a motion, rad, counter-clockwise.
///
/// With position at rest `r` and displacement `d`, both relative to their weighted means,
/// `θ = atan2(Σ w (r × r'), Σ w (r · r'))`, `r' = r + d` (Kabsch's method in the plane).
///
/// **Shapes and units**: `points` yields (weight, position at rest (m), displacement (m)).
pub fn best_fit_rotation(points: impl Iterator<Item = (f64, [f64; 2], [f64; 2])> + Clone) -> f64 {
    let mut mean = [0.0; 5];
    for (w, r, d) in points.clone() {
        for (sum, value) in mean.iter_mut().zip([1.0, r[0], r[1], d[0], d[1]]) {
            *sum += w * value;
        }
    }
    let (mut cross, mut dot) = (0.0, 0.0);
    for (w, r, d) in points {
        let [x, y] = [r[0] - mean[1] / mean[0], r[1] - mean[2] / mean[0]];
        let [p, q] = [d[0] - mean[3] / mean[0], d[1] - mean[4] / mean[0]];
        cross += w * (x * q - y * p);
        dot += w * (x * (x + p) + y * (y + q));
    }
    cross.atan2(dot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_motion_gives_its_own_angle() {
        let (s, c) = 0.3f64.sin_cos();
        let points = [[1.0, 2.0], [4.0, -1.0], [0.5, 0.5]]
            .map(|[x, y]: [f64; 2]| (1.0 + x, [x, y], [c * x - s * y - x + 7.0, s * x + c * y - y - 3.0]));
        assert!((best_fit_rotation(points.into_iter()) - 0.3).abs() < 1e-15);
    }
}
