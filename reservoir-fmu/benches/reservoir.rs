//! Kernel setup and steps at 19 and 37 interface points, 25 s at 2.5 ms.

#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

use cofferdam_reservoir::{Reservoir, ReservoirParameters};
use cofferdam_unit::variables::reservoir::INTERFACE_ACCELERATION;
use cofferdam_unit::{CoSimulation, WetFace};
use divan::Bencher;
use std::num::NonZeroUsize;

const STEP: f64 = 0.0025;
const THREADS: NonZeroUsize = NonZeroUsize::new(2).unwrap();

fn main() {
    divan::main();
}

fn parameters(points: usize, alpha: f64) -> ReservoirParameters {
    let depth = 91.75;
    ReservoirParameters {
        wave_reflection_coefficient: alpha,
        element_size: 5.1,
        communication_step: STEP,
        horizon: 25.0,
        ..ReservoirParameters::before(WetFace::straight([0.0, depth], points - 1).unwrap())
    }
}

#[divan::bench(args = [(19, 1.0), (37, 1.0), (19, 0.75)], sample_count = 3, sample_size = 1)]
fn setup(bencher: Bencher, (points, alpha): (usize, f64)) {
    bencher.bench(|| Reservoir::new(parameters(points, alpha), THREADS).unwrap());
}

/// A crack at 66.5 m: two element lengths on the face, so fewer equal distances.
#[divan::bench(args = [1.0, 0.75], sample_count = 1, sample_size = 1)]
fn setup_cracked(bencher: Bencher, alpha: f64) {
    let lower = (0..=14).map(|i| [0.0, 4.75 * f64::from(i)]);
    let upper = (0..=5).map(|i| [0.0, 66.5 + 5.05 * f64::from(i)]);
    let wet_face = WetFace::new(lower.chain(upper).collect()).unwrap();
    bencher.bench(|| {
        let parameters = ReservoirParameters { wet_face: wet_face.clone(), ..parameters(21, alpha) };
        Reservoir::new(parameters, THREADS).unwrap()
    });
}

#[divan::bench(args = [19, 37], sample_count = 1, sample_size = 1)]
fn ten_thousand_steps(bencher: Bencher, points: usize) {
    let mut unit = Reservoir::new(parameters(points, 1.0), THREADS).unwrap();
    unit.initialise(0.0).unwrap();
    let start = unit.save_state();
    bencher.bench_local(|| {
        unit.restore_state(&start).unwrap();
        for step in 0..10_000 {
            let acceleration = vec![(0.3 * step as f64).sin(); points];
            unit.set(INTERFACE_ACCELERATION.value_reference, &acceleration).unwrap();
            unit.step(step as f64 * STEP, STEP).unwrap();
        }
    });
}
