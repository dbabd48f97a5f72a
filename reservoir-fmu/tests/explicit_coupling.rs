//! Explicit coupling: the unit against the ordinary one, and a wall on a spring against the iterated step.

use crate::rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, parameters};
use cofferdam_reservoir::{Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir::{
    GROUND_ACCELERATION, INTERFACE_ACCELERATION, INTERFACE_PRESSURE, TOTAL_FORCE,
};
use cofferdam_unit::{CoSimulation, Packable};
use nalgebra::DVector;
use std::f64::consts::PI;

const H: f64 = 0.0025;
const POINTS: usize = 9;

fn explicit(parameters: &ReservoirParameters) -> Result<Reservoir, ReservoirError> {
    Reservoir::new(ReservoirParameters { explicit_coupling: true, ..parameters.clone() }, THREADS)
}

fn set(unit: &mut Reservoir, face: &[f64], ground: [f64; 2]) -> Result<(), ReservoirError> {
    unit.set(INTERFACE_ACCELERATION.value_reference, face)?;
    unit.set(GROUND_ACCELERATION.value_reference, &ground)
}

fn pressure(unit: &Reservoir) -> Result<DVector<f64>, ReservoirError> {
    let mut values = DVector::zeros(unit.parameters().wet_face.len());
    unit.get(INTERFACE_PRESSURE.value_reference, values.as_mut_slice())?;
    Ok(values)
}

/// All ways to compute the water, for 0.2 s.
fn waters() -> Vec<ReservoirParameters> {
    let compressible = parameters(0.8, POINTS - 1, H, 0.2);
    let methods = [Method::Radau2, Method::Trapezoid, Method::Recursive, Method::FiniteElements];
    let still = [Fidelity::Incompressible, Fidelity::Westergaard];
    let stepped = methods.map(|method| ReservoirParameters { method, ..compressible.clone() });
    let still = still.map(|fidelity| ReservoirParameters { fidelity, ..compressible.clone() });
    stepped.into_iter().chain(still).collect()
}

/// For motions that are linear in time nothing is extrapolated wrongly: with a(t) = a₀ + b t, the output after step n is
/// `p_{n+1} + A₀ ā_{n+1} + ½ A₀ b H` of the ordinary unit; without memory `p_{n+1} + A a(t_{n+1})`. Its other outputs are those
/// of a step before.
#[test]
fn linear_motions_give_the_pressure_of_the_ordinary_unit() -> Result<(), ReservoirError> {
    for parameters in waters() {
        let (mut ordinary, mut ahead) =
            (Reservoir::new(parameters.clone(), THREADS)?, explicit(&parameters)?);
        let mass = ahead.instantaneous_added_mass();
        let slope = DVector::from_fn(POINTS, |i, _| 3.0 - 2.0 * i as f64);
        let mean = |step: usize| {
            DVector::from_fn(POINTS, |i, _| 1.0 + i as f64) + &slope * ((step as f64 - 0.5) * H)
        };
        let ground = |step: usize| [0.7 + 5.0 * step as f64 * H, 0.5 - 9.0 * step as f64 * H];
        for unit in [&mut ordinary, &mut ahead] {
            set(unit, &[0.0; POINTS], ground(0))?;
            unit.initialise(0.0)?;
        }
        let (mut outputs, mut forces) = (vec![pressure(&ahead)?], vec![0.0]);
        let force = |unit: &Reservoir| {
            let mut force = [0.0];
            unit.get(TOTAL_FORCE.value_reference, &mut force).map(|()| force[0])
        };
        let mut largest: f64 = 0.0;
        for step in 1..60 {
            // The importer passes what the dam gave after the step before.
            let known = if step == 1 { DVector::zeros(POINTS) } else { mean(step - 1) };
            set(&mut ahead, known.as_slice(), ground(step))?;
            ahead.step((step - 1) as f64 * H, H)?;
            set(&mut ordinary, mean(step).as_slice(), ground(step))?;
            ordinary.step((step - 1) as f64 * H, H)?;
            let exact = pressure(&ordinary)?;
            largest = largest.max(exact.amax());
            // The output for the end of this step was given a step ago.
            let expected = exact + &mass * (mean(step) + &slope * (0.5 * H));
            if step > 4 {
                let error = (&outputs[step - 1] - expected).amax() / largest;
                assert!(error < 1e-10, "{:?}, step {step}: {error}", parameters.method);
                assert_eq!(force(&ahead)?, forces[step - 1], "the step before, bit for bit");
            }
            outputs.push(pressure(&ahead)?);
            forces.push(force(&ordinary)?);
        }
    }
    Ok(())
}

/// A rigid wall on a spring before the water, under a force that is linear over a step, solved exactly; u and v along x.
struct Wall {
    /// kg/m
    mass: f64,
    /// N/m per metre of wall
    stiffness: f64,
    length: f64,
    motion: [f64; 2],
}

impl Wall {
    /// Mean acceleration over a step under a force (N/m) from `begin` to `end`.
    fn step(&mut self, [begin, end]: [f64; 2]) -> f64 {
        let Self { mass, stiffness, length, motion: [u, v] } = *self;
        let (omega, slope) = ((stiffness / mass).sqrt(), (end - begin) / length / stiffness);
        let (sin, cos) = (omega * length).sin_cos();
        let [free, speed] = [u - begin / stiffness, v - slope];
        self.motion =
            [free * cos + speed / omega * sin + end / stiffness, -free * omega * sin + speed * cos + slope];
        (self.motion[1] - v) / length
    }
}

/// A pulse on the wall, N/m.
fn pulse(time: f64) -> f64 {
    if time < 0.2 { 1e6 * (PI * time / 0.2).sin().powi(2) } else { 0.0 }
}

/// Displacements of a wall of `mass` (kg/m) over 0.8 s in steps of `length` (s): iterated, and explicit.
fn walls(mass: f64, length: f64, method: Method) -> Result<[Vec<f64>; 2], ReservoirError> {
    let water = ReservoirParameters { method, ..parameters(0.8, POINTS - 1, length, 1.0) };
    let (mut ordinary, mut ahead) = (Reservoir::new(water.clone(), THREADS)?, explicit(&water)?);
    let force =
        |p: &DVector<f64>| water.wet_face.nodal_forces(p.as_slice()).iter().map(|f| f[0]).sum::<f64>();
    let added = force(&(ahead.instantaneous_added_mass() * DVector::repeat(POINTS, 1.0)));
    let mut iterated = Wall { mass, stiffness: 9e9, length, motion: [0.0; 2] };
    let mut single = Wall { mass: mass + added, ..iterated };
    ordinary.initialise(0.0)?;
    ahead.initialise(0.0)?;
    let (mut histories, mut water_force, mut rest, mut mean) = ([vec![], vec![]], 0.0, [0.0; 2], 0.0);
    for step in 0..(0.8 / length).round() as usize {
        let time = step as f64 * length;
        let external = [pulse(time), pulse(time + length)];
        // The fixed point of a step, linear in the guessed force.
        let saved = (ordinary.save_state(), iterated.motion);
        let mut answer = |guess: f64| -> Result<f64, ReservoirError> {
            ordinary.restore_state(&saved.0)?;
            iterated.motion = saved.1;
            let mean = iterated.step([external[0] + water_force, external[1] + guess]);
            set(&mut ordinary, &[mean; POINTS], [0.0; 2])?;
            ordinary.step(time, length)?;
            Ok(force(&pressure(&ordinary)?))
        };
        let (zero, one) = (answer(0.0)?, answer(1e6)?);
        let solution = zero / (1.0 - (one - zero) / 1e6);
        assert!((answer(solution)? - solution).abs() <= 1e-9 * (solution.abs() + 1e3));
        water_force = solution;
        histories[0].push(iterated.motion[0]);
        // Both at once, with what the other gave after the step before.
        rest = [rest[1], force(&pressure(&ahead)?)];
        set(&mut ahead, &[mean; POINTS], [0.0; 2])?;
        ahead.step(time, length)?;
        mean = single.step([external[0] + rest[0], external[1] + rest[1]]);
        histories[1].push(single.motion[0]);
    }
    Ok(histories)
}

/// Largest difference of the two, over the largest displacement.
fn error([iterated, single]: &[Vec<f64>; 2]) -> f64 {
    let largest = iterated.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
    iterated.iter().zip(single).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// The wall weighs as much as 50 m of concrete; its frequency with water is 2.4 Hz.
#[test]
fn an_explicit_wall_tends_to_the_iterated_one_at_third_order() -> Result<(), ReservoirError> {
    for method in [Method::Recursive, Method::Radau2] {
        let errors =
            [0.01, 0.005, 0.0025].map(|length| walls(2.2e7, length, method).map(|both| error(&both)));
        let [coarse, middle, fine] = errors;
        let (coarse, middle, fine) = (coarse?, middle?, fine?);
        println!("{method:?}: errors {coarse:.2e}, {middle:.2e}, {fine:.2e}");
        assert!(coarse / middle > 6.0 && middle / fine > 6.0 && fine < 1e-3);
    }
    Ok(())
}

/// Without reflections p = −ρ c v, so that A₀ = ρ c H per area, and a free wall is stable if it weighs more than 0.52 of that:
/// the roots of (μ + 1)(z⁵ − z⁴) + ½ (2.5 z³ + 0.5 z² − 1.5 z + 0.5), μ = M/A₀, then lie within the unit circle.
#[test]
fn an_explicit_wall_is_stable_if_it_outweighs_half_the_water_of_a_step() -> Result<(), ReservoirError> {
    let of_step = |length: f64| DENSITY * SOUND_SPEED * length * DEPTH;
    let length = 0.005;
    let [light, lighter] = [0.7, 0.3].map(|share| walls(share * of_step(length), length, Method::Recursive));
    let (light, lighter) = (error(&light?), error(&lighter?));
    println!("errors {light:.2e}, {lighter:.2e}");
    assert!(light < 0.05 && lighter > 1e3);
    Ok(())
}

#[test]
fn only_the_step_of_the_dams_mass_is_taken_and_states_resume() -> Result<(), ReservoirError> {
    for parameters in waters() {
        let mut unit = explicit(&parameters)?;
        let capabilities = Reservoir::capabilities_for(unit.parameters());
        assert!(!capabilities.variable_communication_step && !capabilities.directional_derivative);
        unit.initialise(0.0)?;
        for other in [0.5 * H, 2.0 * H] {
            let said = unit.step(0.0, other).unwrap_err().to_string();
            assert!(said.contains("step"), "{said}");
        }
        let double = unit.step(0.0, 2.0 * H).unwrap_err();
        assert!(matches!(double, ReservoirError::ExplicitStep { .. }), "{double}");
        let run = |from: usize, to: usize, unit: &mut Reservoir| -> Result<Vec<f64>, ReservoirError> {
            for step in from..to {
                set(unit, &[(step as f64).sin(); POINTS], [0.1, step as f64 % 3.0])?;
                unit.step(step as f64 * H, H)?;
            }
            Ok(pressure(unit)?.data.into())
        };
        run(0, 7, &mut unit)?;
        let state = unit.save_state();
        let bytes = unit.serialise_state(&state)?;
        let once = run(7, 20, &mut unit)?;
        unit.restore_state(&state)?;
        assert_eq!(run(7, 20, &mut unit)?, once);
        let mut other = explicit(&parameters)?;
        let read = other.deserialise_state(&bytes)?;
        other.restore_state(&read)?;
        assert_eq!(run(7, 20, &mut other)?, once);
        assert!(other.deserialise_state(&bytes[..bytes.len() - 1]).is_err());
    }
    Ok(())
}
