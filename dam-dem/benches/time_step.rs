//! Cost of the steps of the dam: `cargo bench -p cofferdam_dam`.
//!
//! Items are element-steps. The inverse of the item rate is the time per element-step, including loads, contacts,
//! integration and energies.

#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

use cofferdam_dam::Dam;
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_unit::CoSimulation;
use divan::{Bencher, counter::ItemsCount};

#[allow(dead_code)] // the bench uses a part of it
#[path = "../tests/support/mod.rs"]
mod support;

fn main() {
    divan::main();
}

const STEP: f64 = 2.5e-3;

#[divan::bench(args = [5.0, 2.5])]
fn cracked(bencher: Bencher, element_size: f64) {
    run(bencher, support::at_rest(support::koyna(element_size)).unwrap());
}

#[divan::bench(args = [5.0, 2.5])]
fn intact(bencher: Bencher, element_size: f64) {
    let parameters = cofferdam_dam::DamParameters { cracks: Vec::new(), ..support::koyna(element_size) };
    run(bencher, support::at_rest(parameters).unwrap());
}

#[divan::bench(args = [5.0, 2.5])]
fn small_strain(bencher: Bencher, element_size: f64) {
    let parameters = cofferdam_dam::DamParameters {
        cracks: Vec::new(),
        kinematics: cofferdam_dam::Kinematics::Small,
        ..support::koyna(element_size)
    };
    run(bencher, support::at_rest(parameters).unwrap());
}

/// Blocks represented by modes, in a calm step; items are communication steps.
#[divan::bench(args = [5.0, 2.5])]
fn reduced(bencher: Bencher, element_size: f64) {
    let fidelity = cofferdam_dam::Fidelity::Reduced { modes: None };
    let parameters = cofferdam_dam::DamParameters { fidelity, ..support::koyna(element_size) };
    measure(bencher, support::at_rest(parameters).unwrap(), 1);
}

#[divan::bench(args = [5.0, 2.5], sample_count = 5)]
fn static_start(bencher: Bencher, element_size: f64) {
    bencher.bench(|| support::at_rest(support::koyna(element_size)));
}

/// Elements alone, with meshes that fit into the caches and meshes that do not, on one and two threads; items are
/// element-steps.
#[divan::bench(args = [5.0, 2.5, 1.7, 1.25, 0.6, 0.38], consts = [1, 2], sample_count = 20)]
fn mesh<const THREADS: usize>(bencher: Bencher, element_size: f64) {
    let parameters = cofferdam_dam::DamParameters { cracks: Vec::new(), ..support::koyna(element_size) };
    let (mesh, laws) =
        (parameters.mesh().expect("a mesh"), Vec::<(cofferdam_dam::contact::Coulomb, _)>::new());
    let base = mesh.base.clone();
    let structure =
        cofferdam_dam::Structure::new(mesh, &parameters.material, parameters.kinematics, laws, &base);
    let structure = structure.on_threads(THREADS.try_into().unwrap()).unwrap();
    let rayleigh = cofferdam_dam::RayleighCoefficients { mass: 1.0, stiffness: 1e-3 };
    let damping = cofferdam_dam::DampingCoefficients {
        rayleigh,
        memory: 0.8,
        ..cofferdam_dam::DampingCoefficients::NONE
    };
    let steps = CentralDifference { time_step: 1e-7, steps: 20 };
    let (mut motion, loads) = (structure.at_rest(), LoadPath::constant(structure.weight([0.0, -9.81])));
    let items = structure.cells.triangle_count() * steps.steps;
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        steps.advance(&structure, damping, &mut motion, &loads, &mut Work::default());
    });
}

/// Walls of 10, 50 and 200 blocks between crossing cracks; items are contacts times time steps, elements and the search for
/// meetings included.
#[divan::bench(args = [[5, 2], [10, 5], [20, 10]], sample_count = 20)]
fn wall(bencher: Bencher, [columns, rows]: [usize; 2]) {
    let mesh = support::assembly::wall(columns, rows, 0.6);
    let law =
        cofferdam_dam::contact::Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 0.5e9 };
    let laws = vec![(law, cofferdam_dam::contact::Integration::Nodal); columns + rows - 2];
    let base = mesh.base.clone();
    let material = support::stiff(1e9);
    let structure =
        cofferdam_dam::Structure::new(mesh, &material, cofferdam_dam::Kinematics::Corotational, laws, &base);
    let rayleigh = cofferdam_dam::RayleighCoefficients { mass: 1.0, stiffness: 1e-5 };
    let limit = 0.9 * support::critical(&structure, rayleigh).limit;
    let steps = CentralDifference { time_step: limit, steps: 20 };
    let (mut motion, loads) = (structure.at_rest(), LoadPath::constant(structure.weight([3.0, -9.81])));
    let items = motion.joints.iter().map(Vec::len).sum::<usize>() * steps.steps;
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        steps.advance(&structure, rayleigh, &mut motion, &loads, &mut Work::default());
    });
}

fn run(bencher: Bencher, dam: Dam) {
    let items = dam.element_count() * dam.time_steps_per(STEP);
    measure(bencher, dam, items);
}

fn measure(bencher: Bencher, mut dam: Dam, items: usize) {
    support::shake(&mut dam, STEP, 0.1, support::bursts).unwrap();
    let start = dam.save_state();
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        dam.restore_state(&start)?;
        dam.step(start.time(), STEP)
    });
}
