//! Decay of free vibration with each kind of damping, against closed forms.

use crate::support;

use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::modal::{self, DegreesOfFreedom};
use cofferdam_dam::{Dam, DamError, DamParameters, Damping, DampingFrequencies, Motion};
use std::f64::consts::{PI, TAU};

/// The intact dam, displaced in the shape of its second mode, and the frequency of this mode (rad/s).
fn bent(damping: Damping) -> Result<(Dam, Motion, f64), DamError> {
    let dam = Dam::new(DamParameters { cracks: vec![], damping, ..support::koyna(10.0) })?;
    let structure = dam.structure();
    let dofs = DegreesOfFreedom::free(structure);
    let factors = modal::factor(&modal::stiffness(structure, &dofs), dofs.count)?;
    let (frequencies, modes) = modal::natural_modes(&factors, &dofs.masses(structure), 2, 1e-12)?;
    let mut motion = structure.at_rest();
    for (node, dof) in dofs.nodes() {
        motion.displacement[node] = [modes[(dof, 1)], modes[(dof + 1, 1)]];
    }
    Ok((dam, motion, frequencies[1]))
}

/// Damping ratio from the energy that remains after whole periods, and the error of the damping work.
fn measured(dam: &Dam, mut motion: Motion, frequency: f64) -> (f64, f64) {
    let (structure, damping) = (dam.structure(), dam.damping_coefficients());
    let energy = |motion: &Motion| {
        let stored = structure.stored_energy(motion);
        stored.kinetic + stored.strain
    };
    let zero = vec![[0.0; 2]; motion.displacement.len()];
    structure.accelerate(damping, &mut motion, &zero);
    let before = energy(&motion);
    let periods = 3.0;
    let duration = periods * TAU / frequency;
    let steps = CentralDifference::covering(duration, 0.1 * support::critical(structure, damping).limit);
    let mut work = Work::default();
    let loads = LoadPath::constant(zero);
    steps.advance(structure, damping, &mut motion, &loads, &mut work);
    let after = energy(&motion);
    ((before / after).ln() / (2.0 * TAU * periods), (before - after) / work.damping - 1.0)
}

/// Rayleigh, mass and stiffness damping: `ξ = α/2ω + βω/2`, up to terms of second order in ξ in free decay.
/// Local damping: `ξ = ln((1 + κ)/(1 − κ))/2π` for one degree of freedom; a mode of many degrees of freedom
/// is damped slightly differently because it excites others.
#[test]
fn a_mode_decays_by_the_ratio_that_was_asked_for() -> Result<(), DamError> {
    let (_, _, second) = bent(Damping::None)?;
    let first = Dam::new(support::koyna(10.0))?.natural_frequencies(1)?[0];
    let local = 0.05 * PI;
    let at_second = second / first;
    let multiples = |low: f64| DampingFrequencies::MultiplesOfFirst([low, 6.0]);
    for (damping, expected, tolerance) in [
        (Damping::Mass { ratio: 0.05, frequencies: multiples(1.0) }, 0.05 / at_second, 5e-3),
        (Damping::Mass { ratio: 0.05, frequencies: multiples(at_second) }, 0.05, 5e-3),
        (Damping::Stiffness { ratio: 0.02, frequencies: multiples(1.0) }, 0.02 * at_second, 1e-2),
        (Damping::Rayleigh { ratio: 0.05, frequencies: multiples(at_second) }, 0.05, 5e-3),
        (Damping::Local { coefficient: local }, ((1.0 + local) / (1.0 - local)).ln() / TAU, 0.1),
    ] {
        let (dam, motion, frequency) = bent(damping)?;
        let (ratio, ledger) = measured(&dam, motion, frequency);
        println!(
            "{damping:?}: ratio {ratio:.5}, expected {expected:.5}; energy lost against the ledger {ledger:+.1e}"
        );
        assert!((ratio / expected - 1.0).abs() < tolerance && ledger.abs() < 2e-3);
    }
    Ok(())
}

/// The limit is divided by 1 + κ: just below it a motion with all frequencies decays.
#[test]
fn local_damping_shortens_the_time_step() -> Result<(), DamError> {
    for coefficient in [0.2, 0.8] {
        let (dam, mut motion, _) = bent(Damping::Local { coefficient })?;
        let (structure, damping) = (dam.structure(), dam.damping_coefficients());
        for (i, v) in motion.velocity.iter_mut().enumerate().filter(|(i, _)| !structure.is_fixed(*i)) {
            *v = [(7.0 * i as f64).sin(), (5.0 * i as f64).cos()];
        }
        motion.displacement.fill([0.0; 2]);
        let zero = vec![[0.0; 2]; motion.displacement.len()];
        let limit = support::critical(structure, damping).limit;
        let start = structure.kinetic_energy(&motion);
        structure.accelerate(damping, &mut motion, &zero);
        let steps = CentralDifference { time_step: 0.99 * limit, steps: 2000 };
        steps.advance(structure, damping, &mut motion, &LoadPath::constant(zero), &mut Work::default());
        let left = structure.kinetic_energy(&motion) / start;
        println!("κ = {coefficient}: kinetic energy after 2000 steps {left:.1e} of the first");
        assert!(left < 1e-2);
    }
    Ok(())
}
