//! Rigid block that slides on a moving plane.
//!
//! **Source**: N.M. Newmark, *Effects of earthquakes on dams and embankments*, Géotechnique 15 (1965)
//! 139–160; tested in `tests/newmark_1965.rs`.

/// Slip of a block on a level plane whose acceleration is one rectangular pulse, m.
///
/// With yield acceleration `μg`, pulse `A > μg` over `T` and ground velocity `V = A T`:
/// `d = V²/(2μg) (1 − μg/A)`; zero for `A ≤ μg`.
///
/// **Units**: `yield_acceleration` and `pulse` m/s², `duration` s.
pub fn rectangular_pulse_slip(yield_acceleration: f64, pulse: f64, duration: f64) -> f64 {
    let velocity = pulse * duration;
    (velocity * velocity / (2.0 * yield_acceleration) * (1.0 - yield_acceleration / pulse)).max(0.0)
}

/// Acceleration of a block down a plane inclined by `angle` (rad), m/s²:
/// `g (sin θ − μ cos θ)`, or 0 where friction holds it.
pub fn incline_acceleration(gravity: f64, angle: f64, friction: f64) -> f64 {
    (gravity * (angle.sin() - friction * angle.cos())).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pulse_at_the_yield_acceleration_moves_nothing() {
        assert_eq!(rectangular_pulse_slip(5.0, 5.0, 1.0), 0.0);
        assert!((rectangular_pulse_slip(2.0, 4.0, 1.0) - 2.0).abs() < 1e-15);
    }
}
