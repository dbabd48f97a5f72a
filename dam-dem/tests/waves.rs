//! Waves along a bar: wave speed, and transmission through a joint.

use crate::support;

use cofferdam_dam::analytical::joint_waves::{transmission, transmitted_pulse};
use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{DampingCoefficients, Kinematics, Mesh, Section, Structure};
use std::f64::consts::PI;
use support::stiff;

const MODULUS: f64 = 31e9;
/// Length of the pulse, m, and the length of an element, m.
const PULSE: f64 = 12.0;
const ELEMENT: f64 = 0.25;

/// A free bar, 0.5 m wide, with a joint at 20 m of 50 m.
fn bar(normal_stiffness: f64) -> Structure {
    let rows = |from: f64, to: f64| -> Vec<f64> {
        let count = ((to - from) / ELEMENT).round() as usize;
        (0..=count).map(|i| from + ELEMENT * i as f64).collect()
    };
    let section = Section::rectangle(0.5, 50.0);
    let mesh = Mesh::mapped(&section, &[rows(0.0, 20.0), rows(20.0, 50.0)], 2);
    let law = Coulomb { friction: 0.5, normal_stiffness, shear_stiffness: normal_stiffness };
    Structure::new(mesh, &stiff(MODULUS), Kinematics::Small, [(law, Integration::Nodal)], &[])
}

/// A compressive pulse `sin²` travels upwards from the lower block. The joint is never in tension, because
/// the transmitted stress is compressive. Returns time and velocity at `node`, over the largest velocity of
/// the pulse.
fn velocities(structure: &Structure, node: usize, until: f64) -> Vec<(f64, f64)> {
    let speed = (MODULUS / 2500.0).sqrt();
    let mut motion = structure.at_rest();
    for (node, &[_, y]) in structure.mesh.nodes.iter().enumerate() {
        // the pulse extends from 4 m to 16 m; behind it the bar has the full displacement of the pulse
        let along = ((16.0 - y) / PULSE).clamp(0.0, 1.0);
        motion.displacement[node][1] = PULSE / speed * (along / 2.0 - (2.0 * PI * along).sin() / (4.0 * PI));
        motion.velocity[node][1] = (PI * along).sin().powi(2);
    }
    let still = structure.weight([0.0; 2]);
    structure.accelerate(DampingCoefficients::NONE, &mut motion, &still);
    let loads = LoadPath::constant(still);
    let step = 0.5 * support::critical(structure, DampingCoefficients::NONE).limit;
    let mut found = Vec::new();
    for n in 1..=(until / step) as usize {
        CentralDifference { time_step: step, steps: 1 }.advance(
            structure,
            DampingCoefficients::NONE,
            &mut motion,
            &loads,
            &mut Work::default(),
        );
        found.push((n as f64 * step, motion.velocity[node][1]));
    }
    found
}

fn node_at(structure: &Structure, y: f64) -> usize {
    let nodes = &structure.mesh.nodes;
    (0..nodes.len()).find(|&n| nodes[n] == [0.25, y]).expect("a node in the middle")
}

/// Time in which half of the peak travels between two nodes 8 m apart.
#[test]
fn waves_arrive_in_time() {
    let structure = bar(1e14);
    let speed = (MODULUS / 2500.0).sqrt();
    let passes = |y: f64| {
        let found = velocities(&structure, node_at(&structure, y), 0.009);
        let after = found.iter().position(|(_, v)| *v > 0.5).expect("it passes");
        let [(t0, v0), (t1, v1)] = [found[after - 1], found[after]];
        t0 + (0.5 - v0) / (v1 - v0) * (t1 - t0)
    };
    let measured = 8.0 / (passes(38.0) - passes(30.0));
    let error = measured / speed - 1.0;
    println!("wave speed: {measured:.2} m/s, exact {speed:.2}, relative error {error:.1e}");
    assert!(error.abs() < 1e-3);
}

/// Relative L2 error of the transmitted pulse, for joints with high and low transmission at its main frequency 2π/T.
#[test]
fn a_joint_lets_through_what_it_should() {
    let speed = (MODULUS / 2500.0).sqrt();
    let (impedance, duration) = (2500.0 * speed, PULSE / speed);
    let frequency = 2.0 * PI / duration;
    for ratio in [0.3, 1.0, 3.0] {
        let stiffness = frequency * impedance / (2.0 * ratio);
        let structure = bar(stiffness);
        // the front of the pulse travels 4 m to the joint and 10 m more to the node
        let arrival = 14.0 / speed;
        let (mut off, mut whole) = (0.0, 0.0);
        for (t, v) in velocities(&structure, node_at(&structure, 30.0), 0.0095) {
            let exact = transmitted_pulse(2.0 * stiffness / impedance, duration, t - arrival);
            off += (v - exact).powi(2);
            whole += exact * exact;
        }
        let error = (off / whole).sqrt();
        let share = transmission(frequency, impedance, stiffness);
        println!("joint with ωZ/2k = {ratio}, |T| = {share:.3}: transmitted pulse off by {error:.2e}");
        assert!(error < 5e-3);
    }
}
