//! Mapped mesh of a section: rows of quadrilateral cells with four triangles each.

#[allow(dead_code)]
mod arrangement;
#[allow(dead_code)]
mod geometry_error;
#[allow(dead_code)]
mod plane_geometry;
#[allow(dead_code)]
mod quadrilaterals;
#[allow(dead_code)]
mod quality;
#[allow(dead_code)]
mod size;
#[allow(dead_code)]
mod triangulation;

use crate::block::Block;
use crate::section::{ELEVATION_TOLERANCE, Section};

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
/// The number of columns is the same at every height, so that the nodes on the two sides of a crack coincide in the
/// unloaded position; nodes on cracks are doubled.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Unloaded positions, m.
    pub nodes: Vec<[f64; 2]>,
    /// Four corners and the centre of each cell.
    pub cells: Vec<[usize; 5]>,
    /// Blocks from the base up; crack `i` lies between block `i` and `i + 1`.
    pub blocks: Vec<Block>,
}

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

    /// Meshes `section` with `columns` columns. `rows` gives the elevations of the row boundaries of each
    /// block (m, ascending; the last one of a block is the first one of the next).
    pub fn mapped(section: &Section, rows: &[Vec<f64>], columns: usize) -> Self {
        let mut mesh = Self { nodes: Vec::new(), cells: Vec::new(), blocks: Vec::new() };
        for elevations in rows {
            let (first_node, first_cell) = (mesh.nodes.len(), mesh.cells.len());
            let mut below = mesh.add_row(section, elevations[0], columns);
            let (bottom, mut upstream, mut downstream) =
                (below.clone(), vec![below[0]], vec![below[columns]]);
            for &elevation in &elevations[1..] {
                let above = mesh.add_row(section, elevation, columns);
                upstream.push(above[0]);
                downstream.push(above[columns]);
                for j in 0..columns {
                    let corners = [below[j], below[j + 1], above[j + 1], above[j]];
                    let mean = |d: usize| corners.iter().map(|&i| mesh.nodes[i][d]).sum::<f64>() / 4.0;
                    mesh.nodes.push([mean(0), mean(1)]);
                    let [a, b, c, d] = corners;
                    mesh.cells.push([a, b, c, d, mesh.nodes.len() - 1]);
                }
                below = above;
            }
            mesh.blocks.push(Block {
                nodes: first_node..mesh.nodes.len(),
                cells: first_cell..mesh.cells.len(),
                bottom,
                top: below,
                upstream,
                downstream,
            });
        }
        mesh
    }

    fn add_row(&mut self, section: &Section, y: f64, columns: usize) -> Vec<usize> {
        let [left, right] = section.sides_at(y);
        let first = self.nodes.len();
        self.nodes.extend((0..=columns).map(|j| [left + (right - left) * j as f64 / columns as f64, y]));
        (first..self.nodes.len()).collect()
    }

    /// Nodes of the triangles, four for each cell: corner k, corner k + 1, centre.
    pub fn triangles(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        self.cells.iter().flat_map(|cell| (0..4).map(|k| [cell[k], cell[(k + 1) % 4], cell[4]]))
    }

    /// Pairs (lower, upper) of doubled nodes, for all cracks.
    pub fn doubled_nodes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.blocks
            .windows(2)
            .flat_map(|pair| pair[0].top.iter().copied().zip(pair[1].bottom.iter().copied()))
    }

    /// Nodes of the upstream side at or below `level` (m), from the base up, doubled at the cracks below this level.
    pub fn upstream_nodes_to(&self, level: f64) -> Vec<usize> {
        self.nodes_to(level, |block| &block.upstream)
    }

    /// The same of the downstream side.
    pub fn downstream_nodes_to(&self, level: f64) -> Vec<usize> {
        self.nodes_to(level, |block| &block.downstream)
    }

    fn nodes_to(&self, level: f64, side: impl Fn(&Block) -> &[usize]) -> Vec<usize> {
        let tolerance = ELEVATION_TOLERANCE * self.nodes.last().map_or(1.0, |p| p[1].abs());
        let mut nodes = Vec::new();
        for block in &self.blocks {
            let wet = |&&i: &&usize| self.nodes[i][1] <= level + tolerance;
            let part: Vec<usize> = side(block).iter().take_while(wet).copied().collect();
            if nodes.is_empty() || part.len() > 1 {
                nodes.extend(part);
            }
        }
        nodes
    }

    /// Index of the block that contains `node`.
    pub fn block_of(&self, node: usize) -> usize {
        self.blocks.partition_point(|block| block.nodes.end <= node)
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
        let section = Section {
            upstream: vec![[0.0, 0.0], [0.0, 103.0]],
            downstream: vec![[70.0, 0.0], [19.25, 66.5], [14.8, 103.0]],
        };
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
        assert_eq!(level_with_crack.last(), mesh.blocks[1].upstream.last());
    }
}
