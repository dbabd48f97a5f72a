//! Sliding blocks against closed forms.

use crate::support;

use cofferdam_dam::analytical::newmark_1965::{incline_acceleration, rectangular_pulse_slip};
use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::integrator::DynamicRelaxation;
use cofferdam_dam::{DamError, Motion, RayleighCoefficients, Structure};
use support::GRAVITY;

const DAMPING: RayleighCoefficients = RayleighCoefficients { mass: 0.0, stiffness: 1e-3 };

/// A block at rest on joints of `stiffness` (Pa/m), with a Young's modulus of the same number in Pa.
fn block(friction: f64, gravity: f64, stiffness: f64) -> Result<(Structure, Motion), DamError> {
    let law = Coulomb { friction, normal_stiffness: stiffness, shear_stiffness: stiffness };
    let structure = support::block_on_ground([3.0, 0.6], stiffness, law, Integration::Nodal);
    let mut motion = structure.at_rest();
    let weight = structure.weight([0.0, -gravity]);
    DynamicRelaxation::default().relax(&structure, &mut motion, &weight)?;
    Ok((structure, motion))
}

/// A block at rest on a horizontal plane, which is then tilted: friction angles below and above the slope
/// angle. The joints are stiff, so that the block hardly tilts under the moment of friction. Error over the
/// acceleration without friction.
#[test]
fn incline_holds_below_the_friction_angle_and_lets_go_above() -> Result<(), DamError> {
    let angle = 30f64.to_radians();
    for friction in [0.3, 0.5, 0.55, 0.6, 0.8] {
        let (structure, mut motion) = block(friction, GRAVITY * angle.cos(), 1e11)?;
        let body = [GRAVITY * angle.sin(), -GRAVITY * angle.cos()];
        support::run(&structure, DAMPING, &mut motion, body, 0.05);
        let early = support::mean(&structure, &motion.velocity, 1)[0];
        support::run(&structure, DAMPING, &mut motion, body, 0.1);
        let measured = (support::mean(&structure, &motion.velocity, 1)[0] - early) / 0.1;
        let exact = incline_acceleration(GRAVITY, angle, friction);
        let error = (measured - exact) / (GRAVITY * angle.sin());
        println!(
            "incline 30°, μ = {friction}: acceleration {measured:.6}, exact {exact:.6} m/s², error {error:.1e}"
        );
        assert!(error.abs() < 1e-6);
    }
    Ok(())
}

/// Tolerance 1 %: the shear springs stretch by μ p/k_s before the slip and return after it.
#[test]
fn rectangular_pulse_slides_as_newmark_says() -> Result<(), DamError> {
    let (structure, mut motion) = block(0.4, GRAVITY, 1e9)?;
    let rest = support::mean(&structure, &motion.displacement, 1)[0];
    let mut friction = support::run(&structure, DAMPING, &mut motion, [-8.0, -GRAVITY], 0.25).friction;
    friction += support::run(&structure, DAMPING, &mut motion, [0.0, -GRAVITY], 0.6).friction;
    let slip = rest - support::mean(&structure, &motion.displacement, 1)[0];
    let exact = rectangular_pulse_slip(0.4 * GRAVITY, 8.0, 0.25);
    let work = 0.4 * 2500.0 * 3.0 * 0.6 * GRAVITY * exact;
    println!("Newmark pulse: slip {slip:.5} m, exact {exact:.5} m, error {:.2e}", slip / exact - 1.0);
    println!("Newmark pulse: friction work {friction:.1} J/m, exact {work:.1} J/m");
    assert!((slip / exact - 1.0).abs() < 0.01 && (friction / work - 1.0).abs() < 0.01);
    Ok(())
}
