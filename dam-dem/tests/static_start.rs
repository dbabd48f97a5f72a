//! Static equilibrium before time 0.

use crate::support;

use cofferdam_dam::integrator::{DynamicRelaxation, Relaxed, SparseNewton};
use cofferdam_dam::{CrackParameters, Dam, DamError, DamParameters, Motion};
use cofferdam_unit::variables::dam as variable;

/// Reactions at the base equal weight and water; the tolerance is that of the relaxation, 1e-9.
#[test]
fn reactions_carry_weight_and_water() -> Result<(), DamError> {
    for size in [10.0, 5.0] {
        let dam = support::at_rest(support::koyna(size))?;
        let structure = dam.structure();
        let mut motion = dam.state().motion().of_nodes().unwrap().clone();
        let mut forces = vec![[0.0; 2]; dam.node_count()];
        structure.add_internal_forces(&mut motion, 0.0, &mut forces);
        let base = &structure.mesh.base;
        let own: f64 = base.iter().map(|&n| structure.mass[n]).sum::<f64>() * 9.81;
        let reaction = [0, 1].map(|d| base.iter().map(|&n| forces[n][d]).sum::<f64>());
        let weight = 2640.0 * 9.81 * dam.parameters().section.area();
        let water = 9810.0 * 91.75 * 91.75 / 2.0;
        let heel = 9810.0 * 91.75 * first_panel(&dam) / 2.0 - 9810.0 * first_panel(&dam).powi(2) / 6.0;
        // element forces on the base are the reactions of the ground with opposite sign
        let errors = [reaction[0] / (water - heel) - 1.0, -reaction[1] / (weight - own) - 1.0];
        println!("{size} m: reactions over loads − 1: {:+.1e}, {:+.1e}", errors[0], errors[1]);
        assert!(errors.iter().all(|error| error.abs() < 1e-8));
        let closed = support::get(&dam, &variable::CRACK_OPEN)[0];
        assert_eq!(closed, 0.0, "contacts open at rest");
    }
    Ok(())
}

/// Length of the lowest panel, m; its water pressure partly acts on the fixed heel.
fn first_panel(dam: &cofferdam_dam::Dam) -> f64 {
    dam.wet_face().map_or(0.0, |face| face.points()[1][1])
}

/// Without friction the water pushes the block off, unless a bond holds it: the cohesion would be enough if it acted
/// everywhere at once, but it breaks where the stress is largest, and then everywhere.
#[test]
fn a_bond_that_breaks_piece_by_piece_leaves_no_state_of_rest() -> Result<(), DamError> {
    let smooth = |cohesion: f64| DamParameters {
        cracks: vec![CrackParameters { friction_coefficient: 0.0, cohesion, ..support::crack_at(66.5) }],
        ..support::koyna(15.0)
    };
    let needed = 1e6 / smooth(1e6).limit_equilibria([9810.0, 0.0])?[0].sliding;
    assert!(matches!(support::at_rest(smooth(0.99 * needed)), Err(DamError::CannotStand { .. })));
    let refused = support::at_rest(smooth(1.05 * needed));
    let Err(error) = refused else { panic!("a state of rest was found for a block without friction") };
    println!("{error}");
    assert!(
        matches!(error, DamError::StaticNotConverged { iterations: 1..100_000, .. }),
        "it runs away and is not followed to the end"
    );
    support::at_rest(smooth(3.0 * needed)).map(|_| ())
}

/// Loads that are not numbers end the relaxation at once.
#[test]
fn loads_that_are_no_numbers_end_at_once() -> Result<(), DamError> {
    let dam = support::at_rest(support::koyna(15.0))?;
    let structure = dam.structure();
    let mut loads = structure.weight([0.0, -9.81]);
    let last = loads.len() - 1;
    loads[last] = [f64::NAN; 2];
    let mut motion = structure.at_rest();
    for refused in [
        DynamicRelaxation::default().relax(structure, &mut motion, &loads),
        SparseNewton::default().relax(structure, &mut motion, &loads),
    ] {
        let at_once = matches!(refused, Err(DamError::StaticNotConverged { iterations: 0..2, .. }));
        assert!(at_once, "{refused:?}");
    }
    Ok(())
}

/// Newton's iteration and dynamic relaxation give the same state of rest. Tolerance: residuals of 1e-9 of the loads.
#[test]
fn newton_and_dynamic_relaxation_agree() -> Result<(), DamError> {
    for cracks in [vec![], vec![66.5], vec![20.0, 66.5]] {
        let cracks = cracks.into_iter().map(support::crack_at).collect();
        let dam = Dam::new(DamParameters { cracks, ..support::koyna(7.0) })?;
        let structure = dam.structure();
        let loads = structure.weight([2.0, -9.81]);
        let rest = |relax: &dyn Fn(&mut Motion) -> Result<Relaxed, DamError>| {
            let mut motion = structure.at_rest();
            relax(&mut motion).map(|relaxed| (motion, relaxed.iterations))
        };
        let (newton, few) = rest(&|motion| SparseNewton::default().relax(structure, motion, &loads))?;
        let (relaxed, many) = rest(&|motion| DynamicRelaxation::default().relax(structure, motion, &loads))?;
        let difference = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]);
        let apart = newton.displacement.iter().zip(&relaxed.displacement).map(difference).fold(0.0, f64::max);
        let largest = newton.displacement.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
        println!(
            "{} cracks: Newton {few}, dynamic relaxation {many} iterations, apart {:.1e}",
            structure.cracks.len(),
            apart / largest
        );
        assert!(apart < 1e-6 * largest && few < many);
    }
    Ok(())
}
