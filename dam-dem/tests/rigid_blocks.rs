//! A stiff block on the ground: rocking, and sliding under a record, against the equations of motion of a
//! rigid block.

use crate::support;

use cofferdam_dam::analytical::newmark_1965::slip_on_ground;
use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, DynamicRelaxation};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{DamError, DampingCoefficients, Motion, RayleighCoefficients, best_fit_rotation};
use support::{GRAVITY, mean};

/// Component of gravity along the slope, as a share of g.
const SLOPE: f64 = 0.04;

/// Time from rest at θ₀ until the block stands upright, against `I θ̈ = −m g R sin(α − θ)` about the corner,
/// with the moment of inertia of the lumped masses. Initially the corner is displaced so that the contact
/// forces are those of this motion.
#[test]
fn rocking_takes_its_time() {
    let law = Coulomb { friction: 10.0, normal_stiffness: 2e10, shear_stiffness: 2e10 };
    let structure = support::block_on_ground([1.0, 2.0], 1e12, law, Integration::Nodal);
    let nodes = structure.mesh.blocks[1].nodes.clone();
    let corner = structure.mesh.nodes[structure.mesh.seams[0].upper[0]];
    let arm = |n: usize| [structure.mesh.nodes[n][0] - corner[0], structure.mesh.nodes[n][1] - corner[1]];
    let mass: f64 = nodes.clone().map(|n| structure.mass[n]).sum();
    let centre = [0, 1].map(|d| nodes.clone().map(|n| structure.mass[n] * arm(n)[d]).sum::<f64>() / mass);
    let inertia: f64 =
        nodes.clone().map(|n| structure.mass[n] * (arm(n)[0].powi(2) + arm(n)[1].powi(2))).sum();
    let (radius, slenderness) = (centre[0].hypot(centre[1]), centre[0].atan2(centre[1]));
    // with contacts without damping, steps longer than a quarter of 2/ω create energy
    let step = 0.2 * support::critical(&structure, DampingCoefficients::NONE).limit;
    let weight = structure.weight([0.0, -GRAVITY]);
    for share in [0.2, 0.4, 0.6] {
        let angle = share * slenderness;
        let mut motion = structure.at_rest();
        // turned downstream about the downstream corner; the centre of mass then moves back upstream and down
        let (sin, cos) = (-angle).sin_cos();
        let (across, up) = (slenderness - angle).sin_cos();
        let falls = mass * GRAVITY * radius / inertia * across;
        let far = structure.mesh.nodes[*structure.mesh.seams[0].upper.last().unwrap()];
        let place = |motion: &mut Motion, pressed: [f64; 2]| {
            for n in nodes.clone() {
                let [x, y] = structure.mesh.nodes[n];
                let [rx, ry] = [x - far[0], y - far[1]];
                let place =
                    [far[0] + cos * rx - sin * ry + pressed[0], far[1] + sin * rx + cos * ry - pressed[1]];
                motion.displacement[n] = [place[0] - x, place[1] - y];
            }
        };
        // stiffness of the contacts at the corner: that of the block's node and those of the ground's nodes
        let mut probe = structure.at_rest();
        place(&mut probe, [0.0, 1e-7]);
        let mut forces = vec![[0.0; 2]; probe.displacement.len()];
        structure.add_internal_forces(&mut probe, 0.0, &mut forces);
        let spring = nodes.clone().map(|n| forces[n][1]).sum::<f64>() / 1e-7;
        let pressed =
            [mass * radius * falls * up / spring, (mass * GRAVITY - mass * radius * falls * across) / spring];
        place(&mut motion, pressed);
        structure.accelerate(DampingCoefficients::NONE, &mut motion, &weight);
        let loads = LoadPath::constant(weight.clone());
        let rotation = |motion: &cofferdam_dam::Motion| {
            best_fit_rotation(
                nodes.clone().map(|n| (structure.mass[n], structure.mesh.nodes[n], motion.displacement[n])),
            )
        };
        let (mut time, mut before) = (0.0, rotation(&motion));
        let measured = loop {
            CentralDifference { time_step: step, steps: 1 }.advance(
                &structure,
                DampingCoefficients::NONE,
                &mut motion,
                &loads,
                &mut Work::default(),
            );
            let now = rotation(&motion);
            if now >= 0.0 {
                break time + step * before / (before - now);
            }
            (before, time) = (now, time + step);
        };
        let exact = quarter_period(mass * GRAVITY * radius / inertia, slenderness, angle);
        let error = measured / exact - 1.0;
        println!(
            "rocking from {share} of α: {measured:.5} s, exact {exact:.5} s, relative error {error:.1e}"
        );
        assert!(error.abs() < 3e-3);
    }
}

/// Time in which `θ̈ = −p² sin(α − θ)` leads from θ₀ at rest to 0, by the Runge–Kutta method with steps of 2e-6 s.
fn quarter_period(square: f64, slenderness: f64, angle: f64) -> f64 {
    let slope = |[theta, omega]: [f64; 2]| [omega, -square * (slenderness - theta).sin()];
    let (mut state, mut time, step) = ([angle, 0.0], 0.0, 2e-6);
    loop {
        let shifted = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
        let a = slope(state);
        let b = slope(shifted(a, step / 2.0));
        let c = slope(shifted(b, step / 2.0));
        let d = slope(shifted(c, step));
        let next = [0, 1].map(|i| state[i] + step / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        if next[0] <= 0.0 {
            return time + step * state[0] / (state[0] - next[0]);
        }
        (state, time) = (next, time + step);
    }
}

/// Slip of a stiff block on a slope of 0.04 g under one of the project's records along the slope, against
/// that of a rigid block.
#[test]
fn a_record_slides_a_block_as_newmark_says() -> Result<(), DamError> {
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/records/northridge-1994-canyon-country-270.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let samples: Vec<(f64, f64)> = text
        .lines()
        .filter_map(|line| {
            let (time, value) = line.split_once(',')?;
            Some((time.trim().parse().ok()?, GRAVITY * (SLOPE + value.trim().parse::<f64>().ok()?)))
        })
        .take_while(|(time, _)| *time <= 12.0)
        .collect();
    let friction = 0.1;
    let law = Coulomb { friction, normal_stiffness: 1e9, shear_stiffness: 1e9 };
    let structure = support::block_on_ground([3.0, 0.6], 1e9, law, Integration::Nodal);
    let damping = RayleighCoefficients { mass: 0.0, stiffness: 1e-3 };
    let mut motion = structure.at_rest();
    let forces = |a: f64| structure.weight([-a, -GRAVITY]);
    DynamicRelaxation::default().relax(&structure, &mut motion, &forces(SLOPE * GRAVITY))?;
    let rest = mean(&structure, &motion.displacement, 1)[0];
    structure.accelerate(damping, &mut motion, &forces(samples[0].1));
    let limit = 0.9 * support::critical(&structure, damping).limit;
    let mut work = Work::default();
    for pair in samples.windows(2) {
        let [start, end] = [pair[0], pair[1]].map(|(_, a)| forces(a));
        let change = start.iter().zip(&end).map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        let steps = CentralDifference::covering(pair[1].0 - pair[0].0, limit);
        steps.advance(&structure, damping, &mut motion, &LoadPath { start, change }, &mut work);
    }
    let slip = mean(&structure, &motion.displacement, 1)[0] - rest;
    let exact = slip_on_ground(&samples, friction * GRAVITY);
    let error = slip / exact - 1.0;
    println!(
        "Newmark's block under a record: {:.2} mm, exact {:.2} mm, relative error {error:.1e}",
        1e3 * slip,
        1e3 * exact
    );
    assert!(exact.abs() > 0.05 && error.abs() < 1e-2);
    Ok(())
}
