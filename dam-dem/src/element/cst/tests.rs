//! Forces against energy, triangles one by one, other orders, widths of registers and numbers of threads.

use pulp::WithSimd;

use super::*;
use crate::{Plane, Section};

fn cell(kinematics: Kinematics) -> (Mesh, CrossedCells) {
    let mut mesh = Mesh::mapped(&Section::rectangle(2.0, 1.0), &[vec![0.0, 1.0]], 1);
    mesh.nodes[4] = [0.9, 0.6];
    let material = Material { young_modulus: 3.0, density: 1.0, ..Default::default() };
    let cells = CrossedCells::new(&mesh, &Materials::from(&material), kinematics);
    (mesh, cells)
}

#[test]
fn forces_are_the_gradient_of_the_strain_energy() {
    for kinematics in [Kinematics::Small, Kinematics::Corotational] {
        let (_, cells) = cell(kinematics);
        let u = [[0.1, -0.2], [0.3, 0.1], [-0.2, 0.3], [0.0, 0.2], [0.1, 0.0]];
        let mut forces = [[0.0; 2]; 5];
        cells.add_forces(&u, &u, 0.0, &mut [], &mut forces);
        for (node, d) in (0..5).flat_map(|n| [(n, 0), (n, 1)]) {
            let energy = |shift: f64| {
                let mut moved = u;
                moved[node][d] += shift;
                cells.strain_energy(&moved)
            };
            let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
            assert!((forces[node][d] + slope).abs() < 1e-9, "{kinematics:?} {node} {d}");
        }
    }
}

/// Numbers of columns of a wall in 13 rows: batches of cells above each other, the last one partly filled; of a row with a
/// lane left; of a row, and of two rows.
const COLUMNS: [usize; 3] = [1, 7, 19];

fn wall(kinematics: Kinematics, columns: usize) -> (Mesh, CrossedCells, [Vec<[f64; 2]>; 2]) {
    let rows: Vec<f64> = (0..=13).map(f64::from).collect();
    let mut mesh = Mesh::mapped(&Section::rectangle(1.2 * columns as f64, 13.0), &[rows], columns);
    for (i, [x, y]) in mesh.nodes.iter_mut().enumerate() {
        *x += 0.2 * (7.0 * i as f64).sin();
        *y += 0.2 * (5.0 * i as f64).cos();
    }
    let material = Material { young_modulus: 3.0, density: 1.0, ..Default::default() };
    let cells = CrossedCells::new(&mesh, &Materials::from(&material), kinematics);
    let field = |scale: f64, shift: f64| {
        let of = |i: usize| [scale * (3.0 * i as f64 + shift).sin(), scale * (2.0 * i as f64 + shift).cos()];
        (0..mesh.nodes.len()).map(of).collect()
    };
    let fields = [field(0.2, 0.0), field(1.0, 1.0)];
    (mesh, cells, fields)
}

/// Reference: a loop over triangles, with the rotation from an angle and the strain from `RᵀF − I`.
#[test]
fn forces_are_those_of_a_loop_over_triangles() {
    let both = [Kinematics::Small, Kinematics::Corotational];
    for (kinematics, columns) in both.into_iter().flat_map(|one| COLUMNS.map(|columns| (one, columns))) {
        let (mesh, cells, [u, v]) = wall(kinematics, columns);
        let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
        let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
        let mut viscous = cells.viscous_at_rest();
        let power = [0, 1].map(|_| {
            forces.fill([0.0; 2]);
            cells.add_forces(&u, &v, damping, &mut viscous, &mut forces)
        });
        let mut powers = [0.0; 2];
        let mut size = 0.0f64;
        for (nodes, area, gradients) in cells.triangles() {
            let gradient = |field: &[[f64; 2]]| {
                [0, 1].map(|p| {
                    [0, 1].map(|q| (0..3).map(|i| field[nodes[i]][p] * gradients[i][q]).sum::<f64>())
                })
            };
            let ([[a, b], [c, d]], rate) = (gradient(&u), gradient(&v));
            let angle = if kinematics == Kinematics::Small { 0.0 } else { (c - b).atan2(2.0 + a + d) };
            let (sin, cos) = angle.sin_cos();
            let turned = |[[a, b], [c, d]]: [[f64; 2]; 2]| {
                let t = [[cos * a + sin * c, cos * b + sin * d], [cos * c - sin * a, cos * d - sin * b]];
                [t[0][0], t[1][1], (t[0][1] + t[1][0]) / 2.0]
            };
            let [s11, s22, s12] = turned([[1.0 + a, b], [c, 1.0 + d]]);
            let (strain, rate) = ([s11 - 1.0, s22 - 1.0, s12], turned(rate));
            let Moduli { lambda, twice_shear: shear } = cells.moduli.of_cell((0, 0));
            let stress = |e: [f64; 3]| {
                [lambda * (e[0] + e[1]) + shear * e[0], lambda * (e[0] + e[1]) + shear * e[1], shear * e[2]]
            };
            let full = stress(rate).map(|s| 0.3 * s);
            let [first, second] = [0.4, 0.4 + 0.6 * 0.4].map(|share| full.map(|s| share * s));
            let dot = |s: [f64; 3]| area * (s[0] * rate[0] + s[1] * rate[1] + 2.0 * s[2] * rate[2]);
            powers[0] += dot(first) / 2.0;
            powers[1] += (dot(first) + dot(second)) / 2.0;
            let elastic = stress(strain);
            let [t11, t22, t12] = [0, 1, 2].map(|i| area * (elastic[i] + second[i]));
            let piola = [
                [cos * t11 - sin * t12, cos * t12 - sin * t22],
                [sin * t11 + cos * t12, sin * t12 + cos * t22],
            ];
            for (&node, g) in nodes.iter().zip(gradients) {
                for d in 0..2 {
                    let force = piola[d][0] * g[0] + piola[d][1] * g[1];
                    forces[node][d] += force;
                    size = size.max(force.abs());
                }
            }
        }
        let error = forces.iter().flatten().fold(0.0f64, |a, f| a.max(f.abs())) / size;
        println!(
            "{kinematics:?}, {columns} columns: forces of the batches against triangles {error:.1e} of the largest"
        );
        assert!(error < 1e-13);
        for (a, b) in power.iter().zip(powers) {
            assert!((a / b - 1.0).abs() < 1e-13, "power {a}, of triangles {b}");
        }
    }
}

/// Forces, powers and energy of two evaluations, in bits.
fn bits<const COROTATIONAL: bool, const DAMPED: bool>(scalar: bool, columns: usize) -> Vec<u64> {
    let (mesh, cells, [u, v]) = wall(Kinematics::Small, columns);
    let mut viscous = cells.viscous_at_rest();
    let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
    for _ in 0..2 {
        let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
        let evaluation = Evaluation::<COROTATIONAL, DAMPED> {
            moduli: cells.moduli.of(0..cells.batches.len()),
            of: Deformation { displacement: &u, velocity: &v, damping },
            batches: &cells.batches,
            viscous: &mut viscous,
            forces: &mut forces,
            first_node: 0,
        };
        let (moduli, batches) = (cells.moduli.of(0..cells.batches.len()), &cells.batches[..]);
        let energy = Energy::<COROTATIONAL> { moduli, batches, displacement: &u };
        let sums = match scalar {
            true => [evaluation.with_simd(pulp::Scalar::new()), energy.with_simd(pulp::Scalar::new())],
            false => [Arch::new().dispatch(evaluation), Arch::new().dispatch(energy)],
        };
        forces.push(sums);
    }
    forces.into_iter().flatten().map(f64::to_bits).collect()
}

/// The widest registers of this processor give the same bits as scalar arithmetic.
#[test]
fn the_bits_do_not_depend_on_the_processor() {
    for columns in COLUMNS {
        assert_eq!(bits::<true, true>(false, columns), bits::<true, true>(true, columns));
        assert_eq!(bits::<true, false>(false, columns), bits::<true, false>(true, columns));
        assert_eq!(bits::<false, true>(false, columns), bits::<false, true>(true, columns));
        assert_eq!(bits::<false, false>(false, columns), bits::<false, false>(true, columns));
    }
}

/// Twin: the same wall with its nodes in another order, so that no cells are a row.
#[test]
fn rows_have_the_forces_of_cells_in_any_order() {
    for columns in COLUMNS {
        let (mesh, cells, [u, v]) = wall(Kinematics::Corotational, columns);
        let count = mesh.nodes.len();
        let turned = |field: &[[f64; 2]]| field.iter().rev().copied().collect::<Vec<_>>();
        let mut shuffled = mesh.clone();
        shuffled.nodes = turned(&mesh.nodes);
        shuffled.cells.iter_mut().flatten().for_each(|node| *node = count - 1 - *node);
        let material = Material { young_modulus: 3.0, density: 1.0, ..Default::default() };
        let general = CrossedCells::new(&shuffled, &Materials::from(&material), Kinematics::Corotational);
        let in_rows = |cells: &CrossedCells| cells.batches.iter().filter(|batch| batch.is_row()).count();
        println!("{columns} columns: {} of {} batches are rows", in_rows(&cells), cells.batches.len());
        assert!(in_rows(&general) == 0 && (columns == 1 || in_rows(&cells) >= 12));
        let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
        let of = |cells: &CrossedCells, u: &[[f64; 2]], v: &[[f64; 2]]| {
            let (mut viscous, mut forces) = (cells.viscous_at_rest(), vec![[0.0; 2]; count]);
            let power = [0, 1].map(|_| cells.add_forces(u, v, damping, &mut viscous, &mut forces));
            (forces, power, cells.strain_energy(u))
        };
        let (forces, power, energy) = of(&cells, &u, &v);
        let (others, other_power, other_energy) = of(&general, &turned(&u), &turned(&v));
        let largest = forces.iter().flatten().fold(0.0f64, |most, f| most.max(f.abs()));
        for (a, b) in forces.iter().flatten().zip(turned(&others).iter().flatten()) {
            assert!((a - b).abs() < 1e-14 * largest);
        }
        assert!(power.iter().zip(other_power).all(|(a, b)| (a / b - 1.0).abs() < 1e-13));
        assert!((energy / other_energy - 1.0).abs() < 1e-13);
    }
}

/// What is not a number at one node stays with the triangles of this node, though lanes without a cell read others.
#[test]
fn lanes_without_a_cell_touch_no_node() {
    let (mesh, cells, [u, v]) = wall(Kinematics::Corotational, 7);
    for node in 0..mesh.nodes.len() {
        let mut broken = u.clone();
        broken[node] = [f64::NAN; 2];
        let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
        cells.add_forces(&broken, &v, 0.0, &mut cells.viscous_at_rest(), &mut forces);
        let mut near: Vec<usize> =
            mesh.triangles().filter(|corners| corners.contains(&node)).flatten().collect();
        near.sort_unstable();
        near.dedup();
        let touched = (0..forces.len()).filter(|&i| forces[i].iter().any(|f| f.is_nan()));
        assert!(touched.eq(near), "node {node}");
    }
}

/// `f_i = −A σ R ∇N_i`, and the stress of a strained triangle rotates with it.
#[test]
fn stresses_are_those_of_the_forces_and_turn_with_the_triangle() {
    for kinematics in [Kinematics::Small, Kinematics::Corotational] {
        let (mesh, cells) = cell(kinematics);
        let u = [[0.1, -0.2], [0.3, 0.1], [-0.2, 0.3], [0.0, 0.2], [0.1, 0.0]];
        let (mut forces, mut of_stress) = (vec![[0.0; 2]; 5], vec![[0.0; 2]; 5]);
        cells.add_forces(&u, &u, 0.0, &mut [], &mut forces);
        for (triangle, (nodes, area, gradients)) in cells.triangles().enumerate() {
            let displaced = nodes.map(|node| u[node]);
            let [s, t, r] = cells.stress(triangle, displaced, kinematics);
            let turn = |angle: f64| [[angle.cos(), -angle.sin()], [angle.sin(), angle.cos()]];
            let mut h = [[0.0; 2]; 2];
            for (u, g) in displaced.iter().zip(gradients) {
                (0..4).for_each(|i| h[i / 2][i % 2] += u[i / 2] * g[i % 2]);
            }
            let angle = match kinematics {
                Kinematics::Small => 0.0,
                Kinematics::Corotational => (h[1][0] - h[0][1]).atan2(2.0 + h[0][0] + h[1][1]),
            };
            let own = turn(angle);
            for (&node, g) in nodes.iter().zip(gradients) {
                let g = [0, 1].map(|i| own[i][0] * g[0] + own[i][1] * g[1]);
                of_stress[node][0] -= area * (s * g[0] + r * g[1]);
                of_stress[node][1] -= area * (r * g[0] + t * g[1]);
            }
            if kinematics == Kinematics::Corotational {
                let q = turn(2.0);
                let turned = nodes.map(|node| {
                    let x = [0, 1].map(|d| mesh.nodes[node][d] + u[node][d]);
                    [0, 1].map(|d| q[d][0] * x[0] + q[d][1] * x[1] - mesh.nodes[node][d])
                });
                let [s2, t2, r2] = cells.stress(triangle, turned, kinematics);
                let along =
                    |a: [f64; 2], b: [f64; 2]| a[0] * (s * b[0] + r * b[1]) + a[1] * (r * b[0] + t * b[1]);
                let errors = [s2 - along(q[0], q[0]), t2 - along(q[1], q[1]), r2 - along(q[0], q[1])];
                assert!(errors.iter().all(|e| e.abs() < 1e-13), "{errors:?}");
            }
        }
        for (a, b) in forces.iter().flatten().zip(of_stress.iter().flatten()) {
            assert!((a - b).abs() < 1e-13, "{kinematics:?}: {a}, {b}");
        }
    }
}

/// Forces and damping of a large mesh on different numbers of threads.
#[test]
fn the_bits_do_not_depend_on_the_threads() -> Result<(), DamError> {
    let mesh = Mesh::new(&Section::rectangle(60.0, 100.0), &[31.0], &[], 0.45);
    let material = Material { young_modulus: 3.0, density: 1.0, plane: Plane::Strain, ..Default::default() };
    let field = |shift: f64| -> Vec<[f64; 2]> {
        mesh.nodes.iter().map(|[x, y]| [(x + shift).sin() * 1e-2, (y * x + shift).cos() * 1e-2]).collect()
    };
    let (u, v) = (field(0.0), field(1.0));
    let mut results = Vec::new();
    for threads in [1, 2, 3] {
        let threads = NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN);
        let cells = CrossedCells::new(&mesh, &Materials::from(&material), Kinematics::Corotational)
            .on_threads(threads)?;
        assert!(cells.triangle_count() > 100_000 && cells.parts.parts.len() > 8);
        let mut viscous = cells.viscous_at_rest();
        let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
        let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
        let powers = [0, 1].map(|_| cells.add_forces(&u, &v, damping, &mut viscous, &mut forces));
        // reference: all batches in sequence
        let mut plain = vec![[0.0; 2]; mesh.nodes.len()];
        cells.add_forces(&u, &v, 0.0, &mut [], &mut plain);
        let mut serial = vec![[0.0; 2]; mesh.nodes.len()];
        Arch::new().dispatch(Evaluation::<true, false> {
            moduli: cells.moduli.of(0..cells.batches.len()),
            of: Deformation { displacement: &u, velocity: &v, damping: 0.0.into() },
            batches: &cells.batches,
            viscous: &mut [],
            forces: &mut serial,
            first_node: 0,
        });
        let largest = serial.iter().flatten().fold(0.0f64, |most, f| most.max(f.abs()));
        let apart = serial.iter().flatten().zip(plain.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-14 * largest, "parts and seams are all batches");
        results.push((powers.map(f64::to_bits), forces));
    }
    assert!(results.iter().all(|result| result.0 == results[0].0 && result.1 == results[0].1));
    Ok(())
}

#[test]
fn damping_power_is_that_of_its_forces() {
    let (_, cells) = cell(Kinematics::Corotational);
    let u = [[0.1, -0.2], [0.3, 0.1], [-0.2, 0.3], [0.0, 0.2], [0.1, 0.0]];
    let v = [[1.0, 0.3], [-0.4, 0.2], [0.1, 0.7], [0.5, -0.6], [0.3, 0.3]];
    let (mut with, mut without) = ([[0.0; 2]; 5], [[0.0; 2]; 5]);
    let mut viscous = [ViscousStress::default()];
    cells.add_forces(&u, &v, 0.3, &mut viscous, &mut [[0.0; 2]; 5]);
    let power = cells.add_forces(&u, &v, 0.3, &mut viscous, &mut with);
    cells.add_forces(&u, &v, 0.0, &mut [], &mut without);
    let of_forces: f64 =
        (0..5).map(|n| (0..2).map(|d| (without[n][d] - with[n][d]) * v[n][d]).sum::<f64>()).sum();
    assert!(power > 0.0 && (power - of_forces).abs() < 1e-13 * power);
}

#[test]
fn stiffness_blocks_are_those_of_the_linear_forces() {
    let (mesh, cells) = cell(Kinematics::Small);
    let u: Vec<[f64; 2]> = mesh.nodes.iter().map(|&[x, y]| [x * y, y - x * x]).collect();
    let mut forces = vec![[0.0; 2]; 5];
    cells.add_linear_forces(&u, &mut forces);
    for (triangle, (nodes, area, gradients)) in cells.triangles().enumerate() {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let block = cells.stiffness_block(triangle, gradients[i], gradients[j]);
            for p in 0..2 {
                forces[nodes[i]][p] += area * (block[p][0] * u[nodes[j]][0] + block[p][1] * u[nodes[j]][1]);
            }
        }
    }
    assert!(forces.iter().flatten().all(|f| f.abs() < 1e-14));
}
