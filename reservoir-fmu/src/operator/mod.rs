//! Single and double layer of every element at every collocation point.
//!
//! Depends on `boundary`, `kernel` and `quadrature`. The geometry (distances, quadrature
//! weights, shape functions) does not depend on the frequency and is computed once; equal
//! distances, of which straight boundaries have many, are stored and evaluated once.

mod double_layer;
mod single_layer;

use crate::boundary::{BoundaryMesh, shape};
use crate::kernel::{Distance, HelmholtzKernel, Ray, Source};
use crate::quadrature::element_rule;
use faer::Mat;
use num_complex::Complex64;
use std::ops::Range;

/// Relative difference below which two distances are the same.
const SAME: f64 = 1e-12;

/// One quadrature point of one source: weights of its two nodes in either layer.
#[derive(Clone, Copy, Debug)]
struct Entry {
    distance: u32,
    single: [f64; 2],
    double: [f64; 2],
}

/// Geometry of both layers at fixed collocation points.
pub(crate) struct LayerOperators {
    distances: Vec<Distance>,
    entries: Vec<Entry>,
    /// Range of entries of every (point, element), points outermost.
    ranges: Vec<Range<usize>>,
    points: usize,
    elements: usize,
}

/// Matrices of both layers at one frequency, rows: collocation points, columns: nodes.
pub(crate) struct Layers {
    /// `S_ij = ∫ G(x_i, y) N_j(y) ds`, m.
    pub single: Mat<Complex64>,
    /// `D_ij = ∫ ∂G/∂n_y(x_i, y) N_j(y) ds`, without the free term.
    pub double: Mat<Complex64>,
}

impl LayerOperators {
    /// Prepares both layers of `mesh` at `points` (m), which may lie on elements.
    pub fn new(mesh: &BoundaryMesh, kernel: &dyn HelmholtzKernel, points: &[[f64; 2]]) -> Self {
        let (mut lengths, mut entries, mut ranges) = (Vec::new(), Vec::new(), Vec::new());
        for &point in points {
            let sources = kernel.sources(point);
            for element in mesh.elements() {
                let first = entries.len();
                let (normal, half) = (element.normal(), 0.5 * element.length());
                for &Source { point, strength } in &sources {
                    for q in element_rule(element.start, element.end, point) {
                        let y = element.at(q.position);
                        let r = [y[0] - point[0], y[1] - point[1]];
                        let (weight, shape) = (q.weight * half * strength, shape(q.position));
                        let (single, double) =
                            (single_layer::weight(), double_layer::weight(r, normal, half));
                        entries.push(Entry {
                            distance: 0,
                            single: shape.map(|n| weight * n * single),
                            double: shape.map(|n| weight * n * double),
                        });
                        lengths.push(r[0].hypot(r[1]));
                    }
                }
                ranges.push(first..entries.len());
            }
        }
        let distances = merge_equal(&lengths, &mut entries);
        Self { distances, entries, ranges, points: points.len(), elements: mesh.elements().len() }
    }

    /// Both layers at `wavenumber` k = s/c (1/m, positive real part).
    pub fn assemble(&self, wavenumber: Complex64) -> Result<Layers, complex_bessel::Error> {
        let farthest = self.distances.last().map_or(1.0, |d| d.r);
        let ray = Ray::new(wavenumber, farthest)?;
        Ok(self.layers(|distance| ray.evaluate(distance)))
    }

    /// Both layers of Laplace's equation, k = 0, for a kernel whose strengths sum to zero.
    pub fn assemble_static(&self) -> Layers {
        self.layers(|distance| distance.static_limit().map(Complex64::from))
    }

    /// Both layers from `[K₀(kr), k K₁(kr)]` at every distance.
    fn layers(&self, kernels: impl Fn(&Distance) -> [Complex64; 2]) -> Layers {
        let values: Vec<_> = self.distances.iter().map(kernels).collect();
        let (rows, columns) = (self.points, 2 * self.elements);
        let mut layers = Layers { single: Mat::zeros(rows, columns), double: Mat::zeros(rows, columns) };
        for (block, range) in self.ranges.iter().enumerate() {
            let (row, element) = (block / self.elements, block % self.elements);
            let mut single = [Complex64::ZERO; 2];
            let mut double = [Complex64::ZERO; 2];
            for entry in &self.entries[range.clone()] {
                let [k0, k1] = values[entry.distance as usize];
                for node in 0..2 {
                    single[node] += k0 * entry.single[node];
                    double[node] += k1 * entry.double[node];
                }
            }
            for node in 0..2 {
                layers.single[(row, 2 * element + node)] = single[node];
                layers.double[(row, 2 * element + node)] = double[node];
            }
        }
        layers
    }
}

/// Sorts `lengths`, keeps one of each, and points the entries at them.
fn merge_equal(lengths: &[f64], entries: &mut [Entry]) -> Vec<Distance> {
    let mut order: Vec<usize> = (0..lengths.len()).collect();
    order.sort_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
    let mut distances: Vec<Distance> = Vec::new();
    for index in order {
        let r = lengths[index];
        if distances.last().is_none_or(|d| r > d.r * (1.0 + SAME)) {
            distances.push(Distance::new(r));
        }
        entries[index].distance = (distances.len() - 1) as u32;
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::NODE;
    use crate::kernel::FreeSurface;
    use interface::WetFace;

    /// Largest residual of `½p + Dp − S ∂p/∂n = 0` over the largest `S ∂p/∂n`.
    fn residual(elements: f64, k: f64, p: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> f64 {
        let depth = 10.0;
        let face = WetFace::new(vec![[0.0, 0.0], [0.0, 4.0], [1.5, depth]]).unwrap();
        let mesh = BoundaryMesh::new(&face, depth / elements, 6.0);
        let kernel = FreeSurface { level: depth };
        let operators = LayerOperators::new(&mesh, &kernel, &mesh.nodes());
        let layers =
            if k > 0.0 { operators.assemble(k.into()).unwrap() } else { operators.assemble_static() };
        let count = mesh.nodes().len();
        let normal = |node: usize| mesh.elements()[node / 2].normal()[1];
        let y: Vec<f64> = mesh.nodes().iter().map(|x| x[1]).collect();
        let (mut worst, mut scale) = (0.0f64, 0.0f64);
        for i in 0..count {
            let potential: Complex64 = (0..count).map(|j| layers.double[(i, j)] * p(y[j])).sum();
            let forcing: Complex64 =
                (0..count).map(|j| layers.single[(i, j)] * slope(y[j]) * normal(j)).sum();
            worst = worst.max((potential + 0.5 * p(y[i]) - forcing).norm());
            scale = scale.max(forcing.norm());
        }
        worst / scale
    }

    /// `p = h − y` is linear and harmonic: only quadrature errs. Kink, corner and surface included.
    #[test]
    fn linear_pressure_is_reproduced() {
        for k in [1e-7, 0.0] {
            let error = residual(7.0, k, |y| 10.0 - y, |_| -1.0);
            println!("linear field in the boundary integral equation, k = {k}: residual {error:.1e}");
            assert!(error < 1e-8);
        }
    }

    /// `p = sinh k(h − y)` solves `∇²p = k²p`: linear elements leave an error of second order.
    #[test]
    fn exponential_pressure_converges() {
        let k = 0.3;
        let error = |n| residual(n, k, |y| (k * (10.0 - y)).sinh(), |y| -k * (k * (10.0 - y)).cosh());
        let (coarse, fine) = (error(8.0), error(32.0));
        println!("exponential field in the boundary integral equation: residual {coarse:.1e}, {fine:.1e}");
        assert!(fine < coarse / 12.0 && fine < 1e-3);
    }

    /// Every node's two shape functions sum to one, so do the weights: `∫ N₁ + N₂ = length`.
    #[test]
    fn shapes_are_a_partition_of_unity() {
        for position in [-1.0, -NODE, 0.2, 1.0] {
            let [first, second] = shape(position);
            assert!((first + second - 1.0).abs() < 1e-15);
        }
    }
}
