//! Shapes of the triangles of a mesh.

use super::plane_geometry::{Point, distance, orientation, smallest_angle};

/// Least angle of a triangle, degrees.
pub const LEAST_ANGLE: f64 = 5.0;

/// Extremes over the triangles of all cells, each with the centroid of the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Smallest angle, degrees; negative if a triangle is inverted.
    pub smallest_angle: (f64, Point),
    /// Smallest altitude, m, to which the critical time step is nearly proportional.
    pub smallest_altitude: (f64, Point),
    /// Largest ratio of a triangle's longest side to its smallest altitude.
    pub largest_ratio: (f64, Point),
}

impl Quality {
    /// Of the four triangles of each cell: corner k, corner k + 1, centre.
    pub fn of(nodes: &[Point], cells: &[[usize; 5]]) -> Self {
        let none = [0.0; 2];
        let mut quality = Self {
            smallest_angle: (f64::INFINITY, none),
            smallest_altitude: (f64::INFINITY, none),
            largest_ratio: (0.0, none),
        };
        for cell in cells {
            for k in 0..4 {
                let corners = [cell[k], cell[(k + 1) % 4], cell[4]].map(|i| nodes[i]);
                let [a, b, c] = corners;
                let place = [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0];
                let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
                let altitude = orientation(a, b, c) / longest;
                let angle = smallest_angle(corners).to_degrees();
                if angle < quality.smallest_angle.0 || angle.is_nan() {
                    quality.smallest_angle = (angle, place);
                }
                if altitude < quality.smallest_altitude.0 || altitude.is_nan() {
                    quality.smallest_altitude = (altitude, place);
                }
                if longest / altitude > quality.largest_ratio.0 {
                    quality.largest_ratio = (longest / altitude, place);
                }
            }
        }
        quality
    }
}
