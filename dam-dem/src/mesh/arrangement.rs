//! The section's outline, galleries, cracks and outlines of zones as edges that meet only in their ends.

use std::collections::{BTreeMap, BTreeSet};

use super::geometry_error::{Feature, GeometryError};
use super::plane_geometry::{
    Point, area, between, cross, cross_properly, distance, dot, meeting, minus, nearest, nearest_share,
    orientation,
};

/// Points closer than this share of the height are one.
const SNAP: f64 = 1e-6;
/// An end of a crack that is nearer to a side, gallery or crack than this many element sizes is led there.
const LED: f64 = 0.1;
/// Least distance between features, in element sizes.
const APART: f64 = 0.05;
/// Least angle of concrete between two edges, degrees.
const LEAST_ANGLE: f64 = 10.0;
/// Largest distance of a point from the heel, m.
const FARTHEST: f64 = 1e6;

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
        check_numbers(geometry)?;
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

    /// No point may be closer to another point, or to an edge it is not an end of, than `least`.
    fn check_distances(&self, least: f64) -> Result<(), GeometryError> {
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

    /// The concrete between two neighbouring edges of a point must have a large enough angle.
    fn check_angles(&self) -> Result<(), GeometryError> {
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
    fn check_crossings(&self) -> Result<(), GeometryError> {
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

fn check_numbers(geometry: &Geometry) -> Result<(), GeometryError> {
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

/// Lines as given, by the points at their ends, and the points that were found to lie on them.
struct Lines {
    points: Vec<Point>,
    lines: Vec<Line>,
    /// Number of cracks so far.
    cracks: usize,
    /// Points closer than this are one, m.
    snap: f64,
    element_size: f64,
}

struct Line {
    ends: [usize; 2],
    feature: Feature,
    on: Vec<usize>,
}

impl Lines {
    /// The outline, counter-clockwise from the heel, and the galleries, clockwise.
    fn new(geometry: &Geometry) -> Self {
        let (snap, element_size) = (SNAP * height(geometry), geometry.element_size);
        let mut lines = Self { points: Vec::new(), lines: Vec::new(), cracks: 0, snap, element_size };
        let (up, down) = (geometry.upstream, geometry.downstream);
        let mut ring = vec![(up[0], Feature::Base)];
        ring.extend(down[..down.len() - 1].iter().map(|&p| (p, Feature::Downstream)));
        let (left, right) = (up[up.len() - 1], down[down.len() - 1]);
        if distance(left, right) > snap {
            ring.push((right, Feature::Crest));
        }
        ring.extend(up[1..].iter().rev().map(|&p| (p, Feature::Upstream)));
        lines.add_ring(&ring);
        for (index, gallery) in geometry.galleries.iter().enumerate() {
            let mut ring: Vec<_> = gallery.iter().map(|&p| (p, Feature::Gallery(index))).collect();
            if area(gallery) > 0.0 {
                ring.reverse();
            }
            lines.add_ring(&ring);
        }
        lines
    }

    /// A closed ring; each point comes with the feature of the line that starts there.
    fn add_ring(&mut self, ring: &[(Point, Feature)]) {
        let first = self.points.len();
        for (index, &(point, feature)) in ring.iter().enumerate() {
            self.points.push(point);
            let ends = [first + index, first + (index + 1) % ring.len()];
            self.lines.push(Line { ends, feature, on: Vec::new() });
        }
    }

    fn segment(&self, line: &Line) -> [Point; 2] {
        line.ends.map(|i| self.points[i])
    }

    /// Refuses outlines that touch each other or themselves; called before there are cracks.
    fn check_outline(&self, geometry: &Geometry) -> Result<(), GeometryError> {
        for (index, first) in self.lines.iter().enumerate() {
            for second in &self.lines[..index] {
                let Some(point) = self.meet(first, second) else { continue };
                return Err(match (first.feature, second.feature) {
                    (Feature::Gallery(a), Feature::Gallery(b)) if a == b => {
                        GeometryError::OutlineCrosses { first: first.feature, second: second.feature, point }
                    }
                    (Feature::Gallery(gallery), other) => {
                        GeometryError::GalleryTouches { gallery, other, point }
                    }
                    (first, second) => GeometryError::OutlineCrosses { first, second, point },
                });
            }
        }
        // Nothing crosses, so that one point tells where a whole gallery lies.
        for (gallery, points) in geometry.galleries.iter().enumerate() {
            let point = points[0];
            let others = self.lines.iter().filter(|line| line.feature != Feature::Gallery(gallery));
            if !encloses(others.map(|line| self.segment(line)), point) {
                return Err(GeometryError::GalleryOutside { gallery, point });
            }
        }
        Ok(())
    }

    /// Where two lines of outlines meet beyond the end that they share, or turn back on one another there.
    fn meet(&self, first: &Line, second: &Line) -> Option<Point> {
        let Some(&at) = first.ends.iter().find(|end| second.ends.contains(end)) else {
            return self.touch(self.segment(first), self.segment(second));
        };
        let far = |line: &Line| self.points[line.ends[usize::from(line.ends[0] == at)]];
        let (p, a, b) = (self.points[at], far(first), far(second));
        let (to_a, to_b) = (minus(a, p), minus(b, p));
        let folded = dot(to_a, to_b) > 0.0
            && (distance(nearest([p, b], a), a) <= self.snap || distance(nearest([p, a], b), b) <= self.snap);
        (folded || distance(a, p) <= self.snap || distance(b, p) <= self.snap).then_some(p)
    }

    /// Where two segments come as close as points that are one.
    fn touch(&self, one: [Point; 2], two: [Point; 2]) -> Option<Point> {
        if cross_properly(one, two) {
            return meeting(one, two).map(|[t, _]| between(one, t));
        }
        let near = |segment: [Point; 2], p: Point| distance(nearest(segment, p), p) <= self.snap;
        one.into_iter().find(|&p| near(two, p)).or_else(|| two.into_iter().find(|&p| near(one, p)))
    }

    fn boundary(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(|line| line.feature.is_boundary())
    }

    fn in_concrete(&self, p: Point) -> bool {
        encloses(self.boundary().map(|line| self.segment(line)), p)
    }

    /// The point as an index: an existing one, one on an existing line, or a new one.
    fn snapped(&mut self, point: Point, snap: f64) -> usize {
        if let Some(index) = self.points.iter().position(|&p| distance(p, point) <= snap) {
            return index;
        }
        let on = self.lines.iter().map(|line| nearest(self.segment(line), point));
        let point = on.into_iter().find(|&p| distance(p, point) <= snap).unwrap_or(point);
        self.points.push(point);
        self.points.len() - 1
    }

    fn add_crack(&mut self, index: usize, chain: &[Point]) -> Result<(), GeometryError> {
        let mut given: Vec<Point> = Vec::new();
        for &point in chain {
            if given.last().is_none_or(|&last| distance(last, point) > self.snap) {
                given.push(point);
            }
        }
        if given.len() < 2 {
            return Err(GeometryError::TooFewPoints {
                feature: Feature::Crack(index),
                found: given.len(),
                needed: 2,
            });
        }
        self.cracks = index + 1;
        let (first, last) = (given[0], given[given.len() - 1]);
        let slight = self.snap.max(1e-9 * distance(first, last));
        let rightward = first[0] - last[0] < -slight;
        if !rightward && (first[0] - last[0] > slight || first[1] > last[1]) {
            given.reverse();
        }
        for from_end in [false, true] {
            if from_end {
                given.reverse();
            }
            let count = given.len();
            given[count - 1] = self.led(&given);
            if from_end {
                given.reverse();
            }
        }
        let mut ends: Vec<usize> = given.iter().map(|&p| self.snapped(p, self.snap)).collect();
        ends.dedup();
        for pair in ends.windows(2) {
            let line = Line { ends: [pair[0], pair[1]], feature: Feature::Crack(index), on: Vec::new() };
            self.lines.push(line);
        }
        Ok(())
    }

    /// Adds the outline of a zone, which must not cross or touch itself.
    fn add_zone(&mut self, index: usize, outline: &[Point]) -> Result<(), GeometryError> {
        let feature = Feature::Zone(index);
        let mut alone = Self { points: Vec::new(), lines: Vec::new(), ..*self };
        alone.add_ring(&outline.iter().map(|&point| (point, feature)).collect::<Vec<_>>());
        for (at, first) in alone.lines.iter().enumerate() {
            if let Some(point) = alone.lines[..at].iter().find_map(|second| alone.meet(first, second)) {
                return Err(GeometryError::OutlineCrosses { first: feature, second: feature, point });
            }
        }
        let corners: Vec<usize> = outline.iter().map(|&point| self.snapped(point, self.snap)).collect();
        for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            if from != to {
                self.lines.push(Line { ends: [from, to], feature, on: Vec::new() });
            }
        }
        Ok(())
    }

    /// The last point of the chain, led to what is near if it lies within the concrete.
    fn led(&self, chain: &[Point]) -> Point {
        let (end, before) = (chain[chain.len() - 1], chain[chain.len() - 2]);
        let reach = LED * self.element_size;
        let own = chain[..chain.len() - 1].windows(2).map(|pair| [pair[0], pair[1]]);
        let others: Vec<[Point; 2]> = self.lines.iter().map(|line| self.segment(line)).chain(own).collect();
        let apart =
            others.iter().map(|&other| distance(nearest(other, end), end)).fold(f64::INFINITY, f64::min);
        if apart <= self.snap || apart > reach || !self.in_concrete(end) {
            return end;
        }
        let length = distance(before, end);
        let mut ahead = f64::INFINITY;
        for &other in &others {
            let Some([t, s]) = meeting([before, end], other) else { continue };
            if !(0.0..=1.0).contains(&s) || t <= 0.0 {
                continue;
            }
            if t <= 1.0 && (1.0 - t) * length < reach {
                return end;
            }
            if t > 1.0 && (t - 1.0) * length < 2.0 * reach {
                ahead = ahead.min(t);
            }
        }
        let near = |p: &&Point| distance(**p, end) < reach;
        if let Some(&corner) =
            self.points.iter().filter(near).min_by(|a, b| distance(**a, end).total_cmp(&distance(**b, end)))
        {
            return corner;
        }
        if ahead.is_finite() {
            return [before[0] + ahead * (end[0] - before[0]), before[1] + ahead * (end[1] - before[1])];
        }
        let targets = others.iter().map(|&other| nearest(other, end));
        targets.min_by(|a, b| distance(*a, end).total_cmp(&distance(*b, end))).unwrap_or(end)
    }

    /// Splits all lines where they meet and keeps what lies within the section.
    fn split(mut self) -> Result<Arrangement, GeometryError> {
        self.cross();
        let mut edges: Vec<Edge> = Vec::new();
        let mut known = BTreeMap::new();
        let mut cracks = vec![Vec::new(); self.cracks];
        for line in &self.lines {
            let segment = self.segment(line);
            let mut on: Vec<(f64, usize)> =
                line.on.iter().map(|&i| (nearest_share(segment, self.points[i]), i)).collect();
            let near = |&i: &usize| {
                let p = self.points[i];
                !line.ends.contains(&i) && distance(nearest(segment, p), p) <= self.snap
            };
            on.extend(
                (0..self.points.len()).filter(near).map(|i| (nearest_share(segment, self.points[i]), i)),
            );
            on.extend([(0.0, line.ends[0]), (1.0, line.ends[1])]);
            on.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut chain: Vec<usize> = Vec::new();
            for (_, index) in on {
                if !chain.contains(&index) {
                    chain.push(index);
                }
            }
            for pair in chain.windows(2) {
                let ends = [pair[0], pair[1]];
                let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                let [from, to] = ends.map(|i| self.points[i]);
                let Feature::Crack(crack) = line.feature else {
                    // an outline of a zone counts where nothing else is
                    let counts = line.feature.is_boundary()
                        || !known.contains_key(&key) && self.in_concrete(between([from, to], 0.5));
                    if counts {
                        known.insert(key, edges.len());
                        edges.push(Edge { ends, feature: line.feature, crack: None });
                    }
                    continue;
                };
                let edge = match known.get(&key) {
                    Some(&index) => {
                        let edge = &mut edges[index];
                        if let Some(first) = edge.crack {
                            return Err(GeometryError::SharedStretch { first, second: crack, from, to });
                        }
                        if edge.feature != Feature::Base {
                            continue;
                        }
                        edge.crack = Some(crack);
                        index
                    }
                    None if self.in_concrete(between([from, to], 0.5)) => {
                        known.insert(key, edges.len());
                        edges.push(Edge { ends, feature: line.feature, crack: Some(crack) });
                        edges.len() - 1
                    }
                    None => continue,
                };
                cracks[crack].push(CrackEdge { edge, forward: edges[edge].ends == ends });
            }
        }
        if let Some(crack) = cracks.iter().position(Vec::is_empty) {
            return Err(GeometryError::CrackOutside { crack });
        }
        Ok(Arrangement { points: self.points, edges, cracks })
    }

    /// Finds the points where cracks and outlines of zones meet other lines within both.
    fn cross(&mut self) {
        let wide = 10.0 * self.snap;
        for second in 0..self.lines.len() {
            if self.lines[second].feature.is_boundary() {
                continue;
            }
            for first in 0..second {
                let [one, two] = [first, second].map(|i| self.segment(&self.lines[i]));
                let ends = [self.lines[first].ends, self.lines[second].ends].concat();
                let Some([t, s]) = meeting(one, two) else { continue };
                if !(0.0..=1.0).contains(&t) || !(0.0..=1.0).contains(&s) {
                    continue;
                }
                let level_or_vertical = (0..2).any(|axis| two[0][axis] == two[1][axis]);
                let point = between(one, t);
                let point = if level_or_vertical { nearest(two, point) } else { point };
                let close = |&&i: &&usize| distance(self.points[i], point) <= wide;
                let index = match ends.iter().find(close) {
                    Some(&end) => end,
                    None => match self.points.iter().position(|&p| distance(p, point) <= self.snap) {
                        Some(index) => index,
                        None => {
                            self.points.push(point);
                            self.points.len() - 1
                        }
                    },
                };
                for line in [first, second] {
                    if !self.lines[line].ends.contains(&index) {
                        self.lines[line].on.push(index);
                    }
                }
            }
        }
    }
}
