use super::lanes::{LANES, Lanes};
use crate::Mesh;

/// Up to [`LANES`] cells that are evaluated together; in lanes without a cell, areas and gradients are 0.
#[derive(Clone, Debug, Default)]
pub(super) struct Batch {
    /// Four corners and the centre of each cell.
    pub cells: Vec<[usize; 5]>,
    /// ∇N of corner k and of corner k + 1 in triangle k, 1/m.
    pub gradients: [[[Lanes; 2]; 2]; 4],
    /// Areas of the triangles, m².
    pub areas: [Lanes; 4],
}

/// A nodal field at corners and centre of the cells.
pub(super) type Nodal = [[Lanes; 2]; 5];

/// Stresses of stiffness damping in the four triangles of a batch of cells: 11, 22, 12 components, Pa.
pub type ViscousStress = [[Lanes; 3]; 4];

impl Batch {
    pub fn new(mesh: &Mesh, cells: &[[usize; 5]]) -> Self {
        let mut batch = Self { cells: cells.to_vec(), ..Self::default() };
        for (lane, nodes) in cells.iter().enumerate() {
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

    /// ∇N of corner k and of corner k + 1 in triangle k of a cell, 1/m.
    #[inline(always)]
    pub fn gradients_of(&self, k: usize, lane: usize) -> [[f64; 2]; 2] {
        let [a, b] = &self.gradients[k];
        [[a[0][lane], a[1][lane]], [b[0][lane], b[1][lane]]]
    }

    #[inline(always)]
    pub fn gather(&self, field: &[[f64; 2]], gathered: &mut Nodal) {
        for (lane, nodes) in self.cells.iter().enumerate().take(LANES) {
            for (to, &node) in gathered.iter_mut().zip(nodes) {
                let [x, y] = field[node];
                to[0][lane] = x;
                to[1][lane] = y;
            }
        }
    }

    /// Adds the values at corners and centres to `field`, whose first entry belongs to `first_node`.
    #[inline(always)]
    pub fn scatter(&self, values: &Nodal, first_node: usize, field: &mut [[f64; 2]]) {
        for (lane, nodes) in self.cells.iter().enumerate().take(LANES) {
            for (from, &node) in values.iter().zip(nodes) {
                let to = &mut field[node - first_node];
                to[0] += from[0][lane];
                to[1] += from[1][lane];
            }
        }
    }
}
