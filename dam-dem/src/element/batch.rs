use pulp::Simd;

use crate::Mesh;
use crate::lanes::{LANES, Lanes};

/// Up to [`LANES`] consecutive cells that are evaluated together; in lanes without a cell, areas and gradients are 0.
#[derive(Clone, Debug, Default)]
pub(super) struct Batch {
    /// Index of the first cell.
    pub first_cell: usize,
    /// Four corners and the centre of each cell.
    pub cells: Vec<[usize; 5]>,
    /// ∇N of corner k and of corner k + 1 in triangle k, 1/m.
    pub gradients: [[[Lanes; 2]; 2]; 4],
    /// Areas of the triangles, m².
    pub areas: [Lanes; 4],
    /// -1 in lanes with a cell, 0 in others.
    pub used: Lanes,
    row: Option<Row>,
}

/// First nodes of cells that lie in one row of the mesh; those of the next cells follow, and each right corner is the next
/// one's left corner.
#[derive(Clone, Copy, Debug)]
struct Row {
    lower: usize,
    upper: usize,
    centre: usize,
}

/// A nodal field at corners and centre of the cells: pairs as in the field, or one component after the other.
pub(super) type Pairs = [[[f64; 2]; LANES]; 5];
pub(super) type Nodal = [[Lanes; 2]; 5];

/// A nodal field at the corners of the cells.
pub(super) type Corners = [[Lanes; 2]; 4];

/// Stresses of stiffness damping in the four triangles of a batch of cells: 11, 22, 12 components, Pa.
pub type ViscousStress = [[Lanes; 3]; 4];

/// Number of cells from which those that are left of a row are a batch of their own. Whole registers of nodes are then
/// worth the lanes without a cell.
const NEARLY_FULL: usize = 6;

impl Batch {
    /// The cells of `mesh` in their order.
    pub fn of(mesh: &Mesh) -> Vec<Self> {
        let (mut batches, mut first_cell) = (Vec::new(), 0);
        while let [first, ..] = mesh.cells[first_cell..] {
            let rest = &mesh.cells[first_cell..];
            let in_row =
                (0..LANES.min(rest.len())).take_while(|&lane| rest[lane] == first.map(|n| n + lane)).count();
            let count = if in_row < NEARLY_FULL { LANES.min(rest.len()) } else { in_row };
            batches.push(Self::new(mesh, first_cell, &rest[..count]));
            first_cell += count;
        }
        batches
    }

    fn new(mesh: &Mesh, first_cell: usize, cells: &[[usize; 5]]) -> Self {
        let row = Row::of(cells, mesh.nodes.len());
        let mut batch = Self { first_cell, cells: cells.to_vec(), row, ..Self::default() };
        for (lane, nodes) in cells.iter().enumerate() {
            batch.used[lane] = -1.0;
            let [xc, yc] = mesh.nodes[nodes[4]];
            for k in 0..4 {
                let ([x1, y1], [x2, y2]) = (mesh.nodes[nodes[k]], mesh.nodes[nodes[(k + 1) % 4]]);
                let twice = (x1 - xc) * (y2 - yc) - (x2 - xc) * (y1 - yc);
                batch.areas[k][lane] = twice / 2.0;
                let gradients = [[y2 - yc, xc - x2], [yc - y1, x1 - xc]];
                for (to, from) in batch.gradients[k].iter_mut().zip(gradients) {
                    to[0][lane] = from[0] / twice;
                    to[1][lane] = from[1] / twice;
                }
            }
        }
        batch
    }

    /// Batch and lane of a `cell`.
    pub fn place_of(batches: &[Self], cell: usize) -> (usize, usize) {
        let batch = batches.partition_point(|batch| batch.first_cell <= cell) - 1;
        (batch, cell - batches[batch].first_cell)
    }

    /// ∇N of corner k and of corner k + 1 in triangle k of a cell, 1/m.
    #[inline(always)]
    pub fn gradients_of(&self, k: usize, lane: usize) -> [[f64; 2]; 2] {
        let [a, b] = &self.gradients[k];
        [[a[0][lane], a[1][lane]], [b[0][lane], b[1][lane]]]
    }

    #[cfg(test)]
    pub fn is_row(&self) -> bool {
        self.row.is_some()
    }

    /// Copies the nodes of cells that are no row.
    #[inline(always)]
    pub fn gather(&self, field: &[[f64; 2]], gathered: &mut Pairs) {
        if self.row.is_none() {
            for (lane, nodes) in self.cells.iter().enumerate().take(LANES) {
                for (to, &node) in gathered.iter_mut().zip(nodes) {
                    to[lane] = field[node];
                }
            }
        }
    }

    /// The field at the corners, relative to the centres. `gathered` is that of [`gather`](Self::gather); the nodes of a row
    /// are read where they are, in lanes without a cell those that follow.
    #[inline(always)]
    pub fn relative_to_centre<S: Simd>(&self, simd: S, field: &[[f64; 2]], gathered: &Pairs) -> Corners {
        let mut nodes = gathered.each_ref();
        if let Some(Row { lower, upper, centre }) = self.row {
            for (nodes, first) in nodes.iter_mut().zip([lower, lower + 1, upper + 1, upper, centre]) {
                if let Some(of_row) = field[first..].first_chunk() {
                    *nodes = of_row;
                }
            }
        }
        let mut relative = Corners::default();
        for (to, corner) in relative.iter_mut().zip(nodes) {
            // differences first: the compiler would read numbers that it is to sort one by one
            let apart = difference(simd, corner, nodes[4]);
            for lane in 0..LANES {
                to[0][lane] = apart[lane][0];
                to[1][lane] = apart[lane][1];
            }
        }
        relative
    }

    /// Adds the values at corners and centres, 0 in lanes without a cell, to `field`, whose first entry belongs to
    /// `first_node`.
    #[inline(always)]
    pub fn scatter(&self, values: &Nodal, first_node: usize, field: &mut [[f64; 2]]) {
        if let Some(row) = self.row.filter(|row| row.last_node() < first_node + field.len()) {
            let [bottom_left, bottom_right, top_right, top_left, centre] = values;
            add_side(bottom_left, bottom_right, &mut field[row.lower - first_node..]);
            add_side(top_left, top_right, &mut field[row.upper - first_node..]);
            add(centre, &mut field[row.centre - first_node..]);
            return;
        }
        for (lane, nodes) in self.cells.iter().enumerate().take(LANES) {
            for (from, &node) in values.iter().zip(nodes) {
                let to = &mut field[node - first_node];
                to[0] += from[0][lane];
                to[1] += from[1][lane];
            }
        }
    }
}

impl Row {
    /// That of `cells` if they are one, and if there are nodes for all lanes.
    fn of(cells: &[[usize; 5]], node_count: usize) -> Option<Self> {
        let [lower, lower_right, upper_right, upper, centre] = *cells.first()?;
        let row = Self { lower, upper, centre };
        let follow = cells.iter().enumerate().all(|(lane, cell)| *cell == cells[0].map(|node| node + lane));
        (follow && [lower_right, upper_right] == [lower + 1, upper + 1] && row.last_node() < node_count)
            .then_some(row)
    }

    /// The last node that is read and written, for whole registers.
    #[inline(always)]
    fn last_node(&self) -> usize {
        (self.lower.max(self.upper) + LANES).max(self.centre + LANES - 1)
    }
}

#[inline(always)]
fn difference<S: Simd>(simd: S, a: &[[f64; 2]; LANES], b: &[[f64; 2]; LANES]) -> [[f64; 2]; LANES] {
    let mut difference = [[0.0; 2]; LANES];
    let (to, _) = S::as_mut_simd_f64s(difference.as_flattened_mut());
    let [(a, _), (b, _)] = [S::as_simd_f64s(a.as_flattened()), S::as_simd_f64s(b.as_flattened())];
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = simd.sub_f64s(*a, *b);
    }
    difference
}

/// Adds to the first nodes of `field`.
#[inline(always)]
fn add(values: &[Lanes; 2], field: &mut [[f64; 2]]) {
    if let Some(nodes) = field.first_chunk_mut::<LANES>() {
        for lane in 0..LANES {
            nodes[lane][0] += values[0][lane];
            nodes[lane][1] += values[1][lane];
        }
    }
}

/// The same for the left and right corners on one side of the cells. They are summed first, so that no node is written
/// and read again at once.
#[inline(always)]
fn add_side(left: &[Lanes; 2], right: &[Lanes; 2], field: &mut [[f64; 2]]) {
    let mut sum = *left;
    for d in 0..2 {
        for lane in 1..LANES {
            sum[d][lane] += right[d][lane - 1];
        }
    }
    add(&sum, field);
    for d in 0..2 {
        field[LANES][d] += right[d][LANES - 1];
    }
}
