//! Water by finite elements: construction, a step, a repeated step; h/16, 40 points.

#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

use cofferdam_reservoir::{FiniteElements, ReservoirParameters};
use cofferdam_unit::WetFace;
use divan::Bencher;

const DEPTH: f64 = 91.75;

fn main() {
    divan::main();
}

/// The far end lies at `distance` depths.
fn parameters(distance: f64) -> ReservoirParameters {
    ReservoirParameters {
        far_end_distance: distance * DEPTH,
        ..ReservoirParameters::before(WetFace::straight([0.0, DEPTH], 39).unwrap())
    }
}

#[divan::bench(args = [0.5, 1.0, 2.0], sample_count = 5, sample_size = 1)]
fn setup(bencher: Bencher, distance: f64) {
    let parameters = parameters(distance);
    bencher.bench(|| FiniteElements::new(&parameters).unwrap());
}

#[divan::bench(args = [0.5, 1.0, 2.0], sample_count = 5, sample_size = 1)]
fn another_step_length(bencher: Bencher, distance: f64) {
    let mut water = FiniteElements::new(&parameters(distance)).unwrap();
    bencher.bench_local(|| water.set_communication_step(0.001).unwrap());
}

#[divan::bench(args = [0.5, 1.0, 2.0])]
fn step(bencher: Bencher, distance: f64) {
    let water = FiniteElements::new(&parameters(distance)).unwrap();
    let inputs: Vec<f64> = (0..water.inputs()).map(|i| (i as f64).sin()).collect();
    let mut next = vec![0.0; water.state_len()];
    water.step(&vec![0.0; water.state_len()], &inputs, &mut next);
    let state = next.clone();
    bencher.bench_local(|| water.step(&state, &inputs, &mut next));
}

#[divan::bench(args = [0.5, 1.0, 2.0])]
fn repeated_pressure(bencher: Bencher, distance: f64) {
    let water = FiniteElements::new(&parameters(distance)).unwrap();
    let inputs: Vec<f64> = (0..water.inputs()).map(|i| (i as f64).sin()).collect();
    let prepared = water.prepare(&vec![0.0; water.state_len()]);
    bencher.bench_local(|| water.pressure(&prepared, &inputs));
}
