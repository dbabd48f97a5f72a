//! Triangles between the edges of an arrangement, refined to a size and a smallest angle.

use std::collections::{HashMap, VecDeque};

use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

use super::arrangement::{Arrangement, Edge};
use super::geometry_error::GeometryError;
use super::plane_geometry::{Point, between, distance, dot, minus, nearest, orientation, smallest_altitude};
use super::size::SizeField;

/// Smallest angle aimed at, degrees; the theory of refinement promises 20.7° to 26°, practice gives 30°.
const LEAST_ANGLE: f64 = 28.0;
/// Largest circumradius of a triangle in wanted edge lengths (1/√3 in an equilateral one; refinement halves what is above).
const LARGEST_RADIUS: f64 = 0.85;
/// Edges of the arrangement that meet at less than this angle are split at equal distances from where they meet, degrees.
const ACUTE: f64 = 75.0;
/// Segments shorter than this share of the wanted length are not split.
const SHORTEST: f64 = 1.0 / 8.0;
/// Least distance of the first inner points from edges, in wanted lengths.
const FREE_MARGIN: f64 = 0.7;
/// Faces passed on the way to a new point.
const LONGEST_WALK: usize = 1000;
/// Largest number of cells.
pub const MOST_CELLS: f64 = 1e6;
/// Sweeps of smoothing, each followed by a new triangulation of the moved points.
const SWEEPS: usize = 6;

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;
type Face = FixedFaceHandle<InnerTag>;

/// Triangles, counter-clockwise, that fill the section.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulation {
    /// Points, those of the arrangement first.
    pub points: Vec<Point>,
    /// Corners of the triangles.
    pub triangles: Vec<[usize; 3]>,
    /// For each edge of the arrangement the points along it, from its first end to its second.
    pub chains: Vec<Vec<usize>>,
}

impl Triangulation {
    /// Splits the edges to the wanted length, refines (Ruppert, Shewchuk) and smooths.
    ///
    /// The result is the same bit for bit every time: nothing runs in parallel, and no unordered set is iterated.
    ///
    /// **Errors**: [`GeometryError::NotTriangulated`], [`GeometryError::TooManyCells`].
    pub fn new(arrangement: &Arrangement, size: &SizeField) -> Result<Self, GeometryError> {
        let (mut points, chains) = subdivided(arrangement, size)?;
        points.extend(lattice(arrangement, size));
        let mut refinement = Refinement::new(arrangement, size, points, chains)?;
        refinement.refine()?;
        let Refinement { cdt, chains, .. } = refinement;
        let points = cdt.vertices().map(|v| [v.position().x, v.position().y]).collect();
        let mut this = Self { points, triangles: Vec::new(), chains };
        this.triangulate(arrangement)?;
        for _ in 0..SWEEPS {
            if !this.smooth(arrangement) {
                break;
            }
            this.triangulate(arrangement)?;
        }
        Ok(this)
    }

    /// The triangles of the constrained Delaunay triangulation that lie to the left of the outline and galleries.
    fn triangulate(&mut self, arrangement: &Arrangement) -> Result<(), GeometryError> {
        let cdt = constrained(&self.points, &self.chains)?;
        // Edges of the outline and of galleries in their direction: the faces to their left are concrete.
        let mut inside = vec![false; cdt.num_all_faces()];
        let mut boundary = std::collections::HashSet::new();
        let mut pending = Vec::new();
        let corner = FixedVertexHandle::from_index;
        for (edge, chain) in arrangement.edges.iter().zip(&self.chains) {
            if !edge.on_boundary() {
                continue;
            }
            for pair in chain.windows(2) {
                let point = self.points[pair[0]];
                let found = cdt.get_edge_from_neighbors(corner(pair[0]), corner(pair[1]));
                let directed = found.ok_or(GeometryError::NotTriangulated { point })?;
                boundary.insert(directed.as_undirected().fix());
                let face = directed.face().fix().as_inner();
                pending.push(face.ok_or(GeometryError::NotTriangulated { point })?);
            }
        }
        while let Some(face) = pending.pop() {
            if std::mem::replace(&mut inside[face.index()], true) {
                continue;
            }
            for edge in cdt.face(face).adjacent_edges() {
                if !boundary.contains(&edge.as_undirected().fix()) {
                    let next = edge.rev().face().fix().as_inner();
                    let point = [edge.from().position().x, edge.from().position().y];
                    pending.push(next.ok_or(GeometryError::NotTriangulated { point })?);
                }
            }
        }
        let faces = cdt.inner_faces().filter(|face| inside[face.fix().index()]);
        self.triangles = faces.map(|face| face.vertices().map(|v| v.fix().index())).collect();
        Ok(())
    }

    /// Moves inner points freely, and points on edges along them, where this raises the least altitude around the point:
    /// towards the mean of the circumcentres around it, weighted by area (optimal Delaunay triangulation, Chen and Xu 2004),
    /// or of its neighbours. Whether any point moved.
    fn smooth(&mut self, arrangement: &Arrangement) -> bool {
        let mut edge_of = vec![None; self.points.len()];
        for (edge, chain) in arrangement.edges.iter().zip(&self.chains) {
            chain.iter().for_each(|&i| edge_of[i] = Some(arrangement.segment(edge)));
        }
        let mut star = vec![Vec::new(); self.points.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            triangle.iter().for_each(|&i| star[i].push(index));
        }
        let mut moved = false;
        for i in arrangement.points.len()..self.points.len() {
            let mut sum = [0.0; 3];
            let mut neighbours = [0.0; 3];
            for &triangle in &star[i] {
                let corners = self.triangles[triangle].map(|j| self.points[j]);
                let weight = orientation(corners[0], corners[1], corners[2]);
                let centre = circumcentre(corners);
                sum = [sum[0] + weight * centre[0], sum[1] + weight * centre[1], sum[2] + weight];
                for j in self.triangles[triangle].into_iter().filter(|&j| j != i) {
                    let p = self.points[j];
                    neighbours = [neighbours[0] + p[0], neighbours[1] + p[1], neighbours[2] + 1.0];
                }
            }
            let least = |points: &[Point]| {
                let altitudes =
                    star[i].iter().map(|&t| smallest_altitude(self.triangles[t].map(|j| points[j])));
                altitudes.fold(f64::INFINITY, f64::min)
            };
            let (start, mut best) = (self.points[i], least(&self.points));
            let mut best_point = start;
            for [x, y, weight] in [sum, neighbours] {
                let target = [x / weight, y / weight];
                let target = edge_of[i].map_or(target, |segment| nearest(segment, target));
                for share in [1.0, 0.5, 0.25] {
                    self.points[i] = between([start, target], share);
                    let altitude = least(&self.points);
                    if altitude > best {
                        (best, best_point, moved) = (altitude, self.points[i], true);
                    }
                }
            }
            self.points[i] = best_point;
        }
        moved
    }
}

/// The points of the arrangement, then those that split its edges; and the points along each edge.
fn subdivided(
    arrangement: &Arrangement,
    size: &SizeField,
) -> Result<(Vec<Point>, Vec<Vec<usize>>), GeometryError> {
    let mut points = arrangement.points.clone();
    let mut chains = Vec::new();
    for edge in &arrangement.edges {
        let segment = arrangement.segment(edge);
        let length = distance(segment[0], segment[1]);
        // Number of wanted lengths up to each sample along the edge, by steps that are short against the wanted length.
        let mut samples = vec![(0.0, 0.0)];
        let (mut at, mut count) = (0.0, 0.0);
        while at < length {
            let step = (0.2 * size.at(between(segment, at / length))).min(length - at);
            let middle = size.at(between(segment, (at + 0.5 * step) / length));
            at = if step == length - at { length } else { at + step };
            count += step / middle;
            samples.push((count, at / length));
            if samples.len() as f64 > MOST_CELLS {
                return Err(GeometryError::TooManyCells { cells: samples.len() as f64, most: MOST_CELLS });
            }
        }
        let parts = count.round().max(1.0);
        let mut chain = vec![edge.ends[0]];
        for part in 1..parts as usize {
            let wanted = count * part as f64 / parts;
            let next = samples.partition_point(|sample| sample.0 < wanted).clamp(1, samples.len() - 1);
            let ((c0, t0), (c1, t1)) = (samples[next - 1], samples[next]);
            points.push(between(segment, t0 + (t1 - t0) * (wanted - c0) / (c1 - c0)));
            chain.push(points.len() - 1);
        }
        chain.push(edge.ends[1]);
        chains.push(chain);
    }
    Ok((points, chains))
}

/// Corners of equilateral triangles of the general size that lie away from all edges and finer places.
fn lattice(arrangement: &Arrangement, size: &SizeField) -> Vec<Point> {
    let edge = size.general();
    let extreme = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
        arrangement.points.iter().map(|p| p[axis]).fold(start, pick)
    };
    let (left, right) = (extreme(0, f64::min, f64::INFINITY), extreme(0, f64::max, f64::NEG_INFINITY));
    let rise = 0.75f64.sqrt() * edge;
    let rows = (extreme(1, f64::max, 0.0) / rise) as usize;
    let columns = ((right - left) / edge) as usize + 1;
    let mut points = Vec::new();
    for row in 1..=rows {
        for column in 0..=columns {
            let point = [left + edge * (column as f64 + 0.5 * (row % 2) as f64), rise * row as f64];
            let away = |other: &Edge| {
                distance(nearest(arrangement.segment(other), point), point) > FREE_MARGIN * edge
            };
            if size.at(point) > 0.95 * edge
                && arrangement.edges.iter().all(away)
                && arrangement.in_concrete(point)
            {
                points.push(point);
            }
        }
    }
    points
}

fn constrained(points: &[Point], chains: &[Vec<usize>]) -> Result<Cdt, GeometryError> {
    let vertices = points.iter().map(|p| Point2::new(p[0], p[1])).collect();
    let edges = chains.iter().flat_map(|chain| chain.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    let mut conflict = None;
    let failed = GeometryError::NotTriangulated { point: points.first().copied().unwrap_or_default() };
    let cdt =
        Cdt::try_bulk_load_cdt(vertices, edges, |edge| conflict = Some(edge)).map_err(|_| failed.clone())?;
    match conflict {
        Some([from, _]) => Err(GeometryError::NotTriangulated { point: points[from] }),
        None if cdt.num_vertices() != points.len() => Err(failed),
        None => Ok(cdt),
    }
}

fn circumcentre([a, b, c]: [Point; 3]) -> Point {
    let (u, v) = (minus(b, a), minus(c, a));
    let (uu, vv, twice) = (dot(u, u), dot(v, v), 2.0 * orientation(a, b, c));
    [a[0] + (v[1] * uu - u[1] * vv) / twice, a[1] + (u[0] * vv - v[0] * uu) / twice]
}

/// Whether `p` sees the segment at more than 120°: it lies within the lens of two circular arcs over it.
fn encroaches([a, b]: [Point; 2], p: Point) -> bool {
    let (to_a, to_b) = (minus(a, p), minus(b, p));
    let along = dot(to_a, to_b);
    along < 0.0 && along * along > 0.25 * dot(to_a, to_a) * dot(to_b, to_b)
}

struct Refinement<'a> {
    arrangement: &'a Arrangement,
    size: &'a SizeField,
    cdt: Cdt,
    chains: Vec<Vec<usize>>,
    /// The arrangement's edge of each segment, by its two points in ascending order.
    segments: HashMap<[usize; 2], usize>,
    /// For each point on an edge of the arrangement, this edge; ends of edges and inner points have none.
    edge_of: Vec<Option<usize>>,
    /// Whether edges meet at a small angle in each point of the arrangement.
    acute: Vec<bool>,
    pending_segments: VecDeque<[usize; 2]>,
    pending_faces: VecDeque<Face>,
}

impl<'a> Refinement<'a> {
    fn new(
        arrangement: &'a Arrangement,
        size: &'a SizeField,
        points: Vec<Point>,
        chains: Vec<Vec<usize>>,
    ) -> Result<Self, GeometryError> {
        let cdt = constrained(&points, &chains)?;
        let mut segments = HashMap::new();
        let mut edge_of = vec![None; points.len()];
        let mut pending_segments = VecDeque::new();
        for (edge, chain) in chains.iter().enumerate() {
            chain[1..chain.len() - 1].iter().for_each(|&i| edge_of[i] = Some(edge));
            for pair in chain.windows(2) {
                let key = [pair[0].min(pair[1]), pair[0].max(pair[1])];
                segments.insert(key, edge);
                pending_segments.push_back(key);
            }
        }
        let pending_faces = cdt.fixed_inner_faces().collect();
        let acute = acute(arrangement);
        Ok(Self { arrangement, size, cdt, chains, segments, edge_of, acute, pending_segments, pending_faces })
    }

    fn point(&self, index: usize) -> Point {
        let position = self.cdt.vertex(FixedVertexHandle::from_index(index)).position();
        [position.x, position.y]
    }

    fn corners(&self, face: Face) -> [usize; 3] {
        self.cdt.face(face).vertices().map(|v| v.fix().index())
    }

    fn refine(&mut self) -> Result<(), GeometryError> {
        loop {
            // A triangulation has twice as many triangles as points, and there are three cells to a triangle.
            let cells = 6.0 * self.cdt.num_vertices() as f64;
            if cells > MOST_CELLS {
                return Err(GeometryError::TooManyCells { cells, most: MOST_CELLS });
            }
            if let Some(segment) = self.pending_segments.pop_front() {
                if self.segments.contains_key(&segment) && self.is_encroached(segment) {
                    self.split(segment)?;
                }
            } else if let Some(face) = self.pending_faces.pop_front() {
                self.improve(face)?;
            } else {
                return Ok(());
            }
        }
    }

    fn is_encroached(&self, segment: [usize; 2]) -> bool {
        let ends = segment.map(|i| self.point(i));
        let [from, to] = segment.map(FixedVertexHandle::from_index);
        let Some(edge) = self.cdt.get_edge_from_neighbors(from, to) else { return false };
        [edge, edge.rev()].into_iter().any(|side| {
            let Some(face) = side.face().as_inner() else { return false };
            let Some(apex) = side.opposite_position() else { return false };
            encroaches(ends, [apex.x, apex.y]) && self.is_concrete(face.fix())
        })
    }

    fn is_concrete(&self, face: Face) -> bool {
        let [a, b, c] = self.corners(face).map(|i| self.point(i));
        self.arrangement.in_concrete([(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0])
    }

    /// Splits a segment in the middle or, next to a small angle, at a power of two from there. Whether it was.
    fn split(&mut self, segment: [usize; 2]) -> Result<bool, GeometryError> {
        let ends = segment.map(|i| self.point(i));
        let length = distance(ends[0], ends[1]);
        if length < SHORTEST * self.size.at(between(ends, 0.5)) {
            return Ok(false);
        }
        let acute = segment.map(|i| self.acute.get(i).copied().unwrap_or(false));
        let shell = (0.5 * length).log2().round().exp2() / length;
        let share = match acute {
            [true, false] => shell,
            [false, true] => 1.0 - shell,
            _ => 0.5,
        };
        let point = between(ends, share);
        let failed = GeometryError::NotTriangulated { point };
        let [from, to] = segment.map(FixedVertexHandle::from_index);
        let edge = self.cdt.get_edge_from_neighbors(from, to).ok_or(failed.clone())?;
        let edge = edge.as_undirected().fix();
        if !self.cdt.remove_constraint_edge(edge) {
            return Err(failed);
        }
        let count = self.cdt.num_vertices();
        let position = Point2::new(point[0], point[1]);
        let middle = self.cdt.insert_with_hint(position, from).map_err(|_| failed.clone())?;
        if middle.index() != count {
            return Err(failed);
        }
        for (a, b) in [(from, middle), (middle, to)] {
            if !self.cdt.can_add_constraint(a, b) {
                return Err(failed);
            }
            self.cdt.add_constraint(a, b);
            if self.cdt.get_edge_from_neighbors(a, b).is_none() {
                return Err(failed);
            }
        }
        let edge = self.segments.remove(&segment).ok_or(failed.clone())?;
        self.edge_of.push(Some(edge));
        let chain = &mut self.chains[edge];
        let at = chain.windows(2).position(|pair| pair.iter().all(|i| segment.contains(i))).ok_or(failed)?;
        chain.insert(at + 1, count);
        for end in segment {
            let key = [end.min(count), end.max(count)];
            self.segments.insert(key, edge);
            self.pending_segments.push_back(key);
        }
        self.look_around(middle);
        Ok(true)
    }

    /// Faces around a new point are looked at again, and segments opposite to it.
    fn look_around(&mut self, vertex: FixedVertexHandle) {
        for edge in self.cdt.vertex(vertex).out_edges() {
            if let Some(face) = edge.face().as_inner() {
                self.pending_faces.push_back(face.fix());
                if edge.next().is_constraint_edge() {
                    let [a, b] = edge.next().vertices().map(|v| v.fix().index());
                    self.pending_segments.push_back([a.min(b), a.max(b)]);
                }
            }
        }
    }

    /// Puts a point at the circumcentre of a face that is too large or too thin, or splits segments that are in its way.
    fn improve(&mut self, face: Face) -> Result<(), GeometryError> {
        let corners = self.corners(face);
        let points = corners.map(|i| self.point(i));
        let centroid = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / 3.0);
        let wanted = self.size.at(centroid);
        let twice_area = orientation(points[0], points[1], points[2]);
        // What rounding leaves between points of a straight line is no triangle.
        if twice_area < 1e-9 * wanted * wanted {
            return Ok(());
        }
        let centre = circumcentre(points);
        let radius = distance(centre, points[0]);
        let sides = [0, 1, 2].map(|i| distance(points[i], points[(i + 1) % 3]));
        let shortest = (0..3).min_by(|&a, &b| sides[a].total_cmp(&sides[b])).unwrap_or(0);
        let large = radius > LARGEST_RADIUS * wanted;
        let thin = sides[shortest] < 2.0 * LEAST_ANGLE.to_radians().sin() * radius;
        let spans_corner = || self.spans_small_angle([corners[shortest], corners[(shortest + 1) % 3]]);
        if !(large || thin && !spans_corner()) || !self.arrangement.in_concrete(centroid) {
            return Ok(());
        }
        let blocking = self.blocking(face, centre);
        let mut split = false;
        for segment in blocking.iter().copied() {
            let [a, b] = segment.map(|i| self.point(i));
            // A segment of the wanted length stays, if only the size is at stake.
            if self.segments.contains_key(&segment) && (thin || distance(a, b) > 1.3 * wanted) {
                split |= self.split(segment)?;
            }
        }
        if split {
            self.pending_faces.push_back(face);
        }
        if blocking.is_empty() {
            let count = self.cdt.num_vertices();
            let failed = GeometryError::NotTriangulated { point: centre };
            let (position, hint) =
                (Point2::new(centre[0], centre[1]), FixedVertexHandle::from_index(corners[0]));
            let vertex = self.cdt.insert_with_hint(position, hint).map_err(|_| failed)?;
            if vertex.index() == count {
                self.edge_of.push(None);
                self.look_around(vertex);
            }
        }
        Ok(())
    }

    /// Whether two points lie on different edges that meet at a small angle.
    fn spans_small_angle(&self, ends: [usize; 2]) -> bool {
        let [Some(one), Some(two)] = ends.map(|i| self.edge_of.get(i).copied().flatten()) else {
            return false;
        };
        let [one, two] = [one, two].map(|i| self.arrangement.edges[i].ends);
        one != two && one.iter().any(|end| two.contains(end) && self.acute[*end])
    }

    /// The segment between a face and a new point, or else those that the point encroaches upon.
    fn blocking(&self, face: Face, point: Point) -> Vec<[usize; 2]> {
        let key = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        let (mut at, mut entered) = (self.cdt.face(face), None);
        // Walks through the edges that the point lies beyond; among Delaunay triangles this ends.
        for _ in 0..LONGEST_WALK {
            let beyond = at.adjacent_edges().into_iter().find(|edge| {
                let [a, b] = edge.positions().map(|p| [p.x, p.y]);
                Some(edge.fix()) != entered && orientation(a, b, point) < 0.0
            });
            let Some(edge) = beyond else { break };
            if edge.is_constraint_edge() {
                return vec![key(edge.vertices().map(|v| v.fix().index()))];
            }
            entered = Some(edge.rev().fix());
            match edge.rev().face().as_inner() {
                Some(next) => at = next,
                None => return Vec::new(),
            }
        }
        let mut pending: Vec<Face> = vec![at.fix()];
        let mut seen = pending.clone();
        let mut found = Vec::new();
        while let Some(face) = pending.pop() {
            for edge in self.cdt.face(face).adjacent_edges() {
                let ends = edge.vertices().map(|v| v.fix().index());
                if edge.is_constraint_edge() {
                    if encroaches(ends.map(|i| self.point(i)), point) {
                        found.push(key(ends));
                    }
                    continue;
                }
                let Some(next) = edge.rev().face().as_inner() else { continue };
                let (next_centre, radius_squared) = next.circumcircle();
                let [dx, dy] = [next_centre.x - point[0], next_centre.y - point[1]];
                if dx * dx + dy * dy < radius_squared && !seen.contains(&next.fix()) {
                    seen.push(next.fix());
                    pending.push(next.fix());
                }
            }
        }
        found
    }
}

/// For each point of the arrangement whether two of its edges have less than [`ACUTE`] between them.
fn acute(arrangement: &Arrangement) -> Vec<bool> {
    let mut directions = vec![Vec::new(); arrangement.points.len()];
    for edge in &arrangement.edges {
        let [a, b] = arrangement.segment(edge);
        let [dx, dy] = minus(b, a);
        directions[edge.ends[0]].push(dy.atan2(dx));
        directions[edge.ends[1]].push((-dy).atan2(-dx));
    }
    let narrow = |mut angles: Vec<f64>| {
        angles.sort_by(f64::total_cmp);
        let next = angles.iter().cycle().skip(1);
        angles.iter().zip(next).any(|(a, b)| {
            let between = (b - a).rem_euclid(std::f64::consts::TAU);
            between > 0.0 && between < ACUTE.to_radians()
        })
    };
    directions.into_iter().map(narrow).collect()
}
