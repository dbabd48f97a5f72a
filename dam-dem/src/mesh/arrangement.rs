//! The section's outline, galleries, cracks and outlines of zones as edges that meet only in their ends.

use std::collections::BTreeSet;

mod checks;
mod lines;

use lines::Lines;

use super::geometry_error::{Feature, GeometryError};
use super::plane_geometry::{Point, between, cross, distance, nearest, orientation};

/// An end of a crack that is nearer to a side, gallery or crack than this many element sizes is led there.
const LED: f64 = 0.1;
/// Least distance between features, in element sizes.
const APART: f64 = 0.05;

/// A cracked section. Coordinates are in m, with the heel as the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry<'a> {
    /// The upstream side, from the heel to the crest.
    pub upstream: &'a [Point],
    /// The downstream side, from the toe to the crest.
    pub downstream: &'a [Point],
    /// Outlines of holes, in either direction.
    pub galleries: &'a [Vec<Point>],
    /// Cracks, each a chain of points.
    pub cracks: &'a [Vec<Point>],
    /// Outlines of zones of another material, in either direction; of those that overlap the last one counts.
    pub zones: &'a [Vec<Point>],
    /// Elevations where a point of the upstream side is wanted, m.
    pub upstream_levels: &'a [f64],
    /// Elevations where a point of the downstream side is wanted, m.
    pub downstream_levels: &'a [f64],
    /// Length of a cell's sides, m.
    pub element_size: f64,
    /// The same at each crack, where it differs, m; missing ones are `None`.
    pub crack_sizes: &'a [Option<f64>],
}

/// Edges of a planar graph. Those of the outline and of galleries have the concrete on their left.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// Its points, each an end of an edge.
    pub points: Vec<Point>,
    /// Its edges: in order from the heel around the outline, then around each gallery, then the cracks, then
    /// what of the outlines of zones is none of these.
    pub edges: Vec<Edge>,
    /// The edges of each crack, in order along it: from upstream to downstream or, if it is vertical, from bottom to top.
    pub cracks: Vec<Vec<CrackEdge>>,
}

/// An edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its two points.
    pub ends: [usize; 2],
    /// The crack's, or what the edge is part of.
    pub feature: Feature,
    /// The crack, which may also cover an edge of the base.
    pub crack: Option<usize>,
}

/// An edge as part of a crack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackEdge {
    /// Index of the edge.
    pub edge: usize,
    /// Whether the crack runs in the edge's direction.
    pub forward: bool,
}

impl Edge {
    /// Whether the edge is part of the outline or of a gallery.
    pub fn on_boundary(&self) -> bool {
        self.feature.is_boundary()
    }

    /// Whether the edge lies between zones alone.
    fn is_of_zone(&self) -> bool {
        matches!(self.feature, Feature::Zone(_))
    }
}

impl Arrangement {
    /// Cuts what lies outside the section off, leads ends of cracks to what is near, and splits all lines where they meet.
    ///
    /// A point is put on a side where the side, from the base up, first reaches one of the levels, unless a feature
    /// is closer to it than 0.05 element sizes.
    ///
    /// **Errors**: all of [`GeometryError`] but those about cells and blocks.
    pub fn new(geometry: &Geometry) -> Result<Self, GeometryError> {
        checks::check_numbers(geometry)?;
        let mut lines = Lines::new(geometry);
        lines.check_outline(geometry)?;
        for (index, chain) in geometry.cracks.iter().enumerate() {
            lines.add_crack(index, chain)?;
        }
        for (index, outline) in geometry.zones.iter().enumerate() {
            lines.add_zone(index, outline)?;
        }
        let mut arrangement = lines.split()?.pruned(LED * geometry.element_size)?;
        arrangement.check_distances(APART * geometry.element_size)?;
        arrangement.add_levels(geometry);
        arrangement.check_angles()?;
        arrangement.check_crossings()?;
        Ok(arrangement)
    }

    /// The two ends of an edge.
    pub fn segment(&self, edge: &Edge) -> [Point; 2] {
        edge.ends.map(|i| self.points[i])
    }

    /// Whether a point lies in the concrete.
    pub fn in_concrete(&self, point: Point) -> bool {
        let boundary = self.edges.iter().filter(|edge| edge.on_boundary());
        encloses(boundary.map(|edge| self.segment(edge)), point)
    }

    /// Area of the concrete, m².
    pub fn area(&self) -> f64 {
        let boundary = self.edges.iter().filter(|edge| edge.on_boundary());
        boundary.map(|edge| self.segment(edge)).map(|[a, b]| 0.5 * cross(a, b)).sum()
    }

    /// Removes ends of cracks that overshoot by less than `longest`, and points without edges. A crack that ends on the outline
    /// of a zone ends inside the concrete.
    fn pruned(mut self, longest: f64) -> Result<Self, GeometryError> {
        let of_zones = |index: usize| self.edges[index].is_of_zone();
        let mut removed = BTreeSet::new();
        loop {
            let mut degree = vec![0; self.points.len()];
            for (index, edge) in self.edges.iter().enumerate() {
                if !removed.contains(&index) && !of_zones(index) {
                    edge.ends.iter().for_each(|&end| degree[end] += 1);
                }
            }
            let Some((index, end)) = self.edges.iter().enumerate().find_map(|(index, edge)| {
                let end = *edge.ends.iter().find(|&&end| degree[end] == 1)?;
                (!removed.contains(&index) && !of_zones(index)).then_some((index, end))
            }) else {
                break;
            };
            let mut stub = vec![index];
            let (mut at, mut length) = (end, 0.0);
            loop {
                let edge = &self.edges[stub[stub.len() - 1]];
                let [from, to] = self.segment(edge);
                length += distance(from, to);
                at = if edge.ends[0] == at { edge.ends[1] } else { edge.ends[0] };
                let next = (0..self.edges.len()).find(|i| {
                    !removed.contains(i)
                        && !of_zones(*i)
                        && !stub.contains(i)
                        && self.edges[*i].ends.contains(&at)
                });
                match next {
                    Some(next) if degree[at] == 2 && length < longest => stub.push(next),
                    _ => break,
                }
            }
            if length >= longest || degree[at] == 1 {
                return Err(self.ends_inside(&self.edges[index], self.points[end], &stub));
            }
            removed.extend(stub);
        }
        let mut new_edge = vec![usize::MAX; self.edges.len()];
        let mut new_point = vec![usize::MAX; self.points.len()];
        let (mut points, mut edges) = (Vec::new(), Vec::new());
        for (index, edge) in self.edges.iter().enumerate().filter(|(index, _)| !removed.contains(index)) {
            new_edge[index] = edges.len();
            let ends = edge.ends.map(|end| {
                if new_point[end] == usize::MAX {
                    new_point[end] = points.len();
                    points.push(self.points[end]);
                }
                new_point[end]
            });
            edges.push(Edge { ends, ..*edge });
        }
        for (crack, chain) in self.cracks.iter_mut().enumerate() {
            chain.retain_mut(|part| {
                part.edge = new_edge[part.edge];
                part.edge != usize::MAX
            });
            if chain.is_empty() {
                return Err(GeometryError::CrackOutside { crack });
            }
        }
        Ok(Self { points, edges, cracks: self.cracks })
    }

    fn ends_inside(&self, edge: &Edge, end: Point, stub: &[usize]) -> GeometryError {
        let others = self.edges.iter().enumerate().filter(|(index, _)| !stub.contains(index));
        let crack = edge.crack.unwrap_or_default();
        let mut found = (f64::INFINITY, Feature::Base, end);
        for (_, other) in others
            .filter(|(_, other)| other.on_boundary() || other.crack.is_some() && other.crack != edge.crack)
        {
            let target = nearest(self.segment(other), end);
            if distance(target, end) < found.0 {
                found = (distance(target, end), other.feature, target);
            }
        }
        GeometryError::CrackEndsInside { crack, end, nearest: found.1, target: found.2, distance: found.0 }
    }

    fn add_levels(&mut self, geometry: &Geometry) {
        let least = APART * geometry.element_size;
        for (side, levels) in
            [(Feature::Upstream, geometry.upstream_levels), (Feature::Downstream, geometry.downstream_levels)]
        {
            for &level in levels {
                let reaches = |edge: &&Edge| {
                    let [a, b] = self.segment(edge).map(|p| p[1]);
                    edge.feature == side && a.min(b) < level && level <= a.max(b)
                };
                let reached: Vec<Edge> = self.edges.iter().filter(reaches).copied().collect();
                let first = if side == Feature::Upstream { reached.last() } else { reached.first() };
                let Some(&edge) = first else { continue };
                let [a, b] = self.segment(&edge);
                let [x, _] = between([a, b], (level - a[1]) / (b[1] - a[1]));
                let point = if a[0] == b[0] { [a[0], level] } else { [x, level] };
                let near = |other: &Edge| {
                    *other != edge && distance(nearest(self.segment(other), point), point) < least
                };
                if self.edges.iter().any(near) || [a, b].iter().any(|&end| distance(end, point) < least) {
                    continue;
                }
                self.points.push(point);
                let (middle, [from, to]) = (self.points.len() - 1, edge.ends);
                if let Some(index) = self.edges.iter().position(|other| *other == edge) {
                    self.edges[index].ends = [from, middle];
                    self.edges.insert(index + 1, Edge { ends: [middle, to], ..edge });
                    let parts = self.cracks.iter_mut().flatten();
                    parts.filter(|part| part.edge > index).for_each(|part| part.edge += 1);
                }
            }
        }
    }
}

/// Elevation of the highest point, m.
fn height(geometry: &Geometry) -> f64 {
    geometry.upstream.iter().chain(geometry.downstream).map(|p| p[1]).fold(0.0, f64::max)
}

/// Whether `p` lies within a polygon.
pub fn within(polygon: &[Point], p: Point) -> bool {
    let next = polygon.iter().cycle().skip(1);
    encloses(polygon.iter().zip(next).map(|(&a, &b)| [a, b]), p)
}

/// Whether `p` is within an odd number of rings of segments.
fn encloses(segments: impl Iterator<Item = [Point; 2]>, p: Point) -> bool {
    let mut inside = false;
    for [a, b] in segments {
        if (a[1] > p[1]) != (b[1] > p[1]) {
            inside ^= (orientation(a, b, p) > 0.0) == (b[1] > a[1]);
        }
    }
    inside
}
