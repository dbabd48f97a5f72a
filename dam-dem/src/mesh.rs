//! Mesh of a section: quadrilateral cells with four triangles each, in rows where blocks are stacked, from a triangulation otherwise.

mod arrangement;
mod crack_path;
mod geometry_error;
mod given;
mod plane_geometry;
mod quadrilaterals;
mod quality;
mod size;
mod topology;
mod triangulation;

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use crate::block::Block;
use crate::section::{ELEVATION_TOLERANCE, Section};

pub use arrangement::Geometry;
pub(crate) use crack_path::CrackPath;
pub use geometry_error::{Feature, GeometryError};
pub use given::{GivenMesh, GivenMeshError};
pub use quality::Quality;

/// Nodes, cells and blocks.
///
/// A cell has four corners (counter-clockwise from the lower left) and a centre node; its
/// crossed diagonals split it into four triangles:
///
/// ```text
///   3───────2
///   │ ╲ 2 ╱ │      triangle k: corner k, corner k+1, centre
///   │3  4  1│
///   │ ╱ 0 ╲ │
///   0───────1
/// ```
///
/// Nodes on cracks are doubled: blocks share no node. The nodes on the two sides of a crack coincide in the unloaded
/// position. Bodies are the blocks and, after the last one, the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Unloaded positions, m.
    pub nodes: Vec<[f64; 2]>,
    /// Four corners and the centre of each cell.
    pub cells: Vec<[usize; 5]>,
    /// Blocks from the base up.
    pub blocks: Vec<Block>,
    /// The cracks, each in one or more parts.
    pub seams: Vec<Seam>,
    /// Nodes of the upstream side, from the base to the crest; where a crack ends there, one of either side of it.
    pub upstream: Vec<usize>,
    /// The same of the downstream side.
    pub downstream: Vec<usize>,
    /// Nodes of the base that are one with the ground.
    pub base: Vec<usize>,
    /// Nodes of the ground under a joint along the base, which belong to no cell.
    pub ground: Range<usize>,
    /// Zone of each cell, if it lies in one; empty where the whole dam is of one material.
    pub zones: Vec<Option<usize>>,
}

/// Part of a crack between two bodies: two chains of nodes that lie opposite each other.
///
/// Both run downstream; those of a vertical crack upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// Index of the crack.
    pub crack: usize,
    /// The body on its lower side, to the right of its direction.
    pub below: usize,
    /// The body on its upper side.
    pub above: usize,
    /// Nodes of the lower side.
    pub lower: Vec<usize>,
    /// Nodes of the upper side.
    pub upper: Vec<usize>,
}

/// Change of direction, rad, from which a seam ends and another begins.
const KINK: f64 = 0.25;

impl Mesh {
    /// Meshes `section`, cut at the elevations `cracks` (m, ascending). The sides of cells have a length of about
    /// `element_size` (m). There are row boundaries at all vertices, at the cracks, and at `levels` (m, any order).
    ///
    /// Columns: `max(2, area / height / element_size)`, rounded.
    pub fn new(section: &Section, cracks: &[f64], levels: &[f64], element_size: f64) -> Self {
        let height = section.height();
        let columns = ((section.area() / height / element_size).round() as usize).max(2);
        let mut forced: Vec<f64> = cracks.to_vec();
        for level in
            [0.0, height].into_iter().chain(section.vertex_elevations()).chain(levels.iter().copied())
        {
            if forced.iter().all(|y| (y - level).abs() > ELEVATION_TOLERANCE * height) {
                forced.push(level);
            }
        }
        forced.sort_by(f64::total_cmp);
        let mut rows = vec![vec![forced[0]]];
        for pair in forced.windows(2) {
            let count = ((pair[1] - pair[0]) / element_size).round().max(1.0);
            let last = rows.len() - 1;
            rows[last].extend((1..count as usize).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / count));
            rows[last].push(pair[1]);
            if cracks.contains(&pair[1]) {
                rows.push(vec![pair[1]]);
            }
        }
        Self::mapped(section, &rows, columns)
    }

    /// As [`new`](Self::new), with cracks that have the indices from 1 on above a joint along the base, if there is one.
    pub fn layered(
        section: &Section,
        on_joint: bool,
        cracks: &[f64],
        levels: &[f64],
        element_size: f64,
    ) -> Self {
        let mut mesh = Self::new(section, cracks, levels, element_size);
        if on_joint {
            mesh.seams.iter_mut().for_each(|seam| seam.crack += 1);
            mesh = mesh.on_joint(0);
        }
        mesh
    }

    /// Meshes a section that is no stack of blocks.
    ///
    /// **Errors**: [`GeometryError`].
    pub fn of_section(geometry: &Geometry) -> Result<Self, GeometryError> {
        let (mut mesh, _) = quadrilaterals::mesh(geometry)?;
        for seam in std::mem::take(&mut mesh.seams) {
            mesh.add_without_kinks(seam);
        }
        Ok(mesh)
    }

    /// Adds a seam in parts that end at its kinks, so that each side of a corner has its own normal.
    fn add_without_kinks(&mut self, seam: Seam) {
        let place = |node: usize| self.nodes[node];
        let is_kink = |chain: &[usize]| {
            let [a, b, c] = [0, 1, 2].map(|i| place(chain[i]));
            let (first, second) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
            let cross = first[0] * second[1] - first[1] * second[0];
            let dot = first[0] * second[0] + first[1] * second[1];
            cross.atan2(dot).abs() > KINK
        };
        let kinks = seam.upper.windows(3).zip(1..).filter(|(chain, _)| is_kink(chain)).map(|(_, at)| at);
        let kinks: Vec<usize> = kinks.collect();
        let mut rest = seam;
        // from the far end, so that the places of the others stay; the base, where the ground continues beyond the dam, has none
        let mut parts: Vec<Seam> = Vec::new();
        for &at in kinks.iter().rev() {
            let [lower, upper] = [&mut rest.lower, &mut rest.upper].map(|chain| chain.split_off(at));
            rest.lower.push(lower[0]);
            rest.upper.push(upper[0]);
            parts.push(Seam { lower, upper, ..rest });
        }
        parts.push(rest);
        self.seams.extend(parts.into_iter().rev());
    }

    /// Meshes `section` with `columns` columns. `rows` gives the elevations of the row boundaries of each
    /// block (m, ascending; the last one of a block is the first one of the next).
    ///
    /// The number of columns is the same at every height. Crack `i` lies between the blocks `i` and `i + 1`.
    pub fn mapped(section: &Section, rows: &[Vec<f64>], columns: usize) -> Self {
        let mut mesh = Self {
            nodes: Vec::new(),
            cells: Vec::new(),
            blocks: Vec::new(),
            seams: Vec::new(),
            upstream: Vec::new(),
            downstream: Vec::new(),
            base: Vec::new(),
            ground: 0..0,
            zones: Vec::new(),
        };
        let mut top = Vec::new();
        for (block, elevations) in rows.iter().enumerate() {
            let (first_node, first_cell) = (mesh.nodes.len(), mesh.cells.len());
            let mut below = mesh.add_row(section, elevations[0], columns);
            match block.checked_sub(1) {
                Some(crack) => mesh.seams.push(Seam {
                    crack,
                    below: crack,
                    above: block,
                    lower: top,
                    upper: below.clone(),
                }),
                None => mesh.base = below.clone(),
            }
            mesh.upstream.push(below[0]);
            mesh.downstream.push(below[columns]);
            for &elevation in &elevations[1..] {
                let above = mesh.add_row(section, elevation, columns);
                mesh.upstream.push(above[0]);
                mesh.downstream.push(above[columns]);
                for j in 0..columns {
                    let corners = [below[j], below[j + 1], above[j + 1], above[j]];
                    let mean = |d: usize| corners.iter().map(|&i| mesh.nodes[i][d]).sum::<f64>() / 4.0;
                    mesh.nodes.push([mean(0), mean(1)]);
                    let [a, b, c, d] = corners;
                    mesh.cells.push([a, b, c, d, mesh.nodes.len() - 1]);
                }
                below = above;
            }
            mesh.blocks
                .push(Block { nodes: first_node..mesh.nodes.len(), cells: first_cell..mesh.cells.len() });
            top = below;
        }
        mesh.ground = mesh.nodes.len()..mesh.nodes.len();
        mesh
    }

    fn add_row(&mut self, section: &Section, y: f64, columns: usize) -> Vec<usize> {
        let [left, right] = section.sides_at(y);
        let first = self.nodes.len();
        self.nodes.extend((0..=columns).map(|j| [left + (right - left) * j as f64 / columns as f64, y]));
        (first..self.nodes.len()).collect()
    }

    /// The shapes of its elements.
    pub fn quality(&self) -> Quality {
        Quality::of(&self.nodes, &self.cells)
    }

    /// Nodes of the triangles, four for each cell: corner k, corner k + 1, centre.
    pub fn triangles(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        self.cells.iter().flat_map(|cell| (0..4).map(|k| [cell[k], cell[(k + 1) % 4], cell[4]]))
    }

    /// The same dam on a joint: its base is no longer one with the ground, and a seam of `crack` lies between them. The
    /// ground continues beyond heel and toe by the width of the base.
    pub fn on_joint(mut self, crack: usize) -> Self {
        let upper = std::mem::take(&mut self.base);
        let first = self.nodes.len();
        let places: Vec<[f64; 2]> = upper.iter().map(|&node| self.nodes[node]).collect();
        let [heel, toe] = [places[0], places[places.len() - 1]];
        let width = toe[0] - heel[0];
        self.nodes.push([heel[0] - width, heel[1]]);
        self.nodes.extend(places);
        self.nodes.push([toe[0] + width, toe[1]]);
        self.ground = first..self.nodes.len();
        let seam =
            Seam { crack, below: self.blocks.len(), above: 0, lower: self.ground.clone().collect(), upper };
        self.seams.insert(0, seam);
        self
    }

    /// The zone in which `cell` lies.
    pub fn zone_of(&self, cell: usize) -> Option<usize> {
        self.zones.get(cell).copied().flatten()
    }

    /// Whether a body is the ground.
    pub fn is_ground(&self, body: usize) -> bool {
        body == self.blocks.len()
    }

    /// Pairs (lower, upper) of nodes at the same place on the two sides of a crack. Where cracks meet, a node is in several pairs.
    pub fn doubled_nodes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.seams.iter().flat_map(|seam| {
            let twin =
                |upper: usize| seam.lower.iter().find(|&&lower| self.nodes[lower] == self.nodes[upper]);
            seam.upper.iter().filter_map(move |&upper| Some((*twin(upper)?, upper)))
        })
    }

    /// Nodes of the upstream side at or below `level` (m), from the base up, doubled at the cracks below this level.
    pub fn upstream_nodes_to(&self, level: f64) -> Vec<usize> {
        self.nodes_to(level, &self.upstream)
    }

    /// The same of the downstream side.
    pub fn downstream_nodes_to(&self, level: f64) -> Vec<usize> {
        self.nodes_to(level, &self.downstream)
    }

    fn nodes_to(&self, level: f64, side: &[usize]) -> Vec<usize> {
        let crest = side.last().map_or(1.0, |&node| self.nodes[node][1].abs());
        let wet = |node: &&usize| self.nodes[**node][1] <= level + ELEVATION_TOLERANCE * crest;
        let mut nodes: Vec<usize> = side.iter().take_while(wet).copied().collect();
        // the upper side of a crack at the level is dry
        if let [.., below, above] = nodes[..]
            && self.nodes[below] == self.nodes[above]
        {
            nodes.pop();
        }
        nodes
    }

    /// Index of the body to which `node` belongs.
    pub fn block_of(&self, node: usize) -> usize {
        self.blocks.partition_point(|block| block.nodes.end <= node)
    }

    /// Edges of the outline of `block`, galleries included, with the block on their left: from each node to the next one.
    pub fn outline(&self, block: &Block) -> HashMap<usize, usize> {
        let mut edges = HashSet::new();
        for cell in &self.cells[block.cells.clone()] {
            edges.extend((0..4).map(|k| [cell[k], cell[(k + 1) % 4]]));
        }
        let outer = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a]));
        outer.map(|&[a, b]| (a, b)).collect()
    }

    /// Length of a chain of nodes, m.
    pub fn length(&self, chain: &[usize]) -> f64 {
        let ends = chain.windows(2).map(|pair| (self.nodes[pair[0]], self.nodes[pair[1]]));
        ends.map(|([x0, y0], [x1, y1])| (x1 - x0).hypot(y1 - y0)).sum()
    }

    /// Direction from the first to the last node of a chain.
    pub fn direction(&self, chain: &[usize]) -> [f64; 2] {
        let [[x0, y0], [x1, y1]] = [chain[0], chain[chain.len() - 1]].map(|node| self.nodes[node]);
        let length = (x1 - x0).hypot(y1 - y0);
        [(x1 - x0) / length, (y1 - y0) / length]
    }

    /// Tributary lengths of a chain of nodes, m: half of each adjacent segment.
    pub fn tributary_lengths(&self, chain: &[usize]) -> Vec<f64> {
        let mut lengths = vec![0.0; chain.len()];
        for (i, pair) in chain.windows(2).enumerate() {
            let ([x0, y0], [x1, y1]) = (self.nodes[pair[0]], self.nodes[pair[1]]);
            let half = (x1 - x0).hypot(y1 - y0) / 2.0;
            lengths[i] += half;
            lengths[i + 1] += half;
        }
        lengths
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_end_at_vertices_cracks_and_water() {
        let section = Section::default();
        let mesh = Mesh::new(&section, &[40.0, 66.5], &[91.75], 5.0);
        assert_eq!(mesh.blocks.len(), 3);
        assert_eq!(mesh.cells.len() % 7, 0);
        for (lower, upper) in mesh.doubled_nodes() {
            assert_eq!(mesh.nodes[lower], mesh.nodes[upper]);
        }
        let wet = mesh.upstream_nodes_to(91.75);
        assert_eq!(mesh.nodes[wet[wet.len() - 1]], [0.0, 91.75]);
        assert_eq!(wet.windows(2).filter(|p| mesh.nodes[p[0]] == mesh.nodes[p[1]]).count(), 2);
        assert_eq!(mesh.block_of(mesh.blocks[1].nodes.start), 1);
        let level_with_crack = mesh.upstream_nodes_to(66.5);
        assert_eq!(level_with_crack.last(), mesh.seams[1].lower.first());
    }
}
