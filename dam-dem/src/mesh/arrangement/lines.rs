//! The lines of a section as given, and where they meet.

use std::collections::BTreeMap;

use super::{Arrangement, CrackEdge, Edge, Geometry, LED, encloses, height};
use crate::mesh::geometry_error::{Feature, GeometryError};
use crate::mesh::plane_geometry::{
    Point, area, between, cross_properly, distance, dot, meeting, minus, nearest, nearest_share,
};

/// Points closer than this share of the height are one.
const SNAP: f64 = 1e-6;

/// Lines as given, by the points at their ends, and the points that were found to lie on them.
pub(super) struct Lines {
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
    pub(super) fn new(geometry: &Geometry) -> Self {
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
    pub(super) fn check_outline(&self, geometry: &Geometry) -> Result<(), GeometryError> {
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

    pub(super) fn add_crack(&mut self, index: usize, chain: &[Point]) -> Result<(), GeometryError> {
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
    pub(super) fn add_zone(&mut self, index: usize, outline: &[Point]) -> Result<(), GeometryError> {
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
    pub(super) fn split(mut self) -> Result<Arrangement, GeometryError> {
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
