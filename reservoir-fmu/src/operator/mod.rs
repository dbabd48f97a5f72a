//! Single and double layer of every element at every collocation point.
//!
//! Depends on `boundary`, `kernel` and `quadrature`. The geometry (distances, quadrature
//! weights, shape functions) does not depend on the frequency and is computed once, unless it is too
//! large to be stored.

mod double_layer;
mod geometry;
mod single_layer;

use crate::boundary::BoundaryMesh;
use crate::kernel::{HelmholtzKernel, Ray, Source, Table};
use faer::Mat;
use geometry::Geometry;
use num_complex::Complex64;
use rayon::prelude::*;

/// Largest number of quadrature points that are stored, of 40 bytes each.
const KEPT: usize = 8_000_000;
/// Rows that are computed at once where the geometry is not stored.
const ROWS: usize = 16;

/// Geometry of both layers at fixed collocation points.
pub(crate) struct LayerOperators {
    mesh: BoundaryMesh,
    /// Sources of every collocation point.
    sources: Vec<Vec<Source>>,
    /// None if it is too large.
    geometry: Option<Geometry>,
    /// Largest distance, m.
    farthest: f64,
    /// Extent of the mesh: length R in `ln(r/R)`, m.
    extent: f64,
}

/// Matrices of both layers at one frequency, rows: collocation points, columns: nodes.
pub(crate) struct Layers {
    /// `S_ij = ∫ G(x_i, y) N_j(y) ds`, m.
    pub single: Mat<Complex64>,
    /// `D_ij = ∫ ∂G/∂n_y(x_i, y) N_j(y) ds`, without the free term.
    pub double: Mat<Complex64>,
}

/// `[K₀(kr), k K₁(kr)]` as functions of r.
enum Kernels {
    /// At k = 0, `[−ln(r/R), 1/r]`.
    Static(f64),
    Ray(Ray),
    Table(Table),
}

impl Kernels {
    fn at(&self, r: f64) -> [Complex64; 2] {
        match self {
            Self::Static(extent) => [-(r / extent).ln(), 1.0 / r].map(Complex64::from),
            Self::Ray(ray) => ray.at(r),
            Self::Table(table) => table.evaluate(r),
        }
    }
}

impl LayerOperators {
    /// Prepares both layers of `mesh` at `points` (m), which may lie on elements.
    pub fn new(mesh: &BoundaryMesh, kernel: &dyn HelmholtzKernel, points: &[[f64; 2]]) -> Self {
        let sources: Vec<_> = points.iter().map(|&point| kernel.sources(point)).collect();
        let ends = mesh.elements().iter().map(|e| e.start);
        let extent = diagonal(ends.clone());
        let farthest = diagonal(ends.chain(sources.iter().flatten().map(|source| source.point)));
        let most = 5 * mesh.elements().len() * sources.iter().map(Vec::len).sum::<usize>();
        let geometry = (most <= KEPT).then(|| Geometry::new(mesh, &sources).merged());
        Self { mesh: mesh.clone(), sources, geometry, farthest, extent }
    }

    /// Both layers at `wavenumber` k = s/c (1/m, real part not negative); at k = 0 those of Laplace's equation.
    ///
    /// A geometry that is too large to be stored is computed on the current rayon pool.
    pub fn assemble(&self, wavenumber: Complex64) -> Result<Layers, complex_bessel::Error> {
        let distances = self.geometry.as_ref().map_or(usize::MAX, Geometry::distances);
        let kernels = if wavenumber == Complex64::ZERO {
            Kernels::Static(self.extent)
        } else {
            let ray = Ray::new(wavenumber, self.farthest)?;
            Table::new(ray, self.farthest, distances).map_or_else(Kernels::Ray, Kernels::Table)
        };
        let (rows, columns) =
            (self.sources.len(), self.mesh.elements().len() * self.mesh.order().nodes().len());
        let mut layers = Layers { single: Mat::zeros(rows, columns), double: Mat::zeros(rows, columns) };
        let mut fill = |geometry: &Geometry, first_row: usize, values: &[[Complex64; 2]]| {
            geometry.for_each(values, |row, column, single, double| {
                layers.single[(first_row + row, column)] = single;
                layers.double[(first_row + row, column)] = double;
            });
        };
        if let Some(geometry) = &self.geometry {
            fill(geometry, 0, &geometry.radii().iter().map(|&r| kernels.at(r)).collect::<Vec<_>>());
            return Ok(layers);
        }
        let chunks: Vec<&[Vec<Source>]> = self.sources.chunks(ROWS).collect();
        // A few rows at a time, because all of them do not fit into memory.
        for (batch, chunks) in chunks.chunks(2 * rayon::current_num_threads()).enumerate() {
            let done: Vec<_> = chunks
                .par_iter()
                .map(|sources| {
                    let geometry = Geometry::new(&self.mesh, sources);
                    let values: Vec<_> = geometry.radii().iter().map(|&r| kernels.at(r)).collect();
                    (geometry, values)
                })
                .collect();
            for (index, (geometry, values)) in done.iter().enumerate() {
                fill(geometry, (batch * 2 * rayon::current_num_threads() + index) * ROWS, values);
            }
        }
        Ok(layers)
    }
}

/// Diagonal of the rectangle around `points`, m.
fn diagonal(points: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let span = |axis: usize| {
        let values = points.clone().map(|p| p[axis]);
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
        high - low
    };
    span(0).hypot(span(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{FreeSpace, FreeSurface};
    use crate::outline::Outline;
    use crate::{ElementOrder, ReservoirParameters};
    use cofferdam_unit::WetFace;

    /// Largest residual of `½p + Dp − S ∂p/∂n = 0` over the largest `S ∂p/∂n`, before a kinked face and bed.
    fn residual(
        [elements, corner]: [f64; 2],
        k: Complex64,
        waves: bool,
        order: ElementOrder,
        p: impl Fn(f64) -> Complex64,
        slope: impl Fn(f64) -> Complex64,
    ) -> f64 {
        let depth = 10.0;
        let parameters = ReservoirParameters {
            bed: vec![[-2.0, 0.0], [-5.0, 3.0]],
            surface_waves: waves,
            element_order: order,
            element_size: depth / elements,
            corner_element_size: Some(corner),
            far_end_distance: 6.0,
            ..ReservoirParameters::before(WetFace::new(vec![[0.0, 0.0], [0.0, 4.0], [1.5, depth]]).unwrap())
        };
        let mesh = BoundaryMesh::new(&Outline::new(&parameters).unwrap(), &parameters);
        let kernel: &dyn HelmholtzKernel = if waves { &FreeSpace } else { &FreeSurface { level: depth } };
        let layers = LayerOperators::new(&mesh, kernel, &mesh.nodes()).assemble(k).unwrap();
        let count = mesh.nodes().len();
        let normal = |node: usize| mesh.elements()[node / order.nodes().len()].normal()[1];
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

    /// `p = h − y` is linear and harmonic: the only error is that of the quadrature. With kinks, corners and surface, by
    /// an image and, shifted by a constant, meshed.
    #[test]
    fn linear_pressure_is_reproduced() {
        for (waves, shift) in [(false, 0.0), (true, 3.0)] {
            for k in [0.0, 1e-7] {
                let p = |y: f64| Complex64::from(10.0 + shift - y);
                let slope = |_| Complex64::from(-1.0);
                let error = residual([7.0, 0.1], k.into(), waves, ElementOrder::Linear, p, slope);
                println!(
                    "linear field in the integral equation, k = {k}, surface meshed: {waves}: {error:.1e}"
                );
                assert!(error < 1e-8);
            }
        }
    }

    /// `p = sinh k(h − y)` solves `∇²p = k²p`: linear elements leave an error of second order, constant ones of
    /// first at the nodes beside corners. Damped and real frequencies.
    #[test]
    fn exponential_pressure_converges() {
        for (order, gain) in [(ElementOrder::Linear, 12.0), (ElementOrder::Constant, 3.5)] {
            for k in [Complex64::new(0.3, 0.0), Complex64::new(0.1, 0.5), Complex64::new(0.0, 0.5)] {
                for waves in [false, true] {
                    let p = |y: f64| (k * (10.0 - y)).sinh();
                    let slope = |y: f64| -k * (k * (10.0 - y)).cosh();
                    let [coarse, fine] = [16.0, 64.0].map(|n| residual([n, 9.0], k, waves, order, p, slope));
                    println!(
                        "{order:?}, k = {k}, surface meshed: {waves}: residual {coarse:.1e}, {fine:.1e}"
                    );
                    assert!(fine < coarse / gain && fine < 2e-2);
                }
            }
        }
    }

    /// A geometry that is not stored but computed row by row gives the same.
    #[test]
    fn geometry_that_is_not_kept_gives_the_same() {
        let parameters = ReservoirParameters::before(WetFace::straight([2.0, 10.0], 4).unwrap());
        let mesh = BoundaryMesh::new(&Outline::new(&parameters).unwrap(), &parameters);
        let mut operators = LayerOperators::new(&mesh, &FreeSurface { level: 10.0 }, &mesh.nodes());
        let k = Complex64::new(0.01, 0.6);
        let kept = operators.assemble(k).unwrap();
        operators.geometry = None;
        let again = operators.assemble(k).unwrap();
        let difference = (&kept.single - &again.single).norm_l2() + (&kept.double - &again.double).norm_l2();
        assert!(difference < 1e-9 * kept.double.norm_l2(), "{difference:.1e}");
    }
}
