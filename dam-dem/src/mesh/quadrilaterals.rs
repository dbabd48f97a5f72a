//! Cells, blocks and the seams between them from a tiling.

use std::collections::HashMap;

use super::arrangement::{Arrangement, Geometry, within};
use super::geometry_error::{Feature, GeometryError};
use super::plane_geometry::{Point, between, distance};
use super::quality::{LEAST_ANGLE, Quality};
use super::size::{COARSENING, SizeField};
use super::topology::{CORNERS, Polygon, Side, Tiling, Topology, by_height};
use super::triangulation::{MOST_CELLS, Triangulation};
use super::{Mesh, Seam};
use crate::block::Block;

/// Blocks smaller than the square of this many element sizes are refused.
const LEAST_BLOCK: f64 = 0.1;

/// Meshes a cracked section: arrangement, triangulation, quadrilaterals.
///
/// Cracks and outline are split into lengths of about 2.6 element sizes, the section into triangles with such edges,
/// and each triangle into three quadrilateral cells. Near narrow places, and cracks with a size of their own, cells are smaller.
///
/// **Errors**: all of [`GeometryError`].
pub fn mesh(geometry: &Geometry) -> Result<(Mesh, Quality), GeometryError> {
    let arrangement = Arrangement::new(geometry)?;
    let cells = arrangement.area() / geometry.element_size.powi(2);
    if cells > MOST_CELLS {
        return Err(GeometryError::TooManyCells { cells, most: MOST_CELLS });
    }
    let size = SizeField::new(&arrangement, geometry);
    let tiling = Triangulation::new(&arrangement, &size)?.into();
    let meshed = Mesh::of_tiling(&arrangement, &tiling, geometry.element_size, geometry.zones)?;
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

impl Mesh {
    /// Quadrilaterals become cells as they are. Where there are triangles, each of them becomes three cells, and each
    /// quadrilateral four: they meet in the middle of their sides.
    ///
    /// **Errors**: [`GeometryError::TinyBlock`], [`GeometryError::NotSeparating`].
    pub(super) fn of_tiling(
        arrangement: &Arrangement,
        tiling: &Tiling,
        element_size: f64,
        zones: &[Vec<[f64; 2]>],
    ) -> Result<Self, GeometryError> {
        let topology = Topology::new(arrangement, tiling);
        let least = (LEAST_BLOCK * element_size).powi(2);
        if let Some(&(area, point)) = topology.areas().iter().find(|(area, _)| *area < least) {
            return Err(GeometryError::TinyBlock { point, area, least });
        }
        let mut numbering = Numbering::new(&topology, element_size);
        let zones = numbering.zones(zones)?;
        let seams = numbering.seams()?;
        let side = |feature: Feature| {
            let edges = arrangement.edges.iter().zip(&tiling.chains);
            let pairs = edges.filter(|(edge, _)| edge.feature == feature && edge.crack.is_none());
            pairs.flat_map(|(_, chain)| chain.windows(2).map(|pair| [pair[0], pair[1]])).collect::<Vec<_>>()
        };
        let mut upstream = numbering.chain(side(Feature::Upstream));
        upstream.reverse();
        let downstream = numbering.chain(side(Feature::Downstream));
        let base = numbering.chain(side(Feature::Base));
        let Numbering { nodes, cells, blocks, ground, .. } = numbering;
        let ground = ground..nodes.len();
        Ok(Self { nodes, cells, blocks, seams, upstream, downstream, base, ground, zones })
    }
}

struct Numbering<'a> {
    topology: &'a Topology<'a>,
    nodes: Vec<Point>,
    cells: Vec<[usize; 5]>,
    blocks: Vec<Block>,
    /// Whether polygons are cells as they are.
    whole: bool,
    /// Nodes at the corners and in the middle of the sides of each polygon.
    corner_nodes: Vec<[usize; CORNERS]>,
    middle_nodes: Vec<[usize; CORNERS]>,
    /// First node of the ground.
    ground: usize,
}

impl<'a> Numbering<'a> {
    /// Numbers blocks, within them polygons in rows as high as their edges are long, and nodes in the order of their first use.
    fn new(topology: &'a Topology, element_size: f64) -> Self {
        let count = topology.block_of.len();
        let shared = topology.shared_corners();
        let whole =
            topology.tiling.polygons.iter().all(|polygon| matches!(polygon, Polygon::Quadrilateral(_)));
        let coarsening = if whole { 1.0 } else { COARSENING };
        let row = |polygon: usize| {
            let corners = topology.indices(polygon).len() as f64;
            let sum = |axis: usize| topology.corners(polygon).map(|p| p[axis]).sum::<f64>();
            let y = sum(1) / (corners * coarsening * element_size);
            (topology.block_of[polygon], y.floor() as i64, sum(0) * (3.0 / corners))
        };
        let mut order: Vec<_> = (0..count).map(|polygon| (row(polygon), polygon)).collect();
        order.sort_by(|((b0, y0, x0), _), ((b1, y1, x1), _)| (b0, y0).cmp(&(b1, y1)).then(x0.total_cmp(x1)));

        let unset = [usize::MAX; CORNERS];
        let mut this = Self {
            topology,
            whole,
            nodes: Vec::new(),
            cells: Vec::with_capacity(3 * count),
            blocks: Vec::with_capacity(topology.blocks),
            corner_nodes: vec![unset; count],
            middle_nodes: vec![unset; count],
            ground: 0,
        };
        let mut node_of_root = vec![usize::MAX; CORNERS * count];
        for ((block, _, _), polygon) in order {
            if block == this.blocks.len() {
                let (node, cell) = (this.nodes.len(), this.cells.len());
                this.blocks.push(Block { nodes: node..node, cells: cell..cell });
            }
            this.add_polygon(polygon, &shared, &mut node_of_root);
            this.blocks[block].nodes.end = this.nodes.len();
            this.blocks[block].cells.end = this.cells.len();
        }
        this.ground = this.nodes.len();
        this
    }

    fn add_polygon(&mut self, polygon: usize, shared: &[usize], node_of_root: &mut [usize]) {
        let topology = self.topology;
        let points: Vec<Point> = topology.corners(polygon).collect();
        let count = points.len();
        for k in 0..count {
            let node = &mut node_of_root[shared[CORNERS * polygon + k]];
            if *node == usize::MAX {
                *node = self.push(points[k]);
            }
            self.corner_nodes[polygon][k] = *node;
            if !self.whole && self.middle_nodes[polygon][k] == usize::MAX {
                let middle = self.push(middle(points[k], points[(k + 1) % count]));
                self.middle_nodes[polygon][k] = middle;
                if let Some((other, m)) = topology.across((polygon, k)) {
                    self.middle_nodes[other][m] = middle;
                }
            }
        }
        let mean = |points: &[Point]| {
            [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64)
        };
        let corners = self.corner_nodes[polygon];
        if self.whole {
            let centre = self.push(mean(&points));
            let [a, b, c, d] = corners;
            self.cells.push([a, b, c, d, centre]);
            return;
        }
        let centroid = self.push(mean(&points));
        let middles = self.middle_nodes[polygon];
        for k in 0..count {
            let quadrilateral = [corners[k], middles[k], centroid, middles[(k + count - 1) % count]];
            let centre = self.push(mean(&quadrilateral.map(|i| self.nodes[i])));
            let [a, b, c, d] = quadrilateral;
            self.cells.push([a, b, c, d, centre]);
        }
    }

    /// The zone of each cell, the last one that holds its centroid; nothing without `outlines`. The outlines are edges of the
    /// mesh, so that no cell lies in two.
    fn zones(&self, outlines: &[Vec<Point>]) -> Result<Vec<Option<usize>>, GeometryError> {
        if outlines.is_empty() {
            return Ok(Vec::new());
        }
        let centre = |cell: &[usize; 5]| self.nodes[cell[4]];
        let zone = |cell: &[usize; 5]| outlines.iter().rposition(|outline| within(outline, centre(cell)));
        let zones: Vec<Option<usize>> = self.cells.iter().map(zone).collect();
        match (0..outlines.len()).find(|zone| !zones.contains(&Some(*zone))) {
            Some(zone) => Err(GeometryError::EmptyZone { zone }),
            None => Ok(zones),
        }
    }

    fn push(&mut self, point: Point) -> usize {
        self.nodes.push(point);
        self.nodes.len() - 1
    }

    /// Nodes along sides that follow one another with the concrete to their left; where they change, both.
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

    /// The nodes of a polygon's side, in the direction that has the polygon to its left.
    fn along(&self, (polygon, k): Side) -> Vec<usize> {
        let corners = self.corner_nodes[polygon];
        let next = corners[(k + 1) % self.topology.indices(polygon).len()];
        if self.whole {
            vec![corners[k], next]
        } else {
            vec![corners[k], self.middle_nodes[polygon][k], next]
        }
    }

    /// The seams of all cracks, and nodes of the ground under cracks along the base.
    fn seams(&mut self) -> Result<Vec<Seam>, GeometryError> {
        let topology = self.topology;
        let ground_body = topology.blocks;
        let mut seams: Vec<Seam> = Vec::new();
        let mut ground_nodes: HashMap<usize, usize> = HashMap::new();
        for (crack, parts) in topology.arrangement.cracks.iter().enumerate() {
            let first_seam = seams.len();
            let mut end = usize::MAX;
            for part in parts {
                let mut chain = topology.tiling.chains[part.edge].clone();
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
                        let point = topology.tiling.points[from];
                        return Err(GeometryError::NotSeparating { crack, point });
                    }
                    let [mut lower, mut upper] = [right, left].map(|side| side.map(|side| self.along(side)));
                    lower.iter_mut().for_each(|nodes| nodes.reverse());
                    let positions = [from, to].map(|i| topology.tiling.points[i]);
                    let mut of_ground = || {
                        let [a, b] = [0, 1].map(|k| {
                            *ground_nodes.entry(pair[k]).or_insert_with(|| {
                                self.nodes.push(positions[k]);
                                self.nodes.len() - 1
                            })
                        });
                        if self.whole {
                            return vec![a, b];
                        }
                        self.nodes.push(middle(positions[0], positions[1]));
                        vec![a, self.nodes.len() - 1, b]
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
                            seams.push(Seam { crack, below, above, lower, upper });
                        }
                    }
                    end = to;
                }
            }
            self.extend_ground(&mut seams[first_seam..]);
        }
        Ok(seams)
    }

    /// Under a crack that covers the whole base the ground continues by the width of the base at heel and toe.
    fn extend_ground(&mut self, seams: &mut [Seam]) {
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
            let node = self.push([-toe[0], 0.0]);
            seam.lower.insert(0, node);
        }
        if let Some(seam) = seams.iter_mut().rev().find(covers) {
            let node = self.push([2.0 * toe[0], 0.0]);
            seam.lower.push(node);
        }
    }
}

/// The same point bit for bit from either side.
fn middle(a: Point, b: Point) -> Point {
    let (a, b) = if by_height(&a, &b).is_le() { (a, b) } else { (b, a) };
    between([a, b], 0.5)
}

#[cfg(test)]
mod tests;
