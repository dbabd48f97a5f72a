//! Stresses at nodes, recovered from those of the cells around them.

use nalgebra::DMatrix;
use std::collections::BTreeMap;

use crate::element::CrossedCells;
use crate::{Block, Kinematics, Mesh};

/// Stresses at the corners of the cells, recovered from the mean stresses of the cells.
///
/// The mean displacement gradient of a cell follows from its edges alone,
///
/// ```text
/// ∫ ∇u dA = ∮ u ⊗ n ds,   mean ∇N_k = (y_{k+1} − y_{k−1}, x_{k−1} − x_{k+1}) / 2A
/// ```
///
/// where the errors of opposite edges cancel. So the mean is the stress at the cell's centroid with an error of second
/// order, while that of each triangle has an error of first order. In every block, a linear field is fitted to the
/// cells around an inner corner by least squares (superconvergent patch recovery) and taken at this corner. A corner on
/// the outline belongs to the patch of the next inner one. Patches end at cracks, where the mesh does, and at the outlines of zones of another
/// material, where stresses jump: a corner there has stresses in each of the zones. A linear stress
/// on cells that are parallelograms is reproduced exactly; a smooth one at second order, on the outline too. In
/// corners where the stress of an elastic body is unbounded, the result grows as the mesh is refined.
///
/// **Source**: O.C. Zienkiewicz, J.Z. Zhu, *The superconvergent patch recovery and a posteriori error estimates. Part 1*,
/// Int. J. Numer. Methods Eng. 33, 1992, 1331–1364. Tested in `tests/stress.rs`.
#[derive(Clone, Debug)]
pub struct StressRecovery {
    /// Corners of each cell, and the mean over the cell of their ∇N, 1/m.
    cells: Vec<([usize; 4], [[f64; 2]; 4])>,
    nodes: Vec<usize>,
    /// Zone of each of `nodes`.
    zones: Vec<Option<usize>>,
    /// Places in `nodes` of those on the outline of a block, or of a zone in it.
    outline: Vec<usize>,
    /// The cells of the patch of each of `nodes`, and their weights.
    patches: Vec<Vec<(usize, f64)>>,
}

impl StressRecovery {
    /// The recovery on `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let (mut nodes, mut zones) = (Vec::new(), Vec::new());
        let (mut outline, mut patches) = (Vec::new(), Vec::new());
        for (zone, cells) in mesh.blocks.iter().flat_map(|block| of_one_zone(mesh, block)) {
            let corners = Corners::of(mesh, &cells);
            for (&node, corner) in &corners.0 {
                let patch = corners.patch(mesh, node);
                let centroids: Vec<[f64; 2]> = patch.iter().map(|&cell| centroid(mesh, cell)).collect();
                let weights = weights_of_linear_fit(&centroids, mesh.nodes[node]);
                if !corner.is_inner() {
                    outline.push(nodes.len());
                }
                nodes.push(node);
                zones.push(zone);
                patches.push(patch.into_iter().zip(weights).collect());
            }
        }
        let cells =
            mesh.cells.iter().map(|&[a, b, c, d, _]| ([a, b, c, d], mean_gradients(mesh, [a, b, c, d])));
        Self { cells: cells.collect(), nodes, zones, outline, patches }
    }

    /// The nodes at which stresses are recovered: the corners of all cells, block after block, within a block zone after zone, so
    /// that a node between zones is there once for each of them.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The zone to which the stresses at each of [`nodes`](Self::nodes) belong; `None` in the general material.
    pub fn zones(&self) -> &[Option<usize>] {
        &self.zones
    }

    /// Places in [`nodes`](Self::nodes) of those on the outline of a block (faces, base, crest and sides of cracks)
    /// or of a zone.
    pub fn outline(&self) -> &[usize] {
        &self.outline
    }

    /// Stresses (xx, yy, xy; tension positive, Pa) at [`nodes`](Self::nodes), for the `displacement` (m) of all nodes of
    /// the mesh, of which those in the centres of cells do not matter.
    ///
    /// The four triangles of a cell turn with its mean rotation, an error of the order of the strain.
    pub fn stresses(
        &self,
        elements: &CrossedCells,
        displacement: &[[f64; 2]],
        kinematics: Kinematics,
    ) -> Vec<[f64; 3]> {
        let of_cell = |(cell, (corners, gradients)): (usize, &([usize; 4], [[f64; 2]; 4]))| {
            let mut h = [[0.0; 2]; 2];
            for (&node, gradient) in corners.iter().zip(gradients) {
                let u = displacement[node];
                (0..2).for_each(|i| (0..2).for_each(|j| h[i][j] += u[i] * gradient[j]));
            }
            elements.stress_of(cell, h, kinematics)
        };
        let of_cells: Vec<[f64; 3]> = self.cells.iter().enumerate().map(of_cell).collect();
        let at_node = |patch: &Vec<(usize, f64)>| {
            let mut sum = [0.0; 3];
            for &(cell, weight) in patch {
                (0..3).for_each(|i| sum[i] += weight * of_cells[cell][i]);
            }
            sum
        };
        self.patches.iter().map(at_node).collect()
    }
}

/// The cells of a block that are of the same zone: those of no zone first.
fn of_one_zone(mesh: &Mesh, block: &Block) -> BTreeMap<Option<usize>, Vec<usize>> {
    let mut of_zones: BTreeMap<Option<usize>, Vec<usize>> = BTreeMap::new();
    block.cells.clone().for_each(|cell| of_zones.entry(mesh.zone_of(cell)).or_default().push(cell));
    of_zones
}

/// The corners of cells.
struct Corners(BTreeMap<usize, Corner>);

/// A corner of cells.
#[derive(Default)]
struct Corner {
    /// The cells around it, ascending.
    cells: Vec<usize>,
    /// The corners to which an edge leads from it, one for each of its cells that has this edge.
    neighbours: Vec<usize>,
}

impl Corner {
    /// Whether cells are all around it: each of its edges belongs to two of them.
    fn is_inner(&self) -> bool {
        let mut sorted = self.neighbours.clone();
        sorted.sort_unstable();
        sorted.chunk_by(|a, b| a == b).all(|edge| edge.len() == 2)
    }
}

impl Corners {
    fn of(mesh: &Mesh, cells: &[usize]) -> Self {
        let mut corners: BTreeMap<usize, Corner> = BTreeMap::new();
        for &cell in cells {
            for k in 0..4 {
                let corner = corners.entry(mesh.cells[cell][k]).or_default();
                corner.cells.push(cell);
                corner.neighbours.extend([1, 3].map(|step| mesh.cells[cell][(k + step) % 4]));
            }
        }
        Self(corners)
    }

    /// The cells to which a linear field is fitted at `node`: those around it, or around the next inner corner, along an edge if
    /// there is one, otherwise within a cell. If there is no inner corner, those around it and its neighbours.
    fn patch(&self, mesh: &Mesh, node: usize) -> Vec<usize> {
        let corner = &self.0[&node];
        let next_inner = |candidates: &mut dyn Iterator<Item = usize>| {
            let distance = |other: &usize| {
                let [[x, y], [p, q]] = [node, *other].map(|node| mesh.nodes[node]);
                (p - x).hypot(q - y)
            };
            let inner = candidates.filter(|other| self.0[other].is_inner());
            inner.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let centre = match corner.is_inner() {
            true => Some(node),
            false => next_inner(&mut corner.neighbours.iter().copied()).or_else(|| {
                let of_cells = corner.cells.iter().flat_map(|&cell| &mesh.cells[cell][..4]);
                next_inner(&mut of_cells.copied())
            }),
        };
        if let Some(centre) = centre {
            return self.0[&centre].cells.clone();
        }
        let around = corner.neighbours.iter().flat_map(|other| &self.0[other].cells);
        let mut cells: Vec<usize> = corner.cells.iter().chain(around).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// Mean of ∇N of each corner over a cell, 1/m.
fn mean_gradients(mesh: &Mesh, corners: [usize; 4]) -> [[f64; 2]; 4] {
    let x = corners.map(|node| mesh.nodes[node]);
    let cross = |k: usize| x[k][0] * x[(k + 1) % 4][1] - x[(k + 1) % 4][0] * x[k][1];
    let twice_area: f64 = (0..4).map(cross).sum();
    [0, 1, 2, 3].map(|k| {
        let (next, last) = (x[(k + 1) % 4], x[(k + 3) % 4]);
        [(next[1] - last[1]) / twice_area, (last[0] - next[0]) / twice_area]
    })
}

fn centroid(mesh: &Mesh, cell: usize) -> [f64; 2] {
    let at = mesh.cells[cell].map(|node| mesh.nodes[node]);
    let (mut sum, mut whole) = ([0.0; 2], 0.0);
    for k in 0..4 {
        let (p, q, c) = (at[k], at[(k + 1) % 4], at[4]);
        let twice = (p[0] - c[0]) * (q[1] - c[1]) - (q[0] - c[0]) * (p[1] - c[1]);
        (0..2).for_each(|d| sum[d] += twice * (p[d] + q[d] + c[d]) / 3.0);
        whole += twice;
    }
    sum.map(|sum| sum / whole)
}

/// Weights that give, at `place`, the linear function that is nearest to values at `points`. Where the points lie on a
/// line, it is constant across it.
fn weights_of_linear_fit(points: &[[f64; 2]], place: [f64; 2]) -> Vec<f64> {
    let mean = [0, 1].map(|d| points.iter().map(|point| point[d]).sum::<f64>() / points.len() as f64);
    let from_mean = |[x, y]: [f64; 2]| [x - mean[0], y - mean[1]];
    let extent =
        points.iter().map(|&point| from_mean(point)).fold(0.0, |far: f64, [x, y]| far.max(x.hypot(y)));
    let scale = if extent > 0.0 { extent } else { 1.0 };
    let basis = |point: [f64; 2]| {
        let [x, y] = from_mean(point);
        [1.0, x / scale, y / scale]
    };
    let fit = DMatrix::from_fn(points.len(), 3, |i, k| basis(points[i])[k]);
    let inverse = fit.pseudo_inverse(ON_A_LINE).unwrap_or_else(|_| DMatrix::zeros(3, points.len()));
    let there = basis(place);
    (0..points.len()).map(|i| (0..3).map(|k| there[k] * inverse[(k, i)]).sum()).collect()
}

/// Width over length of a row of points that counts as a line.
const ON_A_LINE: f64 = 1e-6;

/// Larger and smaller principal stress of (xx, yy, xy), Pa.
#[inline(always)]
pub(crate) fn principal([xx, yy, xy]: [f64; 3]) -> [f64; 2] {
    let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    let radius = (half * half + xy * xy).sqrt();
    [mean + radius, mean - radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stresses_are_those_of_a_turned_state() {
        let (s, c) = 0.7f64.sin_cos();
        let (major, minor) = (3.0, -5.0);
        let turned = [c * c * major + s * s * minor, s * s * major + c * c * minor, s * c * (major - minor)];
        let found = principal(turned);
        assert!((found[0] - major).abs() < 1e-14 && (found[1] - minor).abs() < 1e-14, "{found:?}");
    }
}
