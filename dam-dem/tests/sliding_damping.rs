//! Mass damping does not resist blocks that slide or rock, and damps a dam with closed cracks as asked.

use crate::support;

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, SparseNewton};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::modal::{self, DegreesOfFreedom};
use cofferdam_dam::{Dam, DamError, DamParameters, DampingCoefficients, Fidelity, RayleighCoefficients};
use cofferdam_unit::variables::dam as variable;
use std::f64::consts::TAU;

const ALPHA: f64 = 2.0;

/// A stiff block is pushed with 0.5 g along a crack with μ = 0.3. Its speed grows as by Coulomb's friction alone, or with
/// C = αM as by a drag beside it.
#[test]
fn a_pushed_block_slides_without_drag() {
    let law = Coulomb { friction: 0.3, normal_stiffness: 2e10, shear_stiffness: 2e10 };
    let structure = support::block_on_ground([2.0, 1.0], 1e11, law, Integration::Nodal);
    let rate = 0.2 * support::GRAVITY;
    let dragged = |speed: f64| rate / ALPHA + (speed - rate / ALPHA) * (-0.5 * ALPHA).exp();
    for drags_blocks in [false, true] {
        let damping = DampingCoefficients {
            rayleigh: RayleighCoefficients { mass: ALPHA, stiffness: 1e-5 },
            drags_blocks,
            ..DampingCoefficients::NONE
        };
        let mut motion = structure.at_rest();
        let weight = structure.weight([0.0, -support::GRAVITY]);
        SparseNewton::default().relax(&structure, &mut motion, &weight).expect("a block at rest");
        let [from, speed] = [0, 1].map(|_| {
            let push = [0.5 * support::GRAVITY, -support::GRAVITY];
            support::run(&structure, damping, &mut motion, push, 0.5);
            support::mean(&structure, &motion.velocity, 1)[0]
        });
        let expected = if drags_blocks { dragged(from) } else { from + 0.5 * rate };
        println!(
            "drag {drags_blocks}: {from:.5} m/s, half a second later {speed:.5}, expected {expected:.5}"
        );
        assert!((speed / expected - 1.0).abs() < 1e-4);
    }
}

/// The cracked dam at rest under its weight gets a small velocity in the shape of its first or second mode. The modal
/// energy after three periods shows the ratio that was asked for. Tolerance: 2 %.
#[test]
fn closed_cracks_keep_the_ratio() -> Result<(), DamError> {
    let dam = Dam::new(support::koyna(10.0))?;
    let (structure, loads) = (dam.structure(), dam.structure().weight([0.0, -9.81]));
    let mut rest = structure.at_rest();
    SparseNewton::default().relax(structure, &mut rest, &loads)?;
    let dofs = DegreesOfFreedom::free(structure);
    let factors = modal::factor(&modal::stiffness(structure, &dofs), dofs.count)?;
    let (frequencies, modes) = modal::natural_modes(&factors, &dofs.masses(structure), 2, 1e-12)?;
    let rayleigh = RayleighCoefficients::through(0.05, [frequencies[0], frequencies[1]]);
    let damping = DampingCoefficients::from(rayleigh);
    for (mode, &frequency) in frequencies.iter().enumerate() {
        let shape = |dof: usize| modes[(dof, mode)];
        let mut motion = rest.clone();
        structure.accelerate(damping, &mut motion, &loads);
        dofs.nodes().for_each(|(node, dof)| motion.velocity[node] = [0, 1].map(|d| 1e-3 * shape(dof + d)));
        let periods = 3.0;
        let duration = periods * TAU / frequency;
        let steps = CentralDifference::covering(duration, 0.5 * support::critical(structure, damping).limit);
        let path = LoadPath::constant(loads.clone());
        steps.advance(structure, damping, &mut motion, &path, &mut Work::default());
        let [mut coordinate, mut rate] = [0.0; 2];
        for (node, dof) in dofs.nodes() {
            for d in 0..2 {
                let momentum = structure.mass[node] * shape(dof + d);
                coordinate += momentum * (motion.displacement[node][d] - rest.displacement[node][d]);
                rate += momentum * motion.velocity[node][d];
            }
        }
        let left = (rate.powi(2) + (frequency * coordinate).powi(2)).sqrt() / 1e-3;
        let ratio = -left.ln() / (periods * TAU);
        println!("mode {}: ratio {ratio:.5} instead of 0.05", mode + 1);
        assert!((ratio / 0.05 - 1.0).abs() < 0.02);
    }
    Ok(())
}

/// As long as the cracks stay closed, both forms of mass damping are the same; when they slide, they differ. Full and
/// reduced dam, with and without added mass.
#[test]
fn the_forms_differ_only_when_a_crack_parts() -> Result<(), DamError> {
    let reduced = |dam: DamParameters| DamParameters { fidelity: Fidelity::Reduced { modes: None }, ..dam };
    let dry = || support::koyna(10.0);
    for parameters in [dry(), support::with_water(dry()), reduced(dry()), reduced(support::with_water(dry()))]
    {
        for (scale, differs) in [(0.02, false), (1.0, true)] {
            let end = |drags_blocks: bool| -> Result<Vec<f64>, DamError> {
                let mut dam = support::at_rest(DamParameters { drags_blocks, ..parameters.clone() })?;
                support::shake(&mut dam, 2.5e-3, 2.0, |t| scale * support::bursts(t))?;
                let sliding = support::get(&dam, &variable::CRACK_SLIDING);
                Ok([support::get(&dam, &variable::CREST_DISPLACEMENT), sliding].concat())
            };
            let (free, dragged) = (end(false)?, end(true)?);
            println!("{:?}, bursts × {scale}: {free:.5?}, with drag {dragged:.5?} m", parameters.fidelity);
            assert_eq!(free != dragged, differs);
        }
    }
    Ok(())
}
