use super::{double_layer, single_layer};
use crate::boundary::BoundaryMesh;
use crate::kernel::Source;
use crate::quadrature::element_rule;
use num_complex::Complex64;

/// Relative difference below which two distances are the same.
const SAME: f64 = 1e-12;

/// One quadrature point of one source: weights of the element's nodes in both layers.
#[derive(Clone, Copy, Debug)]
struct Entry {
    distance: u32,
    single: [f64; 2],
    double: [f64; 2],
}

/// Quadrature points of every element seen from every collocation point.
pub(super) struct Geometry {
    /// Distances from source to quadrature point, m.
    radii: Vec<f64>,
    entries: Vec<Entry>,
    /// First entry of every (point, element), points outermost, and the number of entries.
    starts: Vec<u32>,
    elements: usize,
    nodes_per_element: usize,
}

impl Geometry {
    /// The geometry of `mesh` for collocation points with the given sources.
    pub fn new(mesh: &BoundaryMesh, sources: &[Vec<Source>]) -> Self {
        let order = mesh.order();
        let (mut radii, mut entries, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        let mut rule = Vec::new();
        for sources in sources {
            for element in mesh.elements() {
                let (normal, half) = (element.normal(), 0.5 * element.length());
                for &Source { point, strength } in sources {
                    element_rule(element.start, element.end, point, &mut rule);
                    for q in &rule {
                        let y = element.at(q.position);
                        let r = [y[0] - point[0], y[1] - point[1]];
                        let (weight, shape) = (q.weight * half * strength, order.shape(q.position));
                        let (single, double) =
                            (single_layer::weight(), double_layer::weight(r, normal, half));
                        entries.push(Entry {
                            distance: radii.len() as u32,
                            single: shape.map(|n| weight * n * single),
                            double: shape.map(|n| weight * n * double),
                        });
                        radii.push(r[0].hypot(r[1]));
                    }
                }
                starts.push(entries.len() as u32);
            }
        }
        Self {
            radii,
            entries,
            starts,
            elements: mesh.elements().len(),
            nodes_per_element: order.nodes().len(),
        }
    }

    /// The same geometry with equal distances stored once, if many are equal, as on rectangles; otherwise in the order
    /// of use, which suits the processor's caches.
    pub fn merged(mut self) -> Self {
        let mut order: Vec<u32> = (0..self.radii.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| self.radii[a as usize].total_cmp(&self.radii[b as usize]));
        let mut merged: Vec<f64> = Vec::new();
        let mut indices = vec![0; self.radii.len()];
        for index in order {
            let r = self.radii[index as usize];
            if merged.last().is_none_or(|last| r > last * (1.0 + SAME)) {
                merged.push(r);
            }
            indices[index as usize] = (merged.len() - 1) as u32;
        }
        if 2 * merged.len() <= self.radii.len() {
            self.entries.iter_mut().zip(indices).for_each(|(entry, index)| entry.distance = index);
            self.radii = merged;
        }
        self
    }

    /// The distances, m.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// Number of distances.
    pub fn distances(&self) -> usize {
        self.radii.len()
    }

    /// Calls `entry` with row, column, single and double layer for every pair of point and node, given
    /// `[K₀(kr), k K₁(kr)]` at the distances.
    pub fn for_each(
        &self,
        values: &[[Complex64; 2]],
        mut entry: impl FnMut(usize, usize, Complex64, Complex64),
    ) {
        for (block, range) in self.starts.windows(2).enumerate() {
            let (row, element) = (block / self.elements, block % self.elements);
            let mut single = [Complex64::ZERO; 2];
            let mut double = [Complex64::ZERO; 2];
            for entry in &self.entries[range[0] as usize..range[1] as usize] {
                let [k0, k1] = values[entry.distance as usize];
                for node in 0..2 {
                    single[node] += k0 * entry.single[node];
                    double[node] += k1 * entry.double[node];
                }
            }
            for node in 0..self.nodes_per_element {
                entry(row, self.nodes_per_element * element + node, single[node], double[node]);
            }
        }
    }
}
