//! Recovered stresses: fields that they reproduce, their order at the face, the largest of a dam.

use crate::support;

use cofferdam_dam::analytical::cantilever::bending_stress;
use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::integrator::SparseNewton;
use cofferdam_dam::{DamError, Kinematics, Mesh, Section, StressRecovery, Structure};
use cofferdam_unit::WetFace;
use support::{koyna, stiff};

const MODULUS: f64 = 31e9;

fn structure(mesh: Mesh, fixed: &[usize]) -> Structure {
    let law = Coulomb { friction: 1.0, normal_stiffness: 1e11, shear_stiffness: 1e11 };
    let cracks = vec![(law, Integration::Nodal); mesh.blocks.len() - 1];
    Structure::new(mesh, &stiff(MODULUS), Kinematics::Small, cracks, fixed)
}

/// Recovered stresses at their nodes.
fn recovered(structure: &Structure, displacement: &[[f64; 2]]) -> Vec<(usize, [f64; 3])> {
    let recovery = StressRecovery::new(&structure.mesh);
    let stresses = recovery.stresses(&structure.cells, displacement, Kinematics::Small);
    recovery.nodes().iter().copied().zip(stresses).collect()
}

/// σ_yy at `node`: recovered, and the mean over the triangles that meet there by their areas.
fn at_node(structure: &Structure, displacement: &[[f64; 2]], node: usize) -> [f64; 2] {
    let all = recovered(structure, displacement);
    let found = all.iter().find(|(of, _)| *of == node).expect("a corner of a cell").1[1];
    let (mut sum, mut whole) = (0.0, 0.0);
    for (triangle, (corners, area, _)) in structure.cells.triangles().enumerate() {
        if corners.contains(&node) {
            let u = corners.map(|corner| displacement[corner]);
            sum += area * structure.cells.stress(triangle, u, Kinematics::Small)[1];
            whole += area;
        }
    }
    [found, sum / whole]
}

/// Stress (xx, yy, xy) of a displacement gradient with ν = 0.
fn stress([[xx, xy], [yx, yy]]: [[f64; 2]; 2]) -> [f64; 3] {
    [MODULUS * xx, MODULUS * yy, MODULUS * (xy + yx) / 2.0]
}

/// A quadratic displacement, another one above the crack, gives a linear stress: exact to rounding at every node of cells
/// that are parallelograms, on the outline and on both sides of the crack, across which it jumps; in a block of a single
/// row along the row. What the nodes in the centres do has no part in it.
#[test]
fn a_linear_stress_is_exact_and_jumps_at_a_crack() {
    let section = Section::new(vec![[0.0, 0.0], [2.0, 8.0]], vec![[6.0, 0.0], [8.0, 8.0]]);
    let rows = [vec![0.0, 1.0, 3.0, 4.0], vec![4.0, 6.0, 7.0], vec![7.0, 8.0]];
    let mesh = Mesh::mapped(&section, &rows, 4);
    let coefficients =
        [[1.0, -2.0, 0.7, 0.4, -1.1, 0.6], [-3.0, 0.5, 1.3, 2.0, 0.8, -0.2], [2.0, 1.0, 0.0, 0.0, 0.0, 0.0]];
    let field = |block: usize, [x, y]: [f64; 2]| {
        let [a, b, c, d, e, f] = coefficients[block].map(|value| 1e-6 * value);
        let u = [a * x * x + b * x + c * x * y, d * y * y + e * x * y + f * x * x];
        (u, [[2.0 * a * x + b + c * y, c * x], [e * y + 2.0 * f * x, 2.0 * d * y + e * x]])
    };
    let moved = mesh.nodes.iter().enumerate().map(|(node, &place)| field(mesh.block_of(node), place).0);
    let mut displacement: Vec<[f64; 2]> = moved.collect();
    mesh.cells.iter().for_each(|cell| displacement[cell[4]] = [7.0, -5.0]);
    let structure = structure(mesh, &[]);
    let found = recovered(&structure, &displacement);
    assert_eq!(found.len(), 5 * (4 + 3 + 2));
    for (node, found) in found {
        let place = structure.mesh.nodes[node];
        let exact = stress(field(structure.mesh.block_of(node), place).1);
        for i in 0..3 {
            assert!((found[i] - exact[i]).abs() < 1e-10 * MODULUS * 1e-5, "{place:?}: {found:?}, {exact:?}");
        }
    }
}

/// A smooth displacement on nested meshes of the tapering section: the largest error of the recovered stress at nodes of the
/// outline is of second order.
#[test]
fn a_smooth_stress_is_of_second_order_on_the_outline_of_a_taper() {
    let k = 0.03;
    let field = |[x, y]: [f64; 2]| {
        let ([sx, cx], [sy, cy]) = ([(k * x).sin(), (k * x).cos()], [(k * y).sin(), (k * y).cos()]);
        ([sx * cy, cx * sy], [[k * cx * cy, -k * sx * sy], [-k * sx * sy, k * cx * cy]])
    };
    let section = Section::default();
    let worst = [1, 2, 4].map(|fine| {
        let count = 9 * fine;
        let row = |from: f64, to: f64, i: usize| from + (to - from) * i as f64 / count as f64;
        let rows: Vec<f64> =
            (0..count).map(|i| row(0.0, 66.5, i)).chain((0..=count).map(|i| row(66.5, 103.0, i))).collect();
        let structure = structure(Mesh::mapped(&section, &[rows], 4 * fine), &[]);
        let displacement: Vec<[f64; 2]> = structure.mesh.nodes.iter().map(|&place| field(place).0).collect();
        let off = recovered(&structure, &displacement).into_iter().map(|(node, found)| {
            let exact = stress(field(structure.mesh.nodes[node]).1);
            (0..3).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max)
        });
        off.fold(0.0, f64::max) / (k * MODULUS)
    });
    let orders = [(worst[0] / worst[1]).log2(), (worst[1] / worst[2]).log2()];
    println!("smooth field on a taper: largest error {:.1e} of the stress, orders {orders:.2?}", worst[2]);
    assert!(orders[1] > 1.8);
}

/// A cantilever pushed at its tip, solved on 4, 8, 16 cells over the depth: the stress at its face halfway up against
/// beam theory, which is exact there. Recovered, it is of second order; the mean of the triangles, a third of a cell inside
/// the face, of first.
#[test]
fn the_stress_at_the_face_of_a_cantilever_is_of_second_order() -> Result<(), DamError> {
    let (length, force) = (12.0, 1e3);
    let exact = bending_stress(force, length / 2.0, 1.0);
    let mut errors = Vec::new();
    for columns in [4, 8, 16] {
        let count = 12 * columns;
        let rows = (0..=count).map(|i| i as f64 / columns as f64).collect();
        let mesh = Mesh::mapped(&Section::rectangle(1.0, length), &[rows], columns);
        let (base, top) = (mesh.base.clone(), support::top(&mesh));
        let middle = mesh.upstream[count / 2];
        let structure = structure(mesh, &base);
        let mut load = structure.weight([0.0; 2]);
        for (&node, part) in top.iter().zip(structure.mesh.tributary_lengths(&top)) {
            load[node][0] = force * part;
        }
        let mut motion = structure.at_rest();
        SparseNewton::default().relax(&structure, &mut motion, &load)?;
        let error = at_node(&structure, &motion.displacement, middle).map(|found| found / exact - 1.0);
        println!(
            "cantilever, {columns} cells over the depth: recovered {:+.2e}, mean of the triangles {:+.2e}",
            error[0], error[1]
        );
        errors.push(error.map(f64::abs));
    }
    let order = |which: usize| (errors[1][which] / errors[2][which]).log2();
    println!("orders {:.2}, {:.2}", order(0), order(1));
    assert!(order(0) > 1.8 && order(1) < 1.2);
    Ok(())
}

/// The intact Koyna section under its weight, its water and half of its weight downstream: σ_yy at the upstream face where
/// the downstream face bends. The limit is extrapolated from the two finest meshes with the order found; the smooth part of the
/// error is of order two, that of the stress beside the clamped heel, r^{λ−1} with λ > 0.7, of order 2λ.
#[test]
fn the_stress_at_the_upstream_face_of_koyna() -> Result<(), DamError> {
    let mut found = Vec::new();
    for size in [5.0, 2.5, 1.25, 0.625] {
        let mesh = Mesh::new(&Section::default(), &[], &[91.75], size);
        let base = mesh.base.clone();
        let wet = mesh.upstream_nodes_to(91.75);
        let face = WetFace::new(wet.iter().map(|&node| mesh.nodes[node]).collect()).unwrap();
        let place = |&node: &usize| (mesh.nodes[node][1] - 66.5).abs() < 1e-6;
        let node = mesh.upstream.iter().copied().find(place).expect("a row at the bend");
        let structure = Structure::<Coulomb>::new(mesh, &koyna(size).material, Kinematics::Small, [], &base);
        let mut load = structure.weight([0.5 * 9.81, -9.81]);
        let pressure: Vec<f64> = face.points().iter().map(|point| 9810.0 * (91.75 - point[1])).collect();
        for (&node, force) in wet.iter().zip(face.nodal_forces(&pressure)) {
            (0..2).for_each(|d| load[node][d] += force[d]);
        }
        let mut motion = structure.at_rest();
        SparseNewton::default().relax(&structure, &mut motion, &load)?;
        found.push(at_node(&structure, &motion.displacement, node).map(|stress| stress / 1e6));
    }
    let steps: Vec<f64> = found.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    let ratio = steps[1] / steps[2];
    let limit = found[3][0] + steps[2] / (ratio - 1.0);
    for (size, [recovered, mean]) in [5.0, 2.5, 1.25, 0.625].into_iter().zip(&found) {
        println!(
            "{size} m: recovered {recovered:.4} MPa ({:+.1} %), mean of the triangles {mean:.4} MPa ({:+.1} %)",
            100.0 * (recovered / limit - 1.0),
            100.0 * (mean / limit - 1.0)
        );
    }
    println!("limit {limit:.4} MPa, order {:.2}", ratio.log2());
    assert!(ratio.log2() > 1.4);
    assert!(
        found[1..].iter().all(|[recovered, mean]| (recovered - limit).abs() < 0.5 * (mean - limit).abs())
    );
    Ok(())
}
