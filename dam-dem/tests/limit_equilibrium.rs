//! Whether a dam can stand at all: closed forms of a triangular section, and refusal.

use crate::support;

use cofferdam_dam::{Dam, DamError, DamParameters, Fidelity, Section};
use cofferdam_unit::{CoSimulation, variables::dam as variable};

const SPECIFIC_WEIGHT: f64 = 9810.0;

/// A right-angled triangle, nearly, 40 m high and 28 m wide, full of water, with a crack at 10 m.
fn triangle(friction: f64) -> DamParameters {
    let section = Section::new(vec![[0.0, 0.0], [0.0, 40.0]], vec![[28.0, 0.0], [0.28, 39.6], [0.28, 40.0]]);
    let mut crack = support::crack_at(10.0);
    crack.friction_coefficient = friction;
    DamParameters { section, water_depth: 40.0, cracks: vec![crack], ..support::koyna(2.0) }
}

/// A triangle of height h and base b above the crack: V = γh²/2, N = ρgbh/2; about the toe N 2b/3 holds and V h/3 turns.
/// Tolerance: the tip is cut.
#[test]
fn the_factors_are_those_of_a_triangle() -> Result<(), DamError> {
    let (height, width) = (30.0, 21.0);
    let (thrust, weight) = (SPECIFIC_WEIGHT * height * height / 2.0, 2640.0 * 9.81 * width * height / 2.0);
    let mut bonded = triangle(0.7);
    (bonded.cracks[0].cohesion, bonded.cracks[0].tensile_strength) = (1e5, 2e5);
    for (dam, cohesion, tension) in [(triangle(0.7), 0.0, 0.0), (bonded, 1e5, 2e5)] {
        let found = dam.limit_equilibria([SPECIFIC_WEIGHT, 0.0])?[0];
        let sliding = (cohesion * width + 0.7 * weight) / thrust;
        let turning = (weight * 2.0 / 3.0 * width + tension * width * width / 2.0) / (thrust * height / 3.0);
        println!("{found:?}; a triangle: {sliding:.4}, {turning:.4}");
        assert!((found.sliding / sliding - 1.0).abs() < 2e-3);
        assert!((found.overturning / turning - 1.0).abs() < 2e-3);
    }
    let empty = DamParameters { water_depth: 0.0, ..triangle(0.7) };
    assert_eq!(empty.limit_equilibria([SPECIFIC_WEIGHT, 0.0])?[0].sliding, f64::INFINITY);
    let intact = DamParameters { fidelity: Fidelity::Intact { modes: None }, ..triangle(0.7) };
    assert!(intact.limit_equilibria([SPECIFIC_WEIGHT, 0.0])?.is_empty());
    Ok(())
}

/// The state of rest is found just above a factor of 1, and refused with the factor just below.
#[test]
fn what_cannot_stand_is_refused_at_once() -> Result<(), DamError> {
    let initialise = |friction: f64| -> Result<(), DamError> {
        let mut dam = Dam::new(triangle(friction))?;
        dam.set(variable::HYDROSTATIC_PRESSURE.value_reference, &support::hydrostatic(&dam))?;
        dam.initialise(0.0)
    };
    let critical = 1.0 / triangle(1.0).limit_equilibria([SPECIFIC_WEIGHT, 0.0])?[0].sliding;
    assert_eq!(initialise(1.02 * critical), Ok(()));
    let refused = initialise(0.98 * critical);
    assert!(
        matches!(refused, Err(DamError::CannotStand { way: "slide", factor, .. }) if (factor - 0.98).abs() < 1e-9),
        "{refused:?}"
    );
    // half as wide, it turns over
    let mut narrow = triangle(5.0);
    narrow.section.downstream = vec![[14.0, 0.0], [0.28, 39.6], [0.28, 40.0]];
    let mut dam = Dam::new(narrow)?;
    dam.set(variable::HYDROSTATIC_PRESSURE.value_reference, &support::hydrostatic(&dam))?;
    let refused = dam.initialise(0.0);
    assert!(matches!(refused, Err(DamError::CannotStand { way: "overturn", .. })), "{refused:?}");
    Ok(())
}
