//! Recursion and convolution: construction, and 128 steps (a block of the convolution) early and late in a run.

#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

use cofferdam_reservoir::{Method, Reservoir, ReservoirParameters};
use cofferdam_unit::variables::reservoir::INTERFACE_ACCELERATION;
use cofferdam_unit::{CoSimulation, WetFace};
use divan::Bencher;
use divan::counter::ItemsCount;
use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroUsize;
use std::sync::Mutex;

const DEPTH: f64 = 91.75;
const THREADS: NonZeroUsize = NonZeroUsize::new(2).unwrap();
/// Steps that are timed together.
const BLOCK: usize = 128;

fn main() {
    divan::main();
}

/// A section, its points, a method and its step (ms).
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    slope: f64,
    rise: f64,
    alpha: f64,
    points: usize,
    step: f64,
    method: Method,
}

const RIGID: Case = Case {
    name: "level, rigid",
    slope: 0.0,
    rise: 0.0,
    alpha: 1.0,
    points: 40,
    step: 1.0,
    method: Method::Recursive,
};
const ABSORBING: Case = Case { name: "level, absorbing", alpha: 0.9, ..RIGID };
const SLOPING: Case = Case { name: "batter, rising bed", slope: 0.1, rise: 0.15, ..ABSORBING };
const COARSE: Case = Case { name: "batter, rising bed", points: 13, step: 5.0, ..SLOPING };
const CONVOLUTION: Case = Case { method: Method::Radau2, ..SLOPING };

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, alpha, points, step, method, .. } = self;
        write!(f, "{method:?}, {name}, α = {alpha}, {points} points, {step} ms")
    }
}

impl Case {
    /// The unit, for 20 s.
    fn made(self) -> Option<Reservoir> {
        let face = WetFace::straight([self.slope * DEPTH, DEPTH], self.points - 1).unwrap();
        let parameters = ReservoirParameters {
            wave_reflection_coefficient: self.alpha,
            bed: if self.rise > 0.0 { vec![[-DEPTH, self.rise * DEPTH]] } else { Vec::new() },
            communication_step: 1e-3 * self.step,
            method: self.method,
            ..ReservoirParameters::before(face)
        };
        match Reservoir::new(parameters, THREADS) {
            Ok(unit) => Some(unit),
            Err(error) => {
                eprintln!("{self}: {error}");
                None
            }
        }
    }
}

/// Units that were made and are used again.
static KEPT: Mutex<BTreeMap<String, Reservoir>> = Mutex::new(BTreeMap::new());

#[divan::bench(args = [RIGID, ABSORBING, SLOPING, COARSE, CONVOLUTION], sample_count = 1, sample_size = 1)]
fn setup(bencher: Bencher, case: Case) {
    bencher.bench_local(|| {
        if let Some(unit) = case.made() {
            KEPT.lock().unwrap().insert(case.to_string(), unit);
        }
    });
}

/// A case from a step on.
#[derive(Clone, Copy)]
struct Late {
    case: Case,
    from: usize,
}

impl fmt::Display for Late {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, step {}", self.case, self.from)
    }
}

/// Takes steps `from` to `to`, with the accelerations in turn.
fn take(unit: &mut Reservoir, from: usize, to: usize, accelerations: &[Vec<f64>]) {
    let length = unit.parameters().communication_step;
    for step in from..to {
        unit.set(INTERFACE_ACCELERATION.value_reference, &accelerations[step % BLOCK]).unwrap();
        unit.step(step as f64 * length, length).unwrap();
    }
}

#[divan::bench(
    args = [
        (RIGID, 100), (RIGID, 1_000_000), (ABSORBING, 100), (ABSORBING, 1_000_000), (SLOPING, 100), (SLOPING, 1_000_000),
        (COARSE, 100), (COARSE, 1_000_000), (CONVOLUTION, 100), (CONVOLUTION, 19_800),
    ].map(|(case, from)| Late { case, from }),
    sample_count = 50,
    sample_size = 1,
)]
fn steps(bencher: Bencher, Late { case, from }: Late) {
    let kept = KEPT.lock().unwrap().remove(&case.to_string());
    let Some(mut unit) = kept.or_else(|| case.made()) else { return };
    let start = unit.save_state();
    unit.initialise(0.0).unwrap();
    let at = |step: usize, point: usize| ((0.3 + 0.01 * point as f64) * step as f64).sin();
    let accelerations: Vec<Vec<f64>> =
        (0..BLOCK).map(|step| (0..case.points).map(|point| at(step, point)).collect()).collect();
    take(&mut unit, 0, from, &accelerations);
    let state = unit.save_state();
    bencher.counter(ItemsCount::new(BLOCK)).bench_local(|| {
        unit.restore_state(&state).unwrap();
        take(&mut unit, from, from + BLOCK, &accelerations);
    });
    unit.restore_state(&start).unwrap();
    KEPT.lock().unwrap().insert(case.to_string(), unit);
}
