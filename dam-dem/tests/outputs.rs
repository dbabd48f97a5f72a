//! Outputs that the coupling relies on.

mod support;

use dam_dem::DamError;
use interface::{CoSimulation, variables::dam as variable};

/// `interface_acceleration` is the mean total acceleration along n: change of velocity over the step, plus the
/// mean of the ground's. At the heel, which the ground holds, it is the ground's alone. Tolerance: rounding.
#[test]
fn interface_acceleration_is_the_mean_of_the_total_motion() -> Result<(), DamError> {
    let mut dam = support::at_rest(support::koyna(7.0))?;
    support::shake(&mut dam, 2.5e-3, 0.3, support::bursts)?;
    let (step, ground) = (4e-3, [support::bursts(0.3), 2.5]);
    let before = support::get(&dam, &variable::INTERFACE_VELOCITY);
    let position = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    dam.set(variable::GROUND_ACCELERATION.value_reference, &[ground[1], 0.0])?;
    dam.step(dam.state().time(), step)?;
    let after = support::get(&dam, &variable::INTERFACE_VELOCITY);
    let acceleration = support::get(&dam, &variable::INTERFACE_ACCELERATION);
    let mean_ground = (ground[0] + ground[1]) / 2.0;
    let mut error = 0.0f64;
    for i in 0..after.len() {
        error = error.max((acceleration[i] - (after[i] - before[i]) / step - mean_ground).abs());
    }
    println!("interface acceleration against the change of velocity: {error:.1e} m/s²");
    assert!(error < 1e-9 && (acceleration[0] - mean_ground).abs() < 1e-12);

    let moved = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    let top = after.len() - 1;
    let trapezoid = position[top] + step * (before[top] + after[top]) / 2.0;
    println!("displacement against the trapezoid of velocity: {:.1e} m", moved[top] - trapezoid);
    assert!((moved[top] - trapezoid).abs() < 1e-2 * step * (before[top].abs() + after[top].abs()));
    Ok(())
}

/// Pressure pushes the dam downstream, along n.
#[test]
fn pressure_pushes_downstream() -> Result<(), DamError> {
    let mut dam = support::at_rest(support::koyna(10.0))?;
    let pressure = vec![1e4; dam.wet_face().map_or(0, |face| face.len())];
    dam.set(variable::INTERFACE_PRESSURE.value_reference, &pressure)?;
    for _ in 0..10 {
        dam.step(dam.state().time(), 2.5e-3)?;
    }
    let face = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    let crest = support::get(&dam, &variable::CREST_DISPLACEMENT)[0];
    println!("10 kPa for 25 ms: crest {crest:.1e} m");
    assert!(face.iter().all(|&u| u >= 0.0) && crest > 0.0);
    assert!(support::get(&dam, &variable::INPUT_WORK)[0] > 0.0);
    Ok(())
}
