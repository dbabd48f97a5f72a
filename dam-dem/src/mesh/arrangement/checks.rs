//! What a section must not have: numbers out of range, features that nearly touch, sharp corners.

use super::{Arrangement, Geometry, height};
use crate::mesh::geometry_error::{Feature, GeometryError};
use crate::mesh::plane_geometry::{Point, cross_properly, distance, minus, nearest};

/// Least angle of concrete between two edges, degrees.
const LEAST_ANGLE: f64 = 10.0;
/// Largest distance of a point from the heel, m.
const FARTHEST: f64 = 1e6;

impl Arrangement {
    /// No point may be closer to another point, or to an edge it is not an end of, than `least`.
    pub(super) fn check_distances(&self, least: f64) -> Result<(), GeometryError> {
        let feature_of = |point: usize| {
            let of_point = self.edges.iter().filter(|edge| edge.ends.contains(&point));
            of_point.map(|edge| edge.feature).max().unwrap_or(Feature::Base)
        };
        for edge in &self.edges {
            let segment = self.segment(edge);
            if distance(segment[0], segment[1]) < least {
                return Err(GeometryError::TooClose {
                    first: feature_of(edge.ends[0]),
                    second: feature_of(edge.ends[1]),
                    point: segment[0],
                    other: segment[1],
                    distance: distance(segment[0], segment[1]),
                    least,
                });
            }
            for (index, &point) in self.points.iter().enumerate() {
                let other = nearest(segment, point);
                if !edge.ends.contains(&index) && distance(point, other) < least {
                    let distance = distance(point, other);
                    let (first, second) = (feature_of(index), edge.feature);
                    return Err(GeometryError::TooClose { first, second, point, other, distance, least });
                }
            }
        }
        Ok(())
    }

    /// The concrete between two neighbouring edges of a point must have a large enough angle.
    pub(super) fn check_angles(&self) -> Result<(), GeometryError> {
        for (at, &point) in self.points.iter().enumerate() {
            // Direction, feature, and whether there is concrete to its left.
            let mut rays = Vec::new();
            for edge in self.edges.iter().filter(|edge| edge.ends.contains(&at)) {
                let outward = edge.ends[0] == at;
                let [dx, dy] = minus(self.points[edge.ends[usize::from(outward)]], point);
                rays.push((dy.atan2(dx), edge.feature, outward || !edge.on_boundary()));
            }
            rays.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (index, &(direction, first, concrete)) in rays.iter().enumerate() {
                let (next, second, _) = rays[(index + 1) % rays.len()];
                let angle = (next - direction).rem_euclid(std::f64::consts::TAU).to_degrees();
                if concrete && angle < LEAST_ANGLE && rays.len() > 1 {
                    return Err(GeometryError::SmallAngle {
                        first,
                        second,
                        point,
                        angle,
                        least: LEAST_ANGLE,
                    });
                }
            }
        }
        Ok(())
    }

    /// Rounding may lead to crossings between lines that nearly coincide.
    pub(super) fn check_crossings(&self) -> Result<(), GeometryError> {
        for (index, first) in self.edges.iter().enumerate() {
            for second in &self.edges[..index] {
                let apart = first.ends.iter().all(|end| !second.ends.contains(end));
                if apart && cross_properly(self.segment(first), self.segment(second)) {
                    return Err(GeometryError::NotTriangulated { point: self.points[first.ends[0]] });
                }
            }
        }
        Ok(())
    }
}

pub(super) fn check_numbers(geometry: &Geometry) -> Result<(), GeometryError> {
    let chain = |feature: Feature, points: &[Point], needed: usize| {
        if points.len() < needed {
            return Err(GeometryError::TooFewPoints { feature, found: points.len(), needed });
        }
        // Written so that not-a-number fails.
        match points.iter().position(|p| !p.iter().all(|x| x.abs() <= FARTHEST)) {
            Some(index) => Err(GeometryError::NotFinite { feature, index, point: points[index] }),
            None => Ok(()),
        }
    };
    chain(Feature::Upstream, geometry.upstream, 2)?;
    chain(Feature::Downstream, geometry.downstream, 2)?;
    for (index, gallery) in geometry.galleries.iter().enumerate() {
        chain(Feature::Gallery(index), gallery, 3)?;
    }
    for (index, crack) in geometry.cracks.iter().enumerate() {
        chain(Feature::Crack(index), crack, 2)?;
    }
    for (index, zone) in geometry.zones.iter().enumerate() {
        chain(Feature::Zone(index), zone, 3)?;
    }
    let (heel, toe) = (geometry.upstream[0], geometry.downstream[0]);
    if heel != [0.0, 0.0] {
        return Err(GeometryError::HeelNotAtOrigin { point: heel });
    }
    if toe[1] != 0.0 || toe[0] <= 0.0 {
        return Err(GeometryError::ToeNotOnBase { point: toe });
    }
    for (feature, points) in
        [(Feature::Upstream, geometry.upstream), (Feature::Downstream, geometry.downstream)]
    {
        if let Some(index) = (1..points.len()).find(|&i| points[i][1] <= 0.0) {
            return Err(GeometryError::BelowBase { feature, index, point: points[index] });
        }
    }
    let height = height(geometry);
    let named = geometry.crack_sizes.iter().enumerate();
    let named =
        named.filter_map(|(i, size)| size.map(|size| (format!("the element size at crack {i}"), size)));
    for (name, size) in [("`element_size`".to_string(), geometry.element_size)].into_iter().chain(named) {
        if !(size > 0.0 && size <= height) {
            return Err(GeometryError::ElementSize { name, size, height });
        }
    }
    Ok(())
}
