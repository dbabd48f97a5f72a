//! Patch test and rigid rotation of the triangles, on an irregular mesh.

use crate::support;

use cofferdam_dam::contact::Coulomb;
use cofferdam_dam::{Kinematics, Mesh, Section, Structure};

/// 4 × 3 cells with irregular inner nodes.
fn irregular(kinematics: Kinematics) -> Structure {
    let rows: Vec<f64> = (0..=3).map(f64::from).collect();
    let mut mesh = Mesh::mapped(&Section::rectangle(4.0, 3.0), &[rows], 4);
    for (i, [x, y]) in mesh.nodes.iter_mut().enumerate() {
        if *x > 0.0 && *x < 4.0 && *y > 0.0 && *y < 3.0 {
            *x += 0.2 * (7.0 * i as f64).sin();
            *y += 0.2 * (5.0 * i as f64).cos();
        }
    }
    let material = cofferdam_dam::Material { poisson_ratio: 0.2, ..support::stiff(31e9) };
    Structure::<Coulomb>::new(mesh, &material, kinematics, [], &[])
}

/// Largest force at inner nodes and at all nodes, and the strain energy, under the displacement `u`.
fn under(structure: &Structure, u: impl Fn([f64; 2]) -> [f64; 2]) -> (f64, f64, f64) {
    let mut motion = structure.at_rest();
    motion.displacement = structure.mesh.nodes.iter().map(|x| u(*x)).collect();
    let mut forces = vec![[0.0; 2]; motion.displacement.len()];
    structure.add_internal_forces(&mut motion, 0.0, &mut forces);
    let (mut inner, mut all) = (0.0f64, 0.0f64);
    for (force, [x, y]) in forces.iter().zip(&structure.mesh.nodes) {
        let size = force[0].hypot(force[1]);
        all = all.max(size);
        if *x > 0.0 && *x < 4.0 && *y > 0.0 && *y < 3.0 {
            inner = inner.max(size);
        }
    }
    (inner, all, structure.strain_energy(&motion))
}

/// Under a uniform strain the forces on inner nodes are 0 and the energy is A/2 ε:D:ε, also after a rotation.
/// Tolerance: rounding; after a rotation that of the displacements, 1e-16 of some metres over the strain of 1e-3.
#[test]
fn uniform_strain_is_reproduced() {
    let (e11, e22, e12) = (1e-3, -0.4e-3, 0.7e-3);
    let (lambda, shear) = (31e9 * 0.2 / 0.96, 31e9 / 2.4);
    let exact = 12.0 / 2.0
        * (lambda * (e11 + e22) * (e11 + e22) + 2.0 * shear * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12));
    let stretch = |[x, y]: [f64; 2]| [e11 * x + e12 * y, e12 * x + e22 * y];
    let (s, c) = 0.5f64.sin_cos();
    let turn = |[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y];
    let small = under(&irregular(Kinematics::Small), stretch);
    let turned = under(&irregular(Kinematics::Corotational), |x| {
        let (stretched, turned) = (turn(stretch(x)), turn(x));
        [0, 1].map(|d| stretched[d] + (turned[d] - x[d]))
    });
    let cases = [("small", small, 1e-12), ("corotational, turned", turned, 1e-11)];
    for (name, (inner, all, energy), tolerance) in cases {
        println!("patch test, {name}: inner force {:.1e}, energy {:.1e}", inner / all, energy / exact - 1.0);
        assert!(inner < tolerance * all && (energy / exact - 1.0).abs() < tolerance);
    }
}

/// A rotation by 30° causes no force, compared with the forces that the linear element would give.
#[test]
fn rigid_rotation_gives_no_force() {
    let (s, c) = 30f64.to_radians().sin_cos();
    let turn = |[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y];
    let moved = |x| {
        let turned = turn(x);
        [turned[0] - x[0], turned[1] - x[1]]
    };
    let (_, corotational, _) = under(&irregular(Kinematics::Corotational), moved);
    let (_, linear, _) = under(&irregular(Kinematics::Small), moved);
    println!("rigid rotation by 30°: force {:.1e} of the linear element's", corotational / linear);
    assert!(corotational < 1e-12 * linear);
}
