//! States, refusals and variables: the contract of co-simulation units.

use crate::rectangular;

use cofferdam_reservoir::{Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir::{
    ALL, GROUND_ACCELERATION, HORIZON, HYDROSTATIC_PRESSURE, INTERFACE_ACCELERATION, INTERFACE_PRESSURE,
    RECURSION_ERROR, RECURSION_LOSS,
};
use cofferdam_unit::{CallError, CoSimulation, Level, Messages, StateError};
use rectangular::{DENSITY, DEPTH, THREADS, parameters};

const POINTS: usize = 7;
const STEP: f64 = 0.005;

fn made() -> ReservoirParameters {
    parameters(0.7, POINTS - 1, STEP, 2.0)
}

fn stepping(parameters: ReservoirParameters) -> Result<Reservoir, ReservoirError> {
    let mut unit = Reservoir::new(parameters, THREADS)?;
    unit.initialise(0.0)?;
    Ok(unit)
}

/// Takes step number `step` and returns the pressures' bits.
fn advance(unit: &mut Reservoir, step: usize) -> Result<Vec<u64>, ReservoirError> {
    let a: Vec<f64> = (0..POINTS).map(|i| ((step * POINTS + i) as f64).sin() * 3.0).collect();
    unit.set(INTERFACE_ACCELERATION.value_reference, &a)?;
    unit.step(step as f64 * STEP, STEP)?;
    let mut p = vec![0.0; POINTS];
    unit.get(INTERFACE_PRESSURE.value_reference, &mut p)?;
    Ok(p.iter().map(|p| p.to_bits()).collect())
}

/// Save, step, restore, disturb, restore and step give equal bits, within blocks of 128 steps and across their
/// boundaries, in memory and through bytes in another unit.
#[test]
fn states_repeat_every_bit() -> Result<(), ReservoirError> {
    for fidelity in [Fidelity::Compressible, Fidelity::Incompressible, Fidelity::Westergaard] {
        let mut unit = stepping(ReservoirParameters { fidelity, ..made() })?;
        let mut other = Reservoir::new(unit.parameters().clone(), THREADS)?;
        for step in 0..390 {
            let saved = unit.save_state();
            let bits = advance(&mut unit, step)?;
            if [0, 1, 57, 126, 127, 128, 129, 255, 256, 257, 383, 384, 389].contains(&step) {
                for _ in 0..2 {
                    unit.restore_state(&saved)?;
                    unit.set(INTERFACE_ACCELERATION.value_reference, &[1e3; POINTS])?;
                    unit.step(step as f64 * STEP, STEP)?;
                }
                unit.restore_state(&saved)?;
                assert_eq!(advance(&mut unit, step)?, bits, "step {step}");
                let bytes = unit.serialise_state(&saved)?;
                let read = other.deserialise_state(&bytes)?;
                other.restore_state(&read)?;
                assert_eq!(advance(&mut other, step)?, bits, "step {step}, serialised");
                let after = advance(&mut other, step + 1)?;
                let here = unit.save_state();
                assert_eq!(advance(&mut unit, step + 1)?, after, "step after {step}, serialised");
                unit.restore_state(&here)?;
            }
        }
    }
    Ok(())
}

#[test]
fn states_of_another_reservoir_are_refused() -> Result<(), ReservoirError> {
    let unit = stepping(made())?;
    let mut other = stepping(ReservoirParameters { density: 1001.0, ..made() })?;
    let refused = |result| {
        matches!(result, Err(ReservoirError::Call(CallError::State(StateError::Fingerprint { .. }))))
    };
    let state = unit.save_state();
    let bytes = unit.serialise_state(&state)?;
    assert!(refused(other.restore_state(&state)));
    assert!(refused(other.serialise_state(&state).map(|_| ())));
    assert!(refused(other.deserialise_state(&bytes).map(|_| ())));
    Ok(())
}

#[test]
fn bad_parameters_are_named() {
    let error = |change: &dyn Fn(&mut ReservoirParameters)| {
        let mut parameters = made();
        change(&mut parameters);
        Reservoir::new(parameters, THREADS).map(|_| ()).unwrap_err()
    };
    for alpha in [-0.1, 1.1, f64::NAN] {
        let error = error(&|p| p.wave_reflection_coefficient = alpha);
        assert!(matches!(error, ReservoirError::WaveReflectionCoefficient { .. }), "{error}");
    }
    type Field = fn(&mut ReservoirParameters) -> &mut f64;
    let fields: [(&str, Field); 7] = [
        ("density", |p| &mut p.density),
        ("sound_speed", |p| &mut p.sound_speed),
        ("gravity", |p| &mut p.gravity),
        ("element_size", |p| &mut p.element_size),
        ("far_end_distance", |p| &mut p.far_end_distance),
        ("communication_step", |p| &mut p.communication_step),
        ("horizon", |p| &mut p.horizon),
    ];
    for (name, field) in fields {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = error(&|p| *field(p) = bad);
            let named = matches!(&error, ReservoirError::NotPositive { parameter, .. } if *parameter == name);
            assert!(named, "{name} = {bad}: {error}");
        }
    }
    let error = error(&|p| p.horizon = 0.001);
    assert!(matches!(error, ReservoirError::HorizonTooShort { .. }), "{error}");
    let short = ReservoirParameters { horizon: 0.001, fidelity: Fidelity::Westergaard, ..made() };
    assert!(short.validate().is_ok(), "without memory there is no horizon");
    for s in [(-1.0, 3.0), (0.0, 0.0), (f64::NAN, 3.0), (1.0, f64::INFINITY)] {
        let s = cofferdam_reservoir::Complex64::new(s.0, s.1);
        let error = cofferdam_reservoir::frequency_response(&made(), &[s], THREADS).unwrap_err();
        assert!(matches!(error, ReservoirError::Frequency { .. }), "{error}");
    }
}

#[test]
fn calls_out_of_order_are_refused() -> Result<(), ReservoirError> {
    let mut unit = Reservoir::new(made(), THREADS)?;
    let order = |r| matches!(r, Err(ReservoirError::Call(CallError::Order { .. })));
    assert!(order(unit.step(0.0, STEP)));
    unit.initialise(1.0)?;
    assert!(order(unit.initialise(1.0)));
    assert!(matches!(unit.step(0.0, STEP), Err(ReservoirError::Call(CallError::Time { .. }))));
    let wrong = unit.step(1.0, 1.5 * STEP);
    assert!(matches!(wrong, Err(ReservoirError::Call(CallError::CommunicationStep { .. }))));
    let wrong = unit.set(HORIZON.value_reference, &[3.0]);
    assert!(matches!(wrong, Err(ReservoirError::Call(CallError::NotSettable { .. }))));
    let wrong = unit.set(INTERFACE_ACCELERATION.value_reference, &[3.0]);
    assert!(matches!(wrong, Err(ReservoirError::Call(CallError::Length { .. }))));
    let wrong = unit.set(INTERFACE_ACCELERATION.value_reference, &[f64::NAN; POINTS]);
    assert!(matches!(wrong, Err(ReservoirError::Call(CallError::NonFinite { .. }))));
    assert!(matches!(unit.set(999, &[3.0]), Err(ReservoirError::Call(CallError::UnknownVariable { .. }))));
    let ground = GROUND_ACCELERATION.value_reference;
    let wrong = unit.set(ground, &[0.0, f64::INFINITY]);
    assert!(matches!(wrong, Err(ReservoirError::Call(CallError::NonFinite { .. }))));
    unit.set(ground, &[3.0, 0.0])?;
    unit.step(1.0, STEP)?;
    Ok(())
}

/// A step of several steps of the unit's own is those steps, with the ground between its values at both ends, and its
/// derivatives are differences of such steps.
#[test]
fn a_multiple_of_the_own_step_is_that_many_steps() -> Result<(), ReservoirError> {
    const MULTIPLE: usize = 5;
    let long = MULTIPLE as f64 * STEP;
    let ground = |step: usize| [(0.3 * step as f64).sin(), (0.7 * step as f64).cos() - 1.0];
    let pressure = |unit: &Reservoir| {
        let mut p = [0.0; POINTS];
        unit.get(INTERFACE_PRESSURE.value_reference, &mut p).map(|()| p)
    };
    let set = |unit: &mut Reservoir, step: usize, ground: &[f64; 2]| {
        let a: Vec<f64> = (0..POINTS).map(|i| ((step * POINTS + i) as f64).sin() * 3.0).collect();
        unit.set(INTERFACE_ACCELERATION.value_reference, &a)?;
        unit.set(GROUND_ACCELERATION.value_reference, ground)
    };
    for method in [Method::Bdf2, Method::Radau2, Method::FiniteElements] {
        let made = ReservoirParameters { method, ..made() };
        let [mut single, mut whole] = [stepping(made.clone())?, stepping(made)?];
        for step in 0..79 {
            let [begin, end] = [ground(step), ground(step + 1)];
            for own in 1..=MULTIPLE {
                let share = own as f64 / MULTIPLE as f64;
                let between = [0, 1].map(|axis| begin[axis] + (end[axis] - begin[axis]) * share);
                set(&mut single, step, &between)?;
                single.step((step * MULTIPLE + own - 1) as f64 * STEP, STEP)?;
            }
            set(&mut whole, step, &end)?;
            whole.step(step as f64 * long, long)?;
            for (found, wanted) in pressure(&whole)?.iter().zip(pressure(&single)?) {
                assert!((found - wanted).abs() < 1e-6, "{method:?} step {step}: {found} for {wanted}");
            }
        }
        let before = whole.save_state();
        for (variable, size) in [(INTERFACE_ACCELERATION, POINTS), (GROUND_ACCELERATION, 2)] {
            for known in 0..size {
                let mut answers = [[0.0; POINTS]; 2];
                for (value, answer) in answers.iter_mut().enumerate() {
                    let mut input = vec![0.0; size];
                    input[known] = value as f64;
                    whole.restore_state(&before)?;
                    whole.set(variable.value_reference, &input)?;
                    whole.step(79.0 * long, long)?;
                    *answer = pressure(&whole)?;
                }
                let [mut seed, mut derivative] = [vec![0.0; size], vec![0.0; POINTS]];
                seed[known] = 1.0;
                let [unknown, known] = [INTERFACE_PRESSURE.value_reference, variable.value_reference];
                whole.directional_derivative(unknown, known, &seed, &mut derivative)?;
                for ((found, after), at_first) in derivative.iter().zip(answers[1]).zip(answers[0]) {
                    let wanted = after - at_first;
                    assert!((found - wanted).abs() < 1e-6, "{method:?}: {found} for {wanted}");
                }
            }
        }
        let beyond = matches!(whole.step(80.0 * long, long), Err(ReservoirError::BeyondHorizon { .. }));
        assert_eq!(beyond, method.has_horizon(), "{method:?}");
        for bad in [0.0, -STEP, 0.4 * STEP, 1.5 * STEP, f64::NAN, f64::INFINITY] {
            let error = single.step(79.0 * long, bad).unwrap_err();
            let named = matches!(error, ReservoirError::Call(CallError::CommunicationStep { .. }));
            assert!(named, "{bad}: {error}");
        }
    }
    Ok(())
}

/// The serialised state contains the time, and mean and length of the last step.
#[test]
fn states_after_steps_of_varying_length_repeat_every_bit() -> Result<(), ReservoirError> {
    for fidelity in [Fidelity::Incompressible, Fidelity::Westergaard] {
        let parameters = ReservoirParameters { fidelity, ..made() };
        let [mut unit, mut other] = [stepping(parameters.clone())?, stepping(parameters)?];
        let advance = |unit: &mut Reservoir, time: f64, length: f64| -> Result<Vec<u64>, ReservoirError> {
            unit.set(INTERFACE_ACCELERATION.value_reference, &[(91.0 * time).cos(); POINTS])?;
            unit.step(time, length)?;
            let mut p = [0.0; POINTS];
            unit.get(INTERFACE_PRESSURE.value_reference, &mut p)?;
            Ok(p.iter().map(|p| p.to_bits()).collect())
        };
        let mut time = 0.0;
        for step in 0..600 {
            let length = 0.01 + 0.009 * f64::from(step).sin();
            let saved = unit.save_state();
            let bits = advance(&mut unit, time, length)?;
            unit.restore_state(&saved)?;
            advance(&mut unit, time, 7.0 * length)?;
            other.restore_state(&other.deserialise_state(&unit.serialise_state(&saved)?)?)?;
            assert_eq!(advance(&mut other, time, length)?, bits);
            let reached = other.save_state();
            unit.restore_state(&reached)?;
            time += length;
        }
        for bad in [0.0, -0.01, f64::NAN, f64::INFINITY] {
            let error = unit.step(time, bad).unwrap_err();
            assert!(matches!(error, ReservoirError::NotPositive { parameter: "communication_step", .. }));
        }
        let late = unit.step(time + 0.01, 0.01);
        assert!(matches!(late, Err(ReservoirError::Call(CallError::Time { .. }))));
        assert!(time > 2.0, "the horizon is no end");
    }
    Ok(())
}

#[test]
fn the_horizon_is_the_end() -> Result<(), ReservoirError> {
    let mut unit = stepping(ReservoirParameters { horizon: 3.0 * STEP, ..made() })?;
    for step in 0..3 {
        advance(&mut unit, step)?;
    }
    let error = advance(&mut unit, 3).unwrap_err();
    assert!(matches!(error, ReservoirError::BeyondHorizon { .. }));
    assert!(
        error.to_string().contains("0.015 s") && error.to_string().contains("raise `horizon`"),
        "{error}"
    );
    Ok(())
}

#[test]
fn every_variable_is_readable() -> Result<(), ReservoirError> {
    let unit = stepping(made())?;
    for variable in ALL {
        let mut values = vec![f64::NAN; unit.size(variable)];
        unit.get(variable.value_reference, &mut values)?;
        assert!(values.iter().all(|v| v.is_finite()), "{}", variable.name);
    }
    let mut hydrostatic = [0.0; POINTS];
    unit.get(HYDROSTATIC_PRESSURE.value_reference, &mut hydrostatic)?;
    assert!(
        (hydrostatic[0] / (DENSITY * 9.81 * DEPTH) - 1.0).abs() < 1e-15 && hydrostatic[POINTS - 1] == 0.0
    );
    Ok(())
}

/// A recursion tells its error and loss, and warns of large ones; another method has none.
#[test]
fn a_recursion_tells_how_good_it_is() -> Result<(), ReservoirError> {
    let quality = |parameters: ReservoirParameters| -> Result<([f64; 2], Vec<String>), ReservoirError> {
        let messages = Messages::default();
        let unit = messages.listen(|| Reservoir::new(parameters, THREADS))?;
        let mut values = [[0.0], [0.0]];
        unit.get(RECURSION_ERROR.value_reference, &mut values[0])?;
        unit.get(RECURSION_LOSS.value_reference, &mut values[1])?;
        let warnings = messages.take().into_iter().filter(|(level, ..)| *level == Level::Warning);
        Ok((values.map(|[value]| value), warnings.map(|(_, _, text)| text).collect()))
    };
    assert_eq!(quality(made())?, ([0.0; 2], Vec::new()));
    let over = |alpha: f64| ReservoirParameters {
        method: Method::Recursive,
        wave_reflection_coefficient: alpha,
        ..made()
    };
    let (good, said) = quality(over(0.5))?;
    assert!(good.iter().all(|value| (1e-6..=1e-3).contains(value)) && said.is_empty(), "{good:?} {said:?}");
    let (doubtful, said) = quality(over(0.99))?;
    println!("α = 0.5: error and loss {good:?}; α = 0.99: {doubtful:?}, {said:?}");
    assert!(doubtful[0].max(doubtful[1]) > 1e-3 && said.len() == 1, "{doubtful:?} {said:?}");
    let error = format!("{:.1e}", doubtful[0]);
    assert!(said[0].contains(&error), "{error} {said:?}");
    Ok(())
}

/// The automatic method is the recursion where its fit is good, and then has no horizon; otherwise it is the convolution: where
/// the fit is doubtful (α = 0.99), where there is none (gravity waves, an almost rigid bed).
#[test]
fn the_automatic_method_is_the_recursion_where_that_fits() -> Result<(), ReservoirError> {
    let steps = |parameters: ReservoirParameters, count: usize| {
        let mut unit = stepping(parameters)?;
        let bits = (0..count).map(|step| advance(&mut unit, step)).collect::<Result<Vec<_>, _>>();
        Ok::<_, ReservoirError>((unit.is_recursion(), bits))
    };
    let with =
        |method, parameters: &ReservoirParameters| ReservoirParameters { method, ..parameters.clone() };
    let over = |alpha: f64| ReservoirParameters { wave_reflection_coefficient: alpha, ..made() };
    let waves = ReservoirParameters { surface_waves: true, ..made() };
    for (parameters, fits) in [(over(0.5), true), (over(0.99), false), (over(0.999), false), (waves, false)] {
        let (recursion, bits) = steps(with(Method::Automatic, &parameters), 30)?;
        let method = if fits { Method::Recursive } else { Method::Radau2 };
        assert_eq!((recursion, bits?), (fits, steps(with(method, &parameters), 30)?.1?));
        // 2 s are 400 steps.
        let beyond = steps(with(Method::Automatic, &parameters), 402)?.1;
        assert_eq!(beyond.is_ok(), fits, "{:?}", beyond.err());
    }
    // A run that no convolution could be made for.
    let long = ReservoirParameters { horizon: 1e5, ..over(0.5) };
    assert!(long.validate().is_err() && steps(with(Method::Automatic, &long), 3)?.0);
    let refused =
        Reservoir::new(ReservoirParameters { horizon: 1e5, ..with(Method::Automatic, &over(0.99)) }, THREADS);
    assert!(matches!(refused.err(), Some(ReservoirError::TooMuch { .. })));
    Ok(())
}

/// An importer's sum of steps is rounded, the more so the later it begins; a time that lies between two steps is refused.
#[test]
fn times_may_be_sums_of_steps() -> Result<(), ReservoirError> {
    let (mut unit, mut time) = (Reservoir::new(made(), THREADS)?, 1e7);
    unit.initialise(time)?;
    for step in 1..=390 {
        unit.step(time, STEP)?;
        time += STEP;
        let exact = 1e7 + f64::from(step) * STEP;
        let between = unit.step(exact + 0.5 * STEP, STEP);
        assert!(matches!(between, Err(ReservoirError::Call(CallError::Time { .. }))), "{step}");
    }
    let apart = (time - (1e7 + 390.0 * STEP)).abs();
    println!("after 390 steps the sum is {:.0e} of a step off", apart / STEP);
    assert!(apart > 1e-5 * STEP);
    Ok(())
}
