//! One frequency of the boundary elements, and the solvers that could be used.

#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

use cofferdam_reservoir::{BoundarySystem, Complex64, ReservoirParameters, boundary_system};
use cofferdam_unit::WetFace;
use divan::Bencher;
use faer::linalg::solvers::Solve;

fn main() {
    divan::main();
}

/// A diagonally dominant matrix, like those of integral equations of the second kind.
fn entry(i: usize, j: usize) -> Complex64 {
    let x = (i * 7919 + j * 104_729) as f64;
    Complex64::new(x.sin() / 10.0, x.cos() / 10.0) + if i == j { 4.0 } else { 0.0 }
}

#[divan::bench(args = [64, 128, 256, 512])]
fn nalgebra_lu(bencher: Bencher, size: usize) {
    let matrix = nalgebra::DMatrix::from_fn(size, size, entry);
    let forcing = nalgebra::DMatrix::from_fn(size, 42, entry);
    bencher.bench_local(|| matrix.clone().lu().solve(&forcing));
}

#[divan::bench(args = [64, 128, 256, 512])]
fn faer_lu(bencher: Bencher, size: usize) {
    let matrix = faer::Mat::from_fn(size, size, entry);
    let forcing = faer::Mat::from_fn(size, 42, entry);
    bencher.bench_local(|| matrix.partial_piv_lu().solve(&forcing));
}

fn system(slope: f64, alpha: f64, elements: f64) -> BoundarySystem {
    let depth = 100.0;
    let face = WetFace::straight([slope * depth, depth], 39).unwrap();
    let parameters = ReservoirParameters {
        element_size: depth / elements,
        wave_reflection_coefficient: alpha,
        ..ReservoirParameters::before(face)
    };
    boundary_system(&parameters).unwrap()
}

/// 40 points: a battered face, α = 1 and 0.75, h/16 and h/40; a vertical one.
#[divan::bench(args = [(0.1, 1.0, 16.0), (0.1, 0.75, 16.0), (0.0, 1.0, 16.0), (0.1, 1.0, 40.0), (0.1, 0.75, 40.0)])]
fn symbol(bencher: Bencher, (slope, alpha, elements): (f64, f64, f64)) {
    let system = system(slope, alpha, elements);
    bencher.bench_local(|| system.symbol(Complex64::new(3.0, 40.0)).unwrap());
}
