//! Bonds that break within the iteration of a communication step.

use crate::support;
use cofferdam_dam::{DamError, DamParameters, Fidelity};
use cofferdam_unit::{CoSimulation, variables::dam as variable};
use nalgebra::{DMatrix, DVector};

/// Residual of the pressure at which a step has converged, Pa, and iterations after which it has not.
const CONVERGED: f64 = 1e-3;
const MOST_ITERATIONS: usize = 30;

/// How a run ended.
struct End {
    /// Number of bonds that broke.
    broken: usize,
    /// Number of steps that did not converge.
    stuck: usize,
    /// Displacement of the crest, m.
    crest: f64,
}

/// A dam of reduced blocks with a bonded crack of this relative strength.
fn bonded(strength: f64) -> DamParameters {
    let mut dam = DamParameters { fidelity: Fidelity::Reduced { modes: None }, ..support::koyna(10.0) };
    (dam.cracks[0].cohesion, dam.cracks[0].tensile_strength) = (2e5 * strength, 1e5 * strength);
    dam
}

/// The dam in Westergaard's water, whose pressure is found in every step by Newton's iteration with the compliance of the
/// bonded dam.
fn shaken(parameters: &DamParameters, step: f64, until: f64) -> Result<End, DamError> {
    let mut dam = support::at_rest(parameters.clone())?;
    let face = dam.wet_face().unwrap().clone();
    let h = face.depth();
    let mass =
        DVector::from_iterator(face.len(), face.points().iter().map(|p| 875.0 * (h * (h - p[1])).sqrt()));
    let compliance = dam.interface_compliance(step, 1e3)?.acceleration;
    let jacobian = DMatrix::identity(face.len(), face.len()) + DMatrix::from_diagonal(&mass) * compliance;
    let elastic = jacobian.try_inverse().unwrap();
    let mut pressure = DVector::zeros(face.len());
    let mut stuck = 0;
    while dam.state().time() < until - step / 2.0 {
        let (start, time) = (dam.save_state(), dam.state().time());
        let ground = support::bursts(time + step);
        let mut iterations = 0;
        // Broyden's method, from the inverse Jacobian of the elastic dam
        let mut inverse = elastic.clone();
        let mut last: Option<(DVector<f64>, DVector<f64>)> = None;
        loop {
            iterations += 1;
            dam.set(variable::INTERFACE_PRESSURE.value_reference, pressure.as_slice())?;
            dam.set(variable::GROUND_ACCELERATION.value_reference, &[ground, 0.0])?;
            dam.step(time, step)?;
            let acceleration = DVector::from_vec(support::get(&dam, &variable::INTERFACE_ACCELERATION));
            let residual = -mass.component_mul(&acceleration) - &pressure;
            if residual.amax() < CONVERGED {
                break;
            }
            if iterations == MOST_ITERATIONS {
                println!("  t = {time:.4} s: {:.1e} Pa", residual.amax());
                stuck += 1;
                break;
            }
            if let Some((moved, before)) = last {
                let change = &inverse * (&before - &residual);
                let row = moved.transpose() * &inverse;
                let share = moved.dot(&change);
                inverse += (&moved - change) * row / share;
            }
            let change = &inverse * &residual;
            pressure += &change;
            last = Some((change, residual));
            dam.restore_state(&start)?;
        }
    }
    let broken = dam.state().motion().joints().iter().flatten().filter(|joint| !joint.bonded).count();
    Ok(End { broken, stuck, crest: support::get(&dam, &variable::CREST_DISPLACEMENT)[0] })
}

/// All bonds of the crack break within a communication step or two. With one strength in twenty and this communication step,
/// a bond breaks with the pressure that follows if it holds, and holds with the one that follows if it breaks.
#[test]
fn bonds_that_break_do_not_keep_a_step_from_converging() -> Result<(), DamError> {
    for i in 10..20 {
        let end = shaken(&bonded(1.0 + 0.05 * f64::from(i)), 5e-4, 0.7)?;
        assert_eq!((end.broken, end.stuck), (8, 0));
    }
    Ok(())
}

/// The strength does not depend on the communication step: what the dam does after its bonds have broken converges with
/// the order 1 of a water that answers to the mean acceleration of a step.
#[test]
fn the_motion_after_a_break_converges_with_the_communication_step() -> Result<(), DamError> {
    let crest = |step: f64| -> Result<f64, DamError> {
        let end = shaken(&bonded(1.5), step, 0.72)?;
        assert_eq!((end.broken, end.stuck), (8, 0));
        Ok(end.crest)
    };
    let crests = [4e-3, 2e-3, 1e-3, 5e-4].map(crest).into_iter().collect::<Result<Vec<_>, _>>()?;
    let changes: Vec<f64> = crests.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let orders: Vec<f64> = changes.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("crest at {crests:.5?} m, orders {orders:.2?}");
    assert!(orders.iter().all(|order| (0.9..1.3).contains(order)));
    Ok(())
}
