//! A semicircular arch of radial voussoirs that do not slide: the least thickness with which it carries its own weight.

use std::f64::consts::PI;

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::integrator::DynamicRelaxation;
use cofferdam_dam::{Kinematics, Structure};
use nalgebra::{Matrix3, Vector3};

use crate::support::assembly::{Assembly, Placed, rectangle};
use crate::support::{self, GRAVITY};

/// Radius of the middle line, m.
const RADIUS: f64 = 10.0;
/// Of a circular arch with any number of voussoirs, over the radius (Milankovitch, 1907; Heyman, 1969, gave 0.106).
const MILANKOVITCH: f64 = 0.1075;

/// A point at this distance from the centre of the arch, at an angle from its crown, positive downstream.
fn polar(radius: f64, angle: f64) -> [f64; 2] {
    [radius * angle.sin(), radius * angle.cos()]
}

/// The largest slack s of the thrust line in an arch of `count` (even) voussoirs with straight sides: the linear programme
///
/// ```text
/// max s:  moment of crown thrust and weight about the intrados of each joint ≥ s,
///         about the extrados ≤ −s,  with the thrust H and its height z at the crown: (H, H z, s) are unknown
/// ```
///
/// per N/m³ of weight, solved by trying all of its vertices. By symmetry there is no shear at the crown.
fn slack(count: usize, thickness: f64) -> f64 {
    let step = PI / count as f64;
    let [inner, outer] = [RADIUS - thickness / 2.0, RADIUS + thickness / 2.0];
    // trapezoids: half the product of its diagonals
    let area = 0.5 * (outer * outer - inner * inner) * step.sin();
    let height = (outer - inner) * (step / 2.0).cos();
    let [a, b] = [inner, outer].map(|radius| 2.0 * radius * (step / 2.0).sin());
    let centroid = inner * (step / 2.0).cos() + height * (a + 2.0 * b) / (3.0 * (a + b));
    // each row: c · (H, H z, s) ≤ d
    let mut rows: Vec<(Vector3<f64>, f64)> = Vec::new();
    for joint in 0..=count / 2 {
        let weights: Vec<f64> = (0..joint).map(|i| centroid * ((i as f64 + 0.5) * step).sin()).collect();
        for (radius, sign) in [(inner, 1.0), (outer, -1.0)] {
            let [x, y] = polar(radius, joint as f64 * step);
            // positive clockwise: the thrust at z turns the half arch outwards, weight turns it inwards
            let weight: f64 = weights.iter().map(|centre| area * (x - centre)).sum();
            rows.push((Vector3::new(sign * y, -sign, 1.0), sign * -weight));
        }
    }
    let mut best = f64::NEG_INFINITY;
    for (i, j, k) in (0..rows.len()).flat_map(|i| (0..i).flat_map(move |j| (0..j).map(move |k| (i, j, k)))) {
        let matrix = Matrix3::from_rows(&[i, j, k].map(|row| rows[row].0.transpose()));
        let Some(inverse) = matrix.try_inverse() else { continue };
        let vertex = inverse * Vector3::new(rows[i].1, rows[j].1, rows[k].1);
        let feasible = rows.iter().all(|(c, d)| c.dot(&vertex) <= d + 1e-9 * RADIUS * RADIUS);
        if feasible && vertex[2] > best {
            best = vertex[2];
        }
    }
    best
}

/// The thickness over the radius where the slack is 0.
fn least_thickness(count: usize) -> f64 {
    let (mut falls, mut stands) = (0.02, 0.3);
    while stands - falls > 1e-7 {
        let middle = (falls + stands) / 2.0;
        *(if slack(count, middle * RADIUS) > 0.0 { &mut stands } else { &mut falls }) = middle;
    }
    stands
}

/// The arch between two fixed blocks; joints as stiff as `stiffness` (Pa/m), with two segments.
fn arch(count: usize, thickness: f64, stiffness: f64) -> Structure {
    let step = PI / count as f64;
    let voussoir = rectangle([1.0, 1.0], [1, 2]);
    let mut assembly = Assembly::new();
    let mut before: Option<Placed> = None;
    for number in 0..count + 2 {
        let from = -PI / 2.0 + (number as f64 - 1.0) * step;
        let placed = assembly.add(&voussoir, |[x, y]| polar(RADIUS + thickness * (y - 0.5), from + x * step));
        if let Some(before) = before {
            // the joint runs outwards: on its right is the voussoir downstream
            assembly.join(0, (placed.block, &placed.upstream), (before.block, &before.downstream));
        }
        before = Some(placed);
    }
    let blocks = &assembly.mesh.blocks;
    let fixed: Vec<usize> = blocks[0].nodes.clone().chain(blocks[count + 1].nodes.clone()).collect();
    let law = Coulomb { friction: 1e3, normal_stiffness: stiffness, shear_stiffness: stiffness };
    let contacts = [(law, Integration::Nodal)];
    Structure::new(assembly.mesh, &support::stiff(stiffness), Kinematics::Corotational, contacts, &fixed)
}

/// Whether the arch finds a state of rest.
fn stands(count: usize, thickness: f64, stiffness: f64) -> bool {
    let structure = arch(count, thickness, stiffness);
    let weight = structure.weight([0.0, -GRAVITY]);
    let solver = DynamicRelaxation { tolerance: 1e-5, max_iterations: 30_000 };
    let found = solver.relax(&structure, &mut structure.at_rest(), &weight);
    println!("    t/R = {:.5}, {stiffness:.0e} Pa/m: {found:?}", thickness / RADIUS);
    found.is_ok()
}

/// With more and more joints, they can form the worst mechanism.
#[test]
fn the_limit_of_many_voussoirs_is_milankovitchs() {
    let found = [8, 20, 40, 80].map(|count| (count, least_thickness(count)));
    println!("least t/R by voussoirs: {found:.5?}");
    assert!((found[3].1 / MILANKOVITCH - 1.0).abs() < 5e-3);
}

/// With these voussoirs' joints, within 1 % if the joints are stiff. A softer joint closes at its hinge, which moves inwards:
/// the arch must be thicker. The thickness is found to 0.2 %.
#[test]
fn an_arch_stands_from_its_least_thickness_on() {
    let least = least_thickness(20);
    let found = [1e9, 1e10, 1e11].map(|stiffness| {
        let (mut falls, mut holds) = (0.95, 1.2);
        while holds - falls > 2e-3 {
            let middle = (falls + holds) / 2.0;
            *(if stands(20, middle * least * RADIUS, stiffness) { &mut holds } else { &mut falls }) = middle;
        }
        println!(
            "{stiffness:.0e} Pa/m: stands from {:.5} R on, {holds:.4} of the least {least:.5} R",
            holds * least
        );
        holds
    });
    assert!(found.is_sorted_by(|softer, stiffer| softer >= stiffer));
    assert!((found[2] - 1.0).abs() < 0.01);
}
