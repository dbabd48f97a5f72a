//! Order of accuracy in the communication step.

use crate::rectangular;

use cofferdam_reservoir::ReservoirError;
use cofferdam_reservoir::analytical::chopra_1967::base_pressure_of_acceleration_ramp;
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, base_pressures, parameters};
use std::f64::consts::PI;

const PULSE: f64 = 0.15;

/// ∫ sin⁴(πt/T) dt.
fn velocity(t: f64) -> f64 {
    let t = t.clamp(0.0, PULSE);
    let x = 2.0 * PI * t / PULSE;
    0.375 * t - PULSE / (4.0 * PI) * x.sin() + PULSE / (32.0 * PI) * (2.0 * x).sin()
}

/// Base pressure: the pulse's second derivative convolved with the closed form for a ramp.
fn exact(t: f64) -> f64 {
    let points = 4000;
    let sum: f64 = (1..points)
        .map(|i| {
            let tau = PULSE * i as f64 / points as f64;
            let (sine, cosine) = (PI * tau / PULSE).sin_cos();
            let curvature = (PI / PULSE).powi(2) * (12.0 * (sine * cosine).powi(2) - 4.0 * sine.powi(4));
            curvature * base_pressure_of_acceleration_ramp(DEPTH, SOUND_SPEED, t - tau)
        })
        .sum();
    DENSITY * SOUND_SPEED * sum * PULSE / points as f64
}

/// The velocity's interpolation is of second order, the Radau method of third.
#[test]
fn second_order_in_the_communication_step() -> Result<(), ReservoirError> {
    let mut errors = Vec::new();
    for h in [0.02, 0.01, 0.005] {
        let pressures = base_pressures(parameters(1.0, 24, h, 0.6), velocity)?;
        let peak = pressures.iter().fold(0.0, |m: f64, (t, _)| m.max(exact(*t).abs()));
        let error = pressures.iter().fold(0.0, |m: f64, (t, p)| m.max((p - exact(*t)).abs())) / peak;
        println!("sin⁴ pulse, H = {h} s: largest error {error:.2e} of the peak");
        errors.push(error);
    }
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("sin⁴ pulse: order {order:.2} in H");
    assert!(order >= 1.9);
    Ok(())
}
