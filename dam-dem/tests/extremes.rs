//! Extreme cases, far from any dam: the solution is bounded, energy is conserved, and known solutions are met.

use crate::support;

use cofferdam_dam::contact::{ContactStatus, Coulomb, Integration};
use cofferdam_dam::integrator::DynamicRelaxation;
use cofferdam_dam::{
    CrackParameters, DamError, DamParameters, DampingCoefficients, Kinematics, Mesh, Section, Structure,
};
use cofferdam_unit::variables::dam as variable;
use support::{GRAVITY, mean, stiff};

const LAW: Coulomb = Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 1e9 };

/// A block thrown from a metre above the ground: central differences are exact for parabolas, and the block
/// neither rotates nor deforms.
#[test]
fn a_block_flies_as_it_should() {
    let structure = support::block_on_ground([3.0, 0.6], 1e9, LAW, Integration::Nodal);
    for gravity in [0.0, GRAVITY] {
        let mut motion = structure.at_rest();
        let (velocity, duration) = ([1.5, 2.0], 0.3);
        for n in structure.mesh.blocks[1].nodes.clone() {
            (motion.displacement[n], motion.velocity[n]) = ([0.0, 1.0], velocity);
        }
        support::run(&structure, DampingCoefficients::NONE, &mut motion, [0.0, -gravity], duration);
        let exact =
            [velocity[0] * duration, 1.0 + velocity[1] * duration - 0.5 * gravity * duration * duration];
        let off = structure.mesh.blocks[1].nodes.clone().fold(0.0f64, |worst, n| {
            let u = motion.displacement[n];
            worst.max((u[0] - exact[0]).abs()).max((u[1] - exact[1]).abs())
        });
        println!("free flight, g = {gravity}: {off:.1e} m off the parabola");
        assert!(off < 1e-11);
    }
}

/// Without friction a block accelerates freely under the push; with very high friction it does not move.
#[test]
fn no_friction_and_all_of_it() -> Result<(), DamError> {
    for (friction, push) in [(0.0, 3.0), (1e6, 0.5 * GRAVITY)] {
        let structure =
            support::block_on_ground([3.0, 0.6], 1e9, Coulomb { friction, ..LAW }, Integration::Nodal);
        // the state of rest is computed with friction, because without it the solution does not converge; it
        // is the same
        let resting = support::block_on_ground([3.0, 0.6], 1e9, LAW, Integration::Nodal);
        let mut motion = structure.at_rest();
        let weight = structure.weight([0.0, -GRAVITY]);
        DynamicRelaxation::default().relax(&resting, &mut motion, &weight)?;
        let rest = mean(&structure, &motion.displacement, 1)[0];
        support::run(&structure, DampingCoefficients::NONE, &mut motion, [push, -GRAVITY], 0.5);
        let moved = mean(&structure, &motion.displacement, 1)[0] - rest;
        let slipping = motion.joints[0].iter().filter(|j| j.status == ContactStatus::Slipping).count();
        println!("friction {friction:e}: moved by {moved:.4e} m, {slipping} contacts slip");
        if friction == 0.0 {
            assert!((moved / (0.5 * push * 0.25) - 1.0).abs() < 1e-6);
        } else {
            // shear springs and block deform by a few times weight over stiffness
            assert!(slipping == 0 && moved.abs() < 1e-3);
        }
    }
    Ok(())
}

/// The cracked dam with soft to stiff joints, and with ten times the bursts: the motion is bounded, and the
/// energy balance closes within 1 % of the peak.
#[test]
fn joints_of_any_stiffness_and_strong_motion() -> Result<(), DamError> {
    for (stiffness, factor) in [(1e8, 1.0), (1e11, 10.0), (1e13, 1.0)] {
        let crack = CrackParameters {
            normal_stiffness: stiffness,
            shear_stiffness: stiffness / 2.0,
            ..support::crack_at(66.5)
        };
        let mut dam = support::at_rest(DamParameters { cracks: vec![crack], ..support::koyna(12.0) })?;
        let mut peak: f64 = 0.0;
        for tenth in 1..=12 {
            support::shake(&mut dam, 0.0025, 0.1 * f64::from(tenth), |t| factor * support::bursts(t))?;
            peak = peak.max(support::get(&dam, &variable::KINETIC_ENERGY)[0]);
        }
        let error = support::get(&dam, &variable::ENERGY_BALANCE_ERROR)[0].abs() / peak;
        let sliding = support::get(&dam, &variable::CRACK_SLIDING)[0];
        println!(
            "k_n = {stiffness:e} Pa/m, bursts × {factor}: sliding {:.1} mm, energy error {error:.1e} of the peak, {} time steps",
            1e3 * sliding,
            dam.time_steps_per(0.0025)
        );
        assert!(sliding.is_finite() && sliding.abs() < 5.0 && error < 1e-2);
    }
    Ok(())
}

/// A row of cells of 0.1 m between rows of 10 m: the parameters of a dam that lead to it are refused, and a
/// mesh made with it on purpose is stable.
#[test]
fn thin_rows() {
    let cracks = vec![support::crack_at(60.0), support::crack_at(60.1)];
    let refused = cofferdam_dam::Dam::new(DamParameters { cracks, ..support::koyna(10.0) }).map(|_| ());
    assert!(matches!(refused, Err(DamError::ThinRow { .. })), "{refused:?}");
    let rows = vec![vec![0.0, 10.0, 20.0, 20.1, 30.1, 40.1]];
    let mesh = Mesh::mapped(&Section::rectangle(20.0, 40.1), &rows, 2);
    let base = mesh.base.clone();
    let structure = Structure::<Coulomb>::new(mesh, &stiff(31e9), Kinematics::Small, [], &base);
    let mut motion = structure.at_rest();
    for (v, [_, y]) in motion.velocity.iter_mut().zip(&structure.mesh.nodes) {
        v[0] = 0.01 * y / 40.0;
    }
    let begun = structure.kinetic_energy(&motion);
    support::run(&structure, DampingCoefficients::NONE, &mut motion, [0.0; 2], 2.0);
    let held = structure.kinetic_energy(&motion) + structure.strain_energy(&motion);
    println!("0.1 m beside 10 m: energy after 2 s {:.1e} off", held / begun - 1.0);
    assert!((held / begun - 1.0).abs() < 1e-2);
}
