//! Envelopes against what the outputs say at every step.

use crate::support;

use cofferdam_dam::{CrackParameters, Dam, DamError, DamParameters, Fidelity, Material};
use cofferdam_unit::{CoSimulation, Variable, variables::dam as variable};
use support::{at_rest, bursts, get, koyna};

const STEP: f64 = 2e-3;
const STEPS: usize = 150;
const STRENGTH: f64 = 2e5;

fn parameters(fidelity: Fidelity) -> DamParameters {
    let dam = koyna(10.0);
    DamParameters {
        fidelity,
        envelopes: true,
        material: Material { tensile_strength: Some(STRENGTH), ..dam.material },
        cracks: vec![CrackParameters { friction_coefficient: 0.2, ..dam.cracks[0].clone() }],
        ..dam
    }
}

fn step(dam: &mut Dam, number: usize, factor: f64) -> Result<(), DamError> {
    let time = number as f64 * STEP;
    let a = factor * bursts(1.0 + time + STEP);
    dam.set(variable::GROUND_ACCELERATION.value_reference, &[a, 0.5 * a])?;
    dam.step(dam.state().time(), STEP)
}

/// All variables of the envelopes.
fn envelopes(dam: &Dam) -> Vec<(&'static str, Vec<f64>)> {
    let own = variable::ALL.iter().filter(|variable| variable.name.starts_with("envelope_"));
    own.map(|variable| (variable.name, get(dam, variable))).collect()
}

/// Values from which an extreme over time is to be taken, the envelope of it, and which of two values it takes.
type Extreme = (Variable, Variable, fn(f64, f64) -> f64);
const EXTREMES: [Extreme; 7] = [
    (variable::NODE_DISPLACEMENT_X, variable::ENVELOPE_DISPLACEMENT_X_LEAST, f64::min),
    (variable::NODE_DISPLACEMENT_X, variable::ENVELOPE_DISPLACEMENT_X_MOST, f64::max),
    (variable::NODE_DISPLACEMENT_Y, variable::ENVELOPE_DISPLACEMENT_Y_LEAST, f64::min),
    (variable::NODE_DISPLACEMENT_Y, variable::ENVELOPE_DISPLACEMENT_Y_MOST, f64::max),
    (variable::CONTACT_OPENING, variable::ENVELOPE_CONTACT_OPENING, f64::max),
    (variable::CONTACT_SLIP, variable::ENVELOPE_CONTACT_SLIP_LEAST, f64::min),
    (variable::CONTACT_SLIP, variable::ENVELOPE_CONTACT_SLIP_MOST, f64::max),
];

/// Every second step is first tried with three times the shaking, and forgotten.
#[test]
fn they_are_the_extremes_of_the_steps_that_were_kept() -> Result<(), DamError> {
    for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }] {
        let mut dam = at_rest(parameters(fidelity))?;
        let places: Vec<[f64; 2]> = dam.structure().mesh.nodes.clone();
        let mut extremes = EXTREMES.map(|(of, ..)| get(&dam, &of));
        let mut magnitude = vec![0.0f64; places.len()];
        // At the stress points, which are nodes: largest and smallest, when, and how often above the strength.
        let points = get(&dam, &variable::STRESS_POINT_X).len();
        let stresses = |dam: &Dam| {
            [get(dam, &variable::MAJOR_PRINCIPAL_STRESS), get(dam, &variable::MINOR_PRINCIPAL_STRESS)]
        };
        let mut principal = stresses(&dam);
        let (mut when, mut above) = ([vec![0.0; points], vec![0.0; points]], vec![0; points]);
        for number in 0..STEPS {
            if number % 2 == 1 {
                let state = dam.save_state();
                step(&mut dam, number, 3.0)?;
                dam.restore_state(&state)?;
            }
            step(&mut dam, number, 1.0)?;
            for ((of, _, pick), extreme) in EXTREMES.iter().zip(&mut extremes) {
                extreme.iter_mut().zip(get(&dam, of)).for_each(|(most, now)| *most = pick(*most, now));
            }
            let [x, y] =
                [variable::NODE_DISPLACEMENT_X, variable::NODE_DISPLACEMENT_Y].map(|of| get(&dam, &of));
            for (most, (x, y)) in magnitude.iter_mut().zip(x.iter().zip(&y)) {
                *most = most.max(x.hypot(*y));
            }
            let time = dam.state().time();
            let now = stresses(&dam);
            for point in 0..points {
                for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
                    if sign * now[k][point] > sign * principal[k][point] {
                        (principal[k][point], when[k][point]) = (now[k][point], time);
                    }
                }
                above[point] += usize::from(now[0][point] > STRENGTH);
            }
        }
        let corners: Vec<usize> = {
            let centres: Vec<usize> = dam.structure().mesh.cells.iter().map(|cell| cell[4]).collect();
            (0..places.len()).filter(|node| !centres.contains(node)).collect()
        };
        let near = |found: f64, expected: f64, scale: f64| (found - expected).abs() <= 1e-9 * scale;
        for ((_, of, _), extreme) in EXTREMES.iter().zip(&extremes) {
            let found = get(&dam, of);
            let scale = found.iter().fold(0.0f64, |most, value| most.max(value.abs()));
            let all: Vec<usize> = (0..found.len()).collect();
            let compared = if found.len() == places.len() { &corners } else { &all };
            // An opening counts from 0 on.
            let floor = if *of == variable::ENVELOPE_CONTACT_OPENING { 0.0 } else { f64::NEG_INFINITY };
            assert!(scale > 1e-5, "{fidelity:?}: {} moves", of.name);
            for &i in compared {
                assert!(near(found[i], extreme[i].max(floor), scale), "{fidelity:?}: {} at {i}", of.name);
            }
        }
        let found = get(&dam, &variable::ENVELOPE_DISPLACEMENT_MAGNITUDE);
        assert!(corners.iter().all(|&node| near(found[node], magnitude[node], 1.0)));
        let [x, y] = [variable::STRESS_POINT_X, variable::STRESS_POINT_Y].map(|of| get(&dam, &of));
        let node_of = |point: usize| {
            // Below a crack, as the stress points are.
            places.iter().position(|place| *place == [x[point], y[point]]).unwrap_or(usize::MAX)
        };
        let [major, minor, major_time, minor_time, duration, ratio] = [
            variable::ENVELOPE_MAJOR_PRINCIPAL_STRESS,
            variable::ENVELOPE_MINOR_PRINCIPAL_STRESS,
            variable::ENVELOPE_MAJOR_PRINCIPAL_STRESS_TIME,
            variable::ENVELOPE_MINOR_PRINCIPAL_STRESS_TIME,
            variable::ENVELOPE_OVERSTRESS_DURATION,
            variable::ENVELOPE_DEMAND_CAPACITY_RATIO,
        ]
        .map(|of| get(&dam, &of));
        for point in 0..points {
            let node = node_of(point);
            assert_eq!(
                [major[node], minor[node]],
                [principal[0][point], principal[1][point]],
                "{fidelity:?}"
            );
            assert_eq!([major_time[node], minor_time[node]], [when[0][point], when[1][point]]);
            assert!((duration[node] - STEP * above[point] as f64).abs() < 1e-12);
            assert_eq!(ratio[node], (major[node] / STRENGTH).max(0.0));
        }
        assert!(above.iter().any(|times| *times > 3) && above.iter().any(|times| *times < STEPS));
        assert_eq!(get(&dam, &variable::ENVELOPE_END), [dam.state().time()]);
    }
    Ok(())
}

#[test]
fn they_go_on_from_a_saved_state_and_change_no_motion() -> Result<(), DamError> {
    for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }] {
        let with = parameters(fidelity);
        let mut whole = at_rest(with.clone())?;
        (0..40).try_for_each(|number| step(&mut whole, number, 1.0))?;
        let bytes = whole.serialise_state(&whole.save_state())?;
        let mut resumed = Dam::new(with.clone())?;
        resumed.restore_state(&resumed.deserialise_state(&bytes)?)?;
        let mut without = at_rest(DamParameters { envelopes: false, ..with })?;
        (0..40).try_for_each(|number| step(&mut without, number, 1.0))?;
        for number in 40..60 {
            for dam in [&mut whole, &mut resumed, &mut without] {
                step(dam, number, 1.0)?;
            }
        }
        assert_eq!(envelopes(&whole), envelopes(&resumed));
        let own = variable::ALL.iter().filter(|variable| variable.name.starts_with("envelope_"));
        assert!(own.map(|variable| without.size(variable)).all(|size| size == 0));
        assert_eq!(whole.state().motion(), without.state().motion());
        for of in [variable::LARGEST_PRINCIPAL_STRESS, variable::SMALLEST_PRINCIPAL_STRESS_PLACE] {
            assert_eq!(get(&whole, &of), get(&without, &of), "{fidelity:?}: {}", of.name);
        }
        let other = without.serialise_state(&without.save_state())?;
        assert!(whole.deserialise_state(&other).is_err());
    }
    Ok(())
}
