//! Joint closure, and the periods of a bar and of a block on a joint, against closed forms.

use crate::support;

use cofferdam_dam::analytical::vibration::{bar_period, joint_period};
use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, DynamicRelaxation};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{DamError, DampingCoefficients, Kinematics, Mesh, Motion, Section, Structure};
use support::{GRAVITY, stiff};

/// Two blocks with matching meshes, 3 m wide, the lower one fixed.
fn pressed_blocks(young_modulus: f64, normal_stiffness: f64) -> Structure {
    let mesh = Mesh::mapped(&Section::rectangle(3.0, 2.0), &[vec![0.0, 1.0], vec![1.0, 2.0]], 3);
    let law = Coulomb { friction: 0.5, normal_stiffness, shear_stiffness: normal_stiffness / 2.0 };
    let fixed: Vec<usize> = mesh.blocks[0].nodes.clone().collect();
    Structure::new(mesh, &stiff(young_modulus), Kinematics::Corotational, [(law, Integration::Nodal)], &fixed)
}

/// Period, s: the time between every second change of sign of `value`.
fn period(
    structure: &Structure,
    motion: &mut Motion,
    forces: Vec<[f64; 2]>,
    value: impl Fn(&Motion) -> f64,
) -> f64 {
    let step = 0.1 * support::critical(structure, DampingCoefficients::NONE).limit;
    structure.accelerate(DampingCoefficients::NONE, motion, &forces);
    let loads = LoadPath::constant(forces);
    let (mut crossings, mut before) = (Vec::new(), value(motion));
    let mut time = 0.0;
    while crossings.len() < 3 {
        let one = CentralDifference { time_step: step, steps: 1 };
        one.advance(structure, DampingCoefficients::NONE, motion, &loads, &mut Work::default());
        let now = value(motion);
        if before * now < 0.0 {
            crossings.push(time + step * before / (before - now));
        }
        (before, time) = (now, time + step);
    }
    crossings[2] - crossings[0]
}

/// Closure under a uniform pressure on top is p/k_n at every node, up to the tolerance of the relaxation.
#[test]
fn joint_closes_by_pressure_over_stiffness() -> Result<(), DamError> {
    let structure = pressed_blocks(1e9, 1e8);
    let mut motion = structure.at_rest();
    let mut pressure = structure.weight([0.0; 2]);
    let top = &support::top(&structure.mesh);
    for (&node, length) in top.iter().zip(structure.mesh.tributary_lengths(top)) {
        pressure[node][1] = -2e4 * length;
    }
    DynamicRelaxation { tolerance: 1e-11, max_iterations: 10_000 }.relax(
        &structure,
        &mut motion,
        &pressure,
    )?;
    let errors = motion.joints[0].iter().map(|joint| (-joint.gap / (2e4 / 1e8) - 1.0).abs());
    let error = errors.fold(0.0, f64::max);
    println!("joint closure: relative error {error:.1e}");
    assert!(error < 1e-9);
    Ok(())
}

/// Tolerance: the block is 1e5 times stiffer than the joint; the effect of its deformation on the period is 1e-5/3.
#[test]
fn block_on_a_joint_has_the_period_of_its_mass() -> Result<(), DamError> {
    let structure = pressed_blocks(1e12, 1e7);
    let mut motion = structure.at_rest();
    let weight = structure.weight([0.0, -GRAVITY]);
    DynamicRelaxation::default().relax(&structure, &mut motion, &weight)?;
    let rest = support::mean(&structure, &motion.displacement, 1)[1];
    for node in structure.mesh.blocks[1].nodes.clone() {
        motion.velocity[node] = [0.0, 0.05];
    }
    let height = |motion: &Motion| support::mean(&structure, &motion.displacement, 1)[1] - rest;
    let measured = period(&structure, &mut motion, weight, height);
    let error = measured / joint_period(2500.0 * 3.0, 1e7, 3.0) - 1.0;
    println!("contact period: relative error {error:.1e}");
    assert!(error.abs() < 1e-4);
    Ok(())
}

/// Tolerance: dispersion (π/80)²/24 ≈ 6e-5 with 40 elements in a quarter of the wavelength.
#[test]
fn bar_swings_in_four_lengths_over_the_wave_speed() {
    let rows: Vec<f64> = (0..=40).map(|i| f64::from(i) / 4.0).collect();
    let mesh = Mesh::mapped(&Section::rectangle(0.5, 10.0), &[rows], 2);
    let (base, top) = (mesh.base.clone(), support::top(&mesh)[1]);
    let structure = Structure::<Coulomb>::new(mesh, &stiff(31e9), Kinematics::Corotational, [], &base);
    let mut motion = structure.at_rest();
    for (u, [_, y]) in motion.displacement.iter_mut().zip(&structure.mesh.nodes) {
        u[1] = 1e-5 * (std::f64::consts::PI * y / 20.0).sin();
    }
    let still = structure.weight([0.0; 2]);
    let measured = period(&structure, &mut motion, still, |motion| motion.displacement[top][1]);
    let error = measured / bar_period(10.0, 31e9, 2500.0) - 1.0;
    println!("bar period 4L/c: relative error {error:.1e}");
    assert!(error.abs() < 3e-4);
}
