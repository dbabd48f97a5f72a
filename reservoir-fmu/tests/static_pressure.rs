//! A ramp of acceleration that is then held for ten minutes: the recursion must neither forget the static pressure nor
//! drift from it.

use crate::rectangular;

use cofferdam_reservoir::analytical::westergaard_1933;
use cofferdam_reservoir::{
    Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters, added_mass, ground_added_mass,
};
use cofferdam_unit::variables::reservoir::{GROUND_ACCELERATION, INTERFACE_ACCELERATION, INTERFACE_PRESSURE};
use cofferdam_unit::{CoSimulation, WetFace};
use nalgebra::DVector;
use rectangular::{DENSITY, DEPTH, THREADS, parameters, projected, ramp_and_hold};

/// Time until which the acceleration is held, s.
const HELD: f64 = 600.0;
/// Length of the steps while it is held, s: no multiple of the period of a mode, 4h/c over an odd number.
const STEP: f64 = 0.03;
/// The part at its end over which pressures are averaged, s: 30 periods 4h/c, 500 steps.
const AVERAGED: f64 = 15.0;

/// Pressures at all points at the ends of steps of 0.01 s during a ramp to 1 m/s² within 0.1 s, and of `step` from then
/// on: for motion of the face along −n, or of the ground alone.
fn held(
    water: &ReservoirParameters,
    step: f64,
    duration: f64,
    ground: Option<usize>,
) -> Result<Vec<(f64, Vec<f64>)>, ReservoirError> {
    let points = water.wet_face.len();
    let mut unit =
        Reservoir::new(ReservoirParameters { method: Method::Recursive, ..water.clone() }, THREADS)?;
    unit.initialise(0.0)?;
    let (mut time, mut history) = (0.0, Vec::new());
    while time < duration - 1e-9 {
        let length = if time < 0.1 - 1e-9 { 0.01 } else { step };
        let acceleration = |t: f64| (t / 0.1).min(1.0);
        let end = time + length;
        match ground {
            None => {
                let mean = -0.5 * (acceleration(time) + acceleration(end));
                unit.set(INTERFACE_ACCELERATION.value_reference, &vec![mean; points])?;
            }
            Some(axis) => {
                let mut moved = [0.0; 2];
                moved[axis] = acceleration(end);
                unit.set(GROUND_ACCELERATION.value_reference, &moved)?;
            }
        }
        unit.step(time, length)?;
        time = end;
        let mut pressure = vec![0.0; points];
        unit.get(INTERFACE_PRESSURE.value_reference, &mut pressure)?;
        history.push((time, pressure));
    }
    Ok(history)
}

/// Mean pressure over the last part.
fn mean_at_last(history: &[(f64, Vec<f64>)]) -> DVector<f64> {
    let last: Vec<&Vec<f64>> =
        history[history.len() - (AVERAGED / STEP).round() as usize..].iter().map(|(_, p)| p).collect();
    let sum = last.iter().fold(DVector::zeros(last[0].len()), |sum, p| sum + DVector::from_column_slice(p));
    sum / last.len() as f64
}

/// Before a vertical face over a level bed, from an absorbing bed to a rigid one: the mean of the last periods against
/// Westergaard's series, in the largest norm over the face; over a rigid bed, which rings for ever, also every seventh base
/// pressure against Chopra's closed form, whose series takes longer than the step.
#[test]
fn a_held_ramp_comes_to_rest_over_any_level_bed() -> Result<(), ReservoirError> {
    for alpha in [0.0, 0.5, 0.9, 1.0] {
        let water = parameters(alpha, 16, 0.01, 1.0);
        let history = held(&water, STEP, HELD, None)?;
        let profile = |elevations: &[f64]| {
            elevations
                .iter()
                .map(|y| (DENSITY * westergaard_1933::series_pressure(DEPTH, *y)).into())
                .collect()
        };
        let exact = DVector::from_iterator(17, projected(&water.wet_face, profile).into_iter().map(|p| p.re));
        let off = (mean_at_last(&history) - &exact).amax() / exact.amax();
        println!(
            "α = {alpha}: after {HELD} s the mean pressure is {off:.1e} of its largest from the static one"
        );
        assert!(off < 1e-3);
        if alpha == 1.0 {
            let pairs: Vec<[f64; 2]> =
                history.iter().step_by(7).map(|(t, p)| [p[0], ramp_and_hold::base_pressure(*t)]).collect();
            let peak = pairs.iter().fold(0.0, |most: f64, [_, exact]| most.max(*exact));
            let worst = pairs.iter().fold(0.0, |most: f64, [p, exact]| most.max((p - exact).abs() / peak));
            println!("α = 1: base pressure never more than {worst:.1e} of its peak off the closed form");
            assert!(worst < 1e-3);
        }
    }
    Ok(())
}

/// Gravity waves, with which a steady velocity has a pressure, and a bed that is almost rigid are refused.
#[test]
fn what_no_recursion_describes_is_refused() {
    let water = parameters(0.5, 8, 0.01, 1.0);
    let water = ReservoirParameters { method: Method::Recursive, surface_waves: true, ..water };
    assert!(matches!(Reservoir::new(water, THREADS), Err(ReservoirError::GravityWaves { .. })));
    let water = ReservoirParameters { method: Method::Recursive, ..parameters(0.999, 8, 0.01, 1.0) };
    let refused = Reservoir::new(water, THREADS).err();
    assert!(matches!(refused, Some(ReservoirError::NotFitted | ReservoirError::Recursion { .. })));
}

/// The same before a battered face over a rising bed, by boundary elements, also for motion of the ground: against the
/// added mass of incompressible water.
#[test]
fn a_held_ramp_comes_to_rest_in_any_section() -> Result<(), ReservoirError> {
    let alpha = 0.5;
    let water = ReservoirParameters {
        bed: vec![[-60.0, 0.0], [-140.0, 40.0]],
        wet_face: WetFace::straight([30.0, DEPTH], 10).unwrap(),
        ..parameters(alpha, 10, 0.01, 1.0)
    };
    let still = ReservoirParameters { fidelity: Fidelity::Incompressible, ..water.clone() };
    let (of_face, of_ground) = (added_mass(&still)?.column_sum(), ground_added_mass(&still)?);
    for (what, ground, exact) in [
        ("face", None, of_face),
        ("bed along x", Some(0), -of_ground.column(0)),
        ("bed along y", Some(1), -of_ground.column(1)),
    ] {
        let off = (mean_at_last(&held(&water, STEP, HELD, ground)?) - &exact).amax() / exact.amax();
        println!(
            "α = {alpha}, {what}: after {HELD} s the mean pressure is {off:.1e} of its largest from the static one"
        );
        assert!(off < 1e-3);
    }
    Ok(())
}
