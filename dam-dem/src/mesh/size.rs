//! How long the edges of coarse triangles shall be.

use super::arrangement::{Arrangement, Geometry};
use super::plane_geometry::{Point, distance, nearest};

/// Length of a coarse triangle's edge in element sizes; its three cells have then about the element size squared as area.
pub const COARSENING: f64 = 2.6;
/// Growth of the size with the distance from a finer place.
const GRADATION: f64 = 0.3;

/// Wanted length of coarse edges: the smallest of the general one and, for each finer place, its own + 0.3 × distance.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeField {
    general: f64,
    places: Vec<([Point; 2], f64)>,
}

impl SizeField {
    /// Finer places are cracks with a size of their own, and points whose distance to other edges, or along their own,
    /// is less than the general size.
    pub fn new(arrangement: &Arrangement, geometry: &Geometry) -> Self {
        let general = COARSENING * geometry.element_size;
        let mut field = Self { general, places: Vec::new() };
        for (crack, parts) in arrangement.cracks.iter().enumerate() {
            if let Some(&Some(size)) = geometry.crack_sizes.get(crack) {
                let segments = parts.iter().map(|part| arrangement.segment(&arrangement.edges[part.edge]));
                field.places.extend(segments.map(|segment| (segment, COARSENING * size)));
            }
        }
        for (index, &point) in arrangement.points.iter().enumerate() {
            let gaps = arrangement.edges.iter().map(|edge| {
                let segment = arrangement.segment(edge);
                if edge.ends.contains(&index) {
                    distance(segment[0], segment[1])
                } else {
                    distance(nearest(segment, point), point)
                }
            });
            field.places.push(([point; 2], gaps.fold(f64::INFINITY, f64::min)));
        }
        field.places.retain(|(_, size)| *size < general);
        field
    }

    /// Wanted length away from finer places, m.
    pub fn general(&self) -> f64 {
        self.general
    }

    /// Wanted length at `point`, m.
    pub fn at(&self, point: Point) -> f64 {
        let finer = |(segment, size): &([Point; 2], f64)| {
            size + GRADATION * distance(nearest(*segment, point), point)
        };
        self.places.iter().map(finer).fold(self.general, f64::min)
    }
}
