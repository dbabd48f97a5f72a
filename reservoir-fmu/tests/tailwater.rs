//! Water before a downstream face: the mirrored problem, bit for bit.

use crate::rectangular::THREADS;

use cofferdam_reservoir::{Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters, added_mass};
use cofferdam_unit::variables::reservoir as variable;
use cofferdam_unit::{CoSimulation, Variable, WetFace};

const STEP: f64 = 0.005;
/// Mirrored coordinates are exact: all are multiples of 1/8 m below 64 m.
const TOE: f64 = 64.0;

fn get(unit: &Reservoir, variable: &Variable) -> Result<Vec<f64>, ReservoirError> {
    let mut values = vec![0.0; unit.size(variable)];
    unit.get(variable.value_reference, &mut values)?;
    Ok(values)
}

/// A battered face with a kink, where two points coincide, and a crack.
fn upstream() -> WetFace {
    let at = |x: f64, y: f64| [x, y];
    let points = [
        at(0.0, 0.0),
        at(1.0, 4.0),
        at(2.0, 8.0),
        at(2.0, 8.0),
        at(5.0, 14.0),
        at(8.0, 20.0),
        at(8.0, 20.0),
        at(10.0, 24.0),
    ];
    WetFace::new(points.to_vec()).expect("a face")
}

/// All models, over a bed that rises, which the ground's horizontal motion pushes into the water.
fn models() -> Vec<ReservoirParameters> {
    let before = |fidelity, method| {
        let bed = if fidelity == Fidelity::Westergaard { Vec::new() } else { vec![[-30.0, 6.0]] };
        let base = ReservoirParameters::before(upstream());
        ReservoirParameters {
            fidelity,
            method,
            bed,
            element_size: 2.0,
            wave_reflection_coefficient: 0.8,
            communication_step: STEP,
            horizon: 0.5,
            ..base
        }
    };
    vec![
        before(Fidelity::Westergaard, Method::Radau2),
        before(Fidelity::Incompressible, Method::Radau2),
        before(Fidelity::Compressible, Method::Radau2),
        before(Fidelity::Compressible, Method::Recursive),
        before(Fidelity::Compressible, Method::FiniteElements),
    ]
}

/// The same water on the other side of a dam with its toe at [`TOE`].
fn behind(parameters: &ReservoirParameters) -> ReservoirParameters {
    let face = ReservoirParameters::before(parameters.face_of_dam().mirrored(TOE));
    ReservoirParameters { wet_face: face.wet_face, toe: face.toe, ..parameters.clone() }
}

#[test]
fn the_tailwater_is_the_reservoir_in_the_mirror() -> Result<(), ReservoirError> {
    for parameters in models() {
        let model = format!("{:?}, {:?}", parameters.fidelity, parameters.method);
        let mut reservoir = Reservoir::new(parameters.clone(), THREADS)?;
        let mut tailwater = Reservoir::new(behind(&parameters), THREADS)?;
        assert_eq!((reservoir.name(), tailwater.name()), ("reservoir", "tailwater"));
        for unit in [&mut reservoir, &mut tailwater] {
            unit.initialise(0.0)?;
        }
        let points = upstream().len();
        let mut largest = 0.0_f64;
        for step in 0..40_u32 {
            let time = f64::from(step) * STEP;
            let motion: Vec<f64> =
                (0..points).map(|i| (40.0 * time + 0.4 * i as f64).sin() * (1.0 + i as f64)).collect();
            let ground = [(31.0 * time).sin() * 3.0, (17.0 * time).cos()];
            for (unit, side) in [(&mut reservoir, 1.0), (&mut tailwater, -1.0)] {
                unit.set(variable::INTERFACE_ACCELERATION.value_reference, &motion)?;
                unit.set(variable::GROUND_ACCELERATION.value_reference, &[side * ground[0], ground[1]])?;
                unit.step(time, STEP)?;
            }
            let [here, there] = [&reservoir, &tailwater];
            let pressure = get(here, &variable::INTERFACE_PRESSURE)?;
            assert_eq!(get(there, &variable::INTERFACE_PRESSURE)?, pressure, "{model}, step {step}");
            largest = pressure.iter().fold(largest, |most, p| most.max(p.abs()));
            let [force, moment] = [variable::TOTAL_FORCE, variable::OVERTURNING_MOMENT];
            assert_eq!(get(there, &force)?[0], -get(here, &force)?[0], "{model}");
            // Both moments are about the heel, which is the toe in the mirror.
            let lifted: f64 = upstream().nodal_forces(&pressure).iter().map(|force| force[1]).sum();
            let expected = -get(here, &moment)?[0] - TOE * lifted;
            let found = get(there, &moment)?[0];
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{model}: {found}, {expected}");
        }
        println!("{model}: equal bits, at most {largest:.3e} Pa");
        assert!(largest > 1e3);
        for by in [variable::INTERFACE_ACCELERATION, variable::GROUND_ACCELERATION] {
            let mut seed: Vec<f64> = (0..reservoir.size(&by)).map(|i| 1.0 + i as f64).collect();
            let mut answers = Vec::new();
            for unit in [&reservoir, &tailwater] {
                let mut answer = vec![0.0; points];
                let [of, by] = [variable::INTERFACE_PRESSURE.value_reference, by.value_reference];
                unit.directional_derivative(of, by, &seed, &mut answer)?;
                answers.push(answer);
                if by == variable::GROUND_ACCELERATION.value_reference {
                    seed[0] = -seed[0];
                }
            }
            assert_eq!(answers[0], answers[1], "{model}: {}", by.name);
        }
    }
    Ok(())
}

/// What the ground's horizontal motion does through a rising bed has the other sign if it is not mirrored.
#[test]
fn the_ground_moves_the_other_way_in_the_mirror() -> Result<(), ReservoirError> {
    let parameters = behind(&models()[1]);
    let mut unit = Reservoir::new(parameters, THREADS)?;
    unit.initialise(0.0)?;
    let mut answer = |x: f64| {
        unit.set(variable::GROUND_ACCELERATION.value_reference, &[x, 0.0])?;
        let start = unit.save_state();
        unit.step(0.0, STEP)?;
        let pressure = get(&unit, &variable::BASE_PRESSURE)?[0];
        unit.restore_state(&start)?;
        Ok::<_, ReservoirError>(pressure)
    };
    // Upstream motion of a bed that rises downstream lifts its water's floor: it presses.
    let [upwards, downwards] = [answer(-1.0)?, answer(1.0)?];
    println!("base pressure {upwards:.1} Pa under -1 m/s², {downwards:.1} Pa under 1 m/s²");
    assert!(upwards > 100.0 && (upwards + downwards).abs() < 1e-9 * upwards);
    Ok(())
}

#[test]
fn a_tailwater_answers_in_the_coordinates_of_the_dam() -> Result<(), ReservoirError> {
    let parameters = behind(&models()[0]);
    let face = parameters.face_of_dam();
    assert_eq!((face.toe(), face.points()[7]), (Some(TOE), [54.0, 24.0]));
    let unit = Reservoir::new(parameters.clone(), THREADS)?;
    let [x, nx, ny] = [variable::INTERFACE_X, variable::INTERFACE_NORMAL_X, variable::INTERFACE_NORMAL_Y];
    assert_eq!(get(&unit, &x)?, face.points().iter().map(|p| p[0]).collect::<Vec<_>>());
    assert!(
        get(&unit, &nx)?.iter().chain(&get(&unit, &ny)?).all(|n| *n < 0.0),
        "upstream and down, into the dam"
    );
    let depths: Vec<f64> = face.points().iter().map(|p| 1000.0 * 9.81 * (24.0 - p[1])).collect();
    assert_eq!(get(&unit, &variable::HYDROSTATIC_PRESSURE)?, depths);
    assert_eq!(added_mass(&parameters)?, added_mass(&models()[0])?);
    let odd = ReservoirParameters { wet_face: face, ..parameters.clone() };
    assert!(matches!(odd.problem(), Some(("wet_face", ReservoirError::NotFromTheToe { x: TOE }))));
    let odd = ReservoirParameters { toe: Some(f64::NAN), ..parameters };
    assert!(matches!(odd.problem(), Some(("toe", ReservoirError::NotPositive { .. }))));
    Ok(())
}
