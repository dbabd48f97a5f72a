//! Cells, blocks and the seams between them from a triangulation.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::Range;

use super::arrangement::{Arrangement, Geometry};
use super::geometry_error::{Feature, GeometryError};
use super::plane_geometry::{Point, between, distance, orientation};
use super::quality::{LEAST_ANGLE, Quality};
use super::size::{COARSENING, SizeField};
use super::triangulation::{MOST_CELLS, Triangulation};

/// Blocks smaller than the square of this many element sizes are refused.
const LEAST_BLOCK: f64 = 0.1;

/// Nodes and cells of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRange {
    /// Its nodes.
    pub nodes: Range<usize>,
    /// Its cells.
    pub cells: Range<usize>,
}

/// Part of a crack between two bodies: chains of nodes that lie opposite each other.
///
/// Both run from upstream to downstream or, on a vertical crack, from bottom to top. On a crack that covers the whole base
/// the chain of the ground is longer: it goes on for one element size beyond heel and toe.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// Index of the crack.
    pub crack: usize,
    /// The body to the right of the chains' direction: a block or, as number `blocks.len()`, the ground.
    pub below: usize,
    /// The body to the left.
    pub above: usize,
    /// Nodes of the body below.
    pub lower: Vec<usize>,
    /// Nodes of the body above.
    pub upper: Vec<usize>,
}

/// A meshed section. Blocks are in the order of their lowest points, of the leftmost ones among these, of their centroids.
#[derive(Clone, Debug, PartialEq)]
pub struct Meshed {
    /// Unloaded positions, m.
    pub nodes: Vec<Point>,
    /// Four corners, counter-clockwise, and the centre of each cell.
    pub cells: Vec<[usize; 5]>,
    /// The blocks; those of nodes and cells follow one another.
    pub blocks: Vec<BlockRange>,
    /// What lies between blocks, by crack and along it.
    pub seams: Vec<Seam>,
    /// Nodes of the upstream side from base to crest; doubled where a crack ends.
    pub upstream: Vec<usize>,
    /// The same of the downstream side.
    pub downstream: Vec<usize>,
    /// Nodes that the ground holds, from heel to toe.
    pub base: Vec<usize>,
    /// Nodes of the ground under cracks along the base.
    pub ground: Range<usize>,
}

/// Meshes a cracked section: arrangement, triangulation, quadrilaterals.
///
/// Cracks and outline are split into lengths of about 2.6 element sizes, the section into triangles with such edges,
/// and each triangle into three quadrilateral cells. Near narrow places, and cracks with a size of their own, cells are smaller.
///
/// **Errors**: all of [`GeometryError`].
pub fn mesh(geometry: &Geometry) -> Result<(Meshed, Quality), GeometryError> {
    let arrangement = Arrangement::new(geometry)?;
    let cells = arrangement.area() / geometry.element_size.powi(2);
    if cells > MOST_CELLS {
        return Err(GeometryError::TooManyCells { cells, most: MOST_CELLS });
    }
    let size = SizeField::new(&arrangement, geometry);
    let triangulation = Triangulation::new(&arrangement, &size)?;
    let meshed = Meshed::new(&arrangement, &triangulation, geometry.element_size)?;
    if meshed.cells.len() as f64 > MOST_CELLS {
        return Err(GeometryError::TooManyCells { cells: meshed.cells.len() as f64, most: MOST_CELLS });
    }
    let quality = Quality::of(&meshed.nodes, &meshed.cells);
    // Written so that not-a-number is refused.
    if quality.smallest_angle.0 >= LEAST_ANGLE {
        return Ok((meshed, quality));
    }
    let (angle, point) = quality.smallest_angle;
    Err(GeometryError::Sliver { point, angle, least: LEAST_ANGLE })
}

/// A side of a triangle: index of the triangle and of the corner where the side starts.
type Side = (usize, usize);

/// The triangulation with the blocks of its triangles.
struct Topology<'a> {
    arrangement: &'a Arrangement,
    triangulation: &'a Triangulation,
    /// The triangle side that runs from one point to another.
    sides: HashMap<[usize; 2], Side>,
    /// The crack of each pair of points, in both directions.
    cracks: HashMap<[usize; 2], usize>,
    /// Block of each triangle.
    block_of: Vec<usize>,
    blocks: usize,
}

impl<'a> Topology<'a> {
    fn new(arrangement: &'a Arrangement, triangulation: &'a Triangulation) -> Self {
        let mut sides = HashMap::new();
        for (index, triangle) in triangulation.triangles.iter().enumerate() {
            for k in 0..3 {
                sides.insert([triangle[k], triangle[(k + 1) % 3]], (index, k));
            }
        }
        let mut cracks = HashMap::new();
        for (edge, chain) in arrangement.edges.iter().zip(&triangulation.chains) {
            if let Some(crack) = edge.crack {
                for pair in chain.windows(2) {
                    cracks.insert([pair[0], pair[1]], crack);
                    cracks.insert([pair[1], pair[0]], crack);
                }
            }
        }
        let block_of = vec![usize::MAX; triangulation.triangles.len()];
        let mut this = Self { arrangement, triangulation, sides, cracks, block_of, blocks: 0 };
        this.fill();
        this.order();
        this
    }

    /// The triangle on the other side, if there is one and no crack in between.
    fn across(&self, (triangle, k): Side) -> Option<Side> {
        let corners = self.triangulation.triangles[triangle];
        let reverse = [corners[(k + 1) % 3], corners[k]];
        if self.cracks.contains_key(&reverse) { None } else { self.sides.get(&reverse).copied() }
    }

    fn fill(&mut self) {
        for start in 0..self.block_of.len() {
            if self.block_of[start] != usize::MAX {
                continue;
            }
            let mut pending = vec![start];
            self.block_of[start] = self.blocks;
            while let Some(triangle) = pending.pop() {
                for k in 0..3 {
                    let Some((next, _)) = self.across((triangle, k)) else { continue };
                    if self.block_of[next] == usize::MAX {
                        self.block_of[next] = self.blocks;
                        pending.push(next);
                    }
                }
            }
            self.blocks += 1;
        }
    }

    fn corners(&self, triangle: usize) -> [Point; 3] {
        self.triangulation.triangles[triangle].map(|i| self.triangulation.points[i])
    }

    /// Area and centroid of each block.
    fn areas(&self) -> Vec<(f64, Point)> {
        let mut sums = vec![[0.0; 3]; self.blocks];
        for (triangle, &block) in self.block_of.iter().enumerate() {
            let [a, b, c] = self.corners(triangle);
            let area = 0.5 * orientation(a, b, c);
            let sum = &mut sums[block];
            sum[0] += area;
            sum[1] += area * (a[0] + b[0] + c[0]) / 3.0;
            sum[2] += area * (a[1] + b[1] + c[1]) / 3.0;
        }
        sums.into_iter().map(|[area, x, y]| (area, [x / area, y / area])).collect()
    }

    /// Numbers the blocks by (y, x) of their lowest point, the leftmost of several, then by (y, x) of their centroid.
    fn order(&mut self) {
        let mut lowest = vec![[f64::INFINITY; 2]; self.blocks];
        for (triangle, &block) in self.block_of.iter().enumerate() {
            for p in self.corners(triangle) {
                if by_height(&p, &lowest[block]).is_lt() {
                    lowest[block] = p;
                }
            }
        }
        let areas = self.areas();
        let mut order: Vec<usize> = (0..self.blocks).collect();
        order.sort_by(|&a, &b| {
            by_height(&lowest[a], &lowest[b]).then_with(|| by_height(&areas[a].1, &areas[b].1))
        });
        let mut number = vec![0; self.blocks];
        order.iter().enumerate().for_each(|(new, &old)| number[old] = new);
        self.block_of.iter_mut().for_each(|block| *block = number[*block]);
    }

    /// For each corner of each triangle the first corner (three times the triangle + k) of the same node: around a point,
    /// triangles that no crack separates share a node.
    fn shared_corners(&self) -> Vec<usize> {
        let mut root: Vec<usize> = (0..3 * self.block_of.len()).collect();
        let find = |root: &mut Vec<usize>, mut i: usize| {
            while root[i] != i {
                root[i] = root[root[i]];
                i = root[i];
            }
            i
        };
        for triangle in 0..self.block_of.len() {
            for k in 0..3 {
                let Some((other, m)) = self.across((triangle, k)) else { continue };
                for (one, two) in [(k, (m + 1) % 3), ((k + 1) % 3, m)] {
                    let (a, b) = (find(&mut root, 3 * triangle + one), find(&mut root, 3 * other + two));
                    root[a.max(b)] = a.min(b);
                }
            }
        }
        (0..root.len()).map(|i| find(&mut root, i)).collect()
    }
}

fn by_height(a: &Point, b: &Point) -> Ordering {
    a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))
}

impl Meshed {
    fn new(
        arrangement: &Arrangement,
        triangulation: &Triangulation,
        element_size: f64,
    ) -> Result<Self, GeometryError> {
        let topology = Topology::new(arrangement, triangulation);
        let least = (LEAST_BLOCK * element_size).powi(2);
        if let Some(&(area, point)) = topology.areas().iter().find(|(area, _)| *area < least) {
            return Err(GeometryError::TinyBlock { point, area, least });
        }
        let mut numbering = Numbering::new(&topology, element_size);
        let seams = numbering.seams(element_size)?;
        let side = |feature: Feature| {
            let edges = arrangement.edges.iter().zip(&triangulation.chains);
            let pairs = edges.filter(|(edge, _)| edge.feature == feature && edge.crack.is_none());
            pairs.flat_map(|(_, chain)| chain.windows(2).map(|pair| [pair[0], pair[1]])).collect::<Vec<_>>()
        };
        let mut upstream = numbering.chain(side(Feature::Upstream));
        upstream.reverse();
        let downstream = numbering.chain(side(Feature::Downstream));
        let base = numbering.chain(side(Feature::Base));
        let Numbering { nodes, cells, blocks, ground, .. } = numbering;
        let ground = ground..nodes.len();
        Ok(Self { nodes, cells, blocks, seams, upstream, downstream, base, ground })
    }
}

struct Numbering<'a> {
    topology: &'a Topology<'a>,
    nodes: Vec<Point>,
    cells: Vec<[usize; 5]>,
    blocks: Vec<BlockRange>,
    /// Nodes at the corners and in the middle of the sides of each triangle.
    corner_nodes: Vec<[usize; 3]>,
    middle_nodes: Vec<[usize; 3]>,
    /// First node of the ground.
    ground: usize,
}

impl<'a> Numbering<'a> {
    /// Numbers blocks, within them triangles in rows as high as their edges are long, and nodes in the order of their first use.
    fn new(topology: &'a Topology, element_size: f64) -> Self {
        let count = topology.block_of.len();
        let shared = topology.shared_corners();
        let row = |triangle: usize| {
            let [a, b, c] = topology.corners(triangle);
            let y = (a[1] + b[1] + c[1]) / (3.0 * COARSENING * element_size);
            (topology.block_of[triangle], y.floor() as i64, a[0] + b[0] + c[0])
        };
        let mut order: Vec<_> = (0..count).map(|triangle| (row(triangle), triangle)).collect();
        order.sort_by(|((b0, y0, x0), _), ((b1, y1, x1), _)| (b0, y0).cmp(&(b1, y1)).then(x0.total_cmp(x1)));

        let unset = [usize::MAX; 3];
        let mut this = Self {
            topology,
            nodes: Vec::new(),
            cells: Vec::with_capacity(3 * count),
            blocks: Vec::with_capacity(topology.blocks),
            corner_nodes: vec![unset; count],
            middle_nodes: vec![unset; count],
            ground: 0,
        };
        let mut node_of_root = vec![usize::MAX; 3 * count];
        for ((block, _, _), triangle) in order {
            if block == this.blocks.len() {
                let (node, cell) = (this.nodes.len(), this.cells.len());
                this.blocks.push(BlockRange { nodes: node..node, cells: cell..cell });
            }
            this.add_triangle(triangle, &shared, &mut node_of_root);
            this.blocks[block].nodes.end = this.nodes.len();
            this.blocks[block].cells.end = this.cells.len();
        }
        this.ground = this.nodes.len();
        this
    }

    fn add_triangle(&mut self, triangle: usize, shared: &[usize], node_of_root: &mut [usize]) {
        let topology = self.topology;
        let points = topology.corners(triangle);
        for k in 0..3 {
            let node = &mut node_of_root[shared[3 * triangle + k]];
            if *node == usize::MAX {
                *node = self.push(points[k]);
            }
            self.corner_nodes[triangle][k] = *node;
            if self.middle_nodes[triangle][k] == usize::MAX {
                let middle = self.push(middle(points[k], points[(k + 1) % 3]));
                self.middle_nodes[triangle][k] = middle;
                if let Some((other, m)) = topology.across((triangle, k)) {
                    self.middle_nodes[other][m] = middle;
                }
            }
        }
        let mean = |points: &[Point]| {
            [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64)
        };
        let centroid = self.push(mean(&points));
        let (corners, middles) = (self.corner_nodes[triangle], self.middle_nodes[triangle]);
        for k in 0..3 {
            let quadrilateral = [corners[k], middles[k], centroid, middles[(k + 2) % 3]];
            let centre = self.push(mean(&quadrilateral.map(|i| self.nodes[i])));
            let [a, b, c, d] = quadrilateral;
            self.cells.push([a, b, c, d, centre]);
        }
    }

    fn push(&mut self, point: Point) -> usize {
        self.nodes.push(point);
        self.nodes.len() - 1
    }

    /// Nodes along triangle sides that follow one another with the concrete to their left; where they change, both.
    fn chain(&self, pairs: Vec<[usize; 2]>) -> Vec<usize> {
        let mut chain: Vec<usize> = Vec::new();
        for pair in pairs {
            let Some(&side) = self.topology.sides.get(&pair) else { continue };
            for node in self.along(side) {
                if chain.last() != Some(&node) {
                    chain.push(node);
                }
            }
        }
        chain
    }

    /// The three nodes of a triangle's side, in the direction that has the triangle to its left.
    fn along(&self, (triangle, k): Side) -> [usize; 3] {
        let corners = self.corner_nodes[triangle];
        [corners[k], self.middle_nodes[triangle][k], corners[(k + 1) % 3]]
    }

    /// The seams of all cracks, and nodes of the ground under cracks along the base.
    fn seams(&mut self, element_size: f64) -> Result<Vec<Seam>, GeometryError> {
        let topology = self.topology;
        let ground_body = topology.blocks;
        let mut seams: Vec<Seam> = Vec::new();
        let mut ground_nodes: HashMap<usize, usize> = HashMap::new();
        for (crack, parts) in topology.arrangement.cracks.iter().enumerate() {
            let first_seam = seams.len();
            let mut end = usize::MAX;
            for part in parts {
                let mut chain = topology.triangulation.chains[part.edge].clone();
                if !part.forward {
                    chain.reverse();
                }
                for pair in chain.windows(2) {
                    let (from, to) = (pair[0], pair[1]);
                    let [left, right] =
                        [[from, to], [to, from]].map(|pair| topology.sides.get(&pair).copied());
                    let body = |side: Option<Side>| side.map_or(ground_body, |(t, _)| topology.block_of[t]);
                    let (below, above) = (body(right), body(left));
                    if below == above {
                        let point = topology.triangulation.points[from];
                        return Err(GeometryError::NotSeparating { crack, point });
                    }
                    let [mut lower, mut upper] = [right, left].map(|side| side.map(|side| self.along(side)));
                    lower.iter_mut().for_each(|nodes| nodes.reverse());
                    let positions = [from, to].map(|i| topology.triangulation.points[i]);
                    let mut of_ground = || {
                        let [a, b] = [0, 1].map(|k| {
                            *ground_nodes.entry(pair[k]).or_insert_with(|| {
                                self.nodes.push(positions[k]);
                                self.nodes.len() - 1
                            })
                        });
                        self.nodes.push(middle(positions[0], positions[1]));
                        [a, self.nodes.len() - 1, b]
                    };
                    let lower = lower.take().unwrap_or_else(&mut of_ground);
                    let upper = upper.take().unwrap_or_else(&mut of_ground);
                    match seams.last_mut() {
                        Some(seam)
                            if seam.crack == crack
                                && (seam.below, seam.above) == (below, above)
                                && end == from
                                && seam.lower.last() == Some(&lower[0])
                                && seam.upper.last() == Some(&upper[0]) =>
                        {
                            seam.lower.extend(&lower[1..]);
                            seam.upper.extend(&upper[1..]);
                        }
                        _ => {
                            let (lower, upper) = (lower.to_vec(), upper.to_vec());
                            seams.push(Seam { crack, below, above, lower, upper });
                        }
                    }
                    end = to;
                }
            }
            self.extend_ground(&mut seams[first_seam..], element_size);
        }
        Ok(seams)
    }

    /// Under a crack that covers the whole base the ground goes on by an element size at heel and toe.
    fn extend_ground(&mut self, seams: &mut [Seam], element_size: f64) {
        let base = self.topology.arrangement.edges.iter().filter(|edge| edge.feature == Feature::Base);
        let ends: Vec<Point> = base.flat_map(|edge| self.topology.arrangement.segment(edge)).collect();
        let Some(toe) = ends.iter().copied().max_by(|a, b| a[0].total_cmp(&b[0])) else { return };
        let ground = self.topology.blocks;
        let covers = |seam: &&mut Seam| seam.below == ground;
        let length: f64 = seams
            .iter()
            .filter(|seam| seam.below == ground)
            .map(|seam| distance(self.nodes[seam.lower[0]], self.nodes[seam.lower[seam.lower.len() - 1]]))
            .sum();
        if (length - toe[0]).abs() > 1e-9 * toe[0] {
            return;
        }
        if let Some(seam) = seams.iter_mut().find(covers) {
            let node = self.push([-element_size, 0.0]);
            seam.lower.insert(0, node);
        }
        if let Some(seam) = seams.iter_mut().rev().find(covers) {
            let node = self.push([toe[0] + element_size, 0.0]);
            seam.lower.push(node);
        }
    }
}

/// The same point bit for bit from either side.
fn middle(a: Point, b: Point) -> Point {
    let (a, b) = if by_height(&a, &b).is_le() { (a, b) } else { (b, a) };
    between([a, b], 0.5)
}
