//! Rigid block that slides on a moving plane.
//!
//! **Source**: N.M. Newmark, *Effects of earthquakes on dams and embankments*, Géotechnique 15 (1965)
//! 139–160; tested in `tests/newmark_1965.rs`.

/// Slip of a block on a horizontal plane whose acceleration is one rectangular pulse, m.
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
/// `g (sin θ − μ cos θ)`, or 0 if friction holds the block.
pub fn incline_acceleration(gravity: f64, angle: f64, friction: f64) -> f64 {
    (gravity * (angle.sin() - friction * angle.cos())).max(0.0)
}

/// Slip of a block relative to the ground at the last of the `samples`, m, positive along the axis of the
/// ground. The ground acceleration is linear between `samples` (s, m/s²); the block may slide in both
/// directions. Steps are at most 10 µs long, with the mean acceleration of each step.
///
/// A block at rest sticks while `|a_g|` is at most `yield_acceleration` (m/s²); a sliding block has the acceleration
/// `−a_g ∓ μg` relative to the ground.
pub fn slip_on_ground(samples: &[(f64, f64)], yield_acceleration: f64) -> f64 {
    let (mut slip, mut velocity) = (0.0, 0.0f64);
    for pair in samples.windows(2) {
        let [(start, before), (end, after)] = [pair[0], pair[1]];
        let count = ((end - start) / 1e-5).ceil().max(1.0);
        let step = (end - start) / count;
        for n in 0..count as usize {
            let ground = before + (after - before) * (n as f64 + 0.5) / count;
            let direction = if velocity != 0.0 { velocity.signum() } else { -ground.signum() };
            if velocity == 0.0 && ground.abs() <= yield_acceleration {
                continue;
            }
            let acceleration = -ground - direction * yield_acceleration;
            let next = velocity + step * acceleration;
            // if the block comes to rest within the step, it stays at rest until the next step
            let stops = velocity != 0.0 && next * velocity <= 0.0;
            slip += if stops {
                -0.5 * velocity * velocity / acceleration
            } else {
                step * (velocity + next) / 2.0
            };
            velocity = if stops { 0.0 } else { next };
        }
    }
    slip
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record of the rectangular pulse, with edges of 1 µs, in both directions.
    #[test]
    fn the_pulse_is_a_record_too() {
        let exact = rectangular_pulse_slip(2.0, 4.0, 0.25);
        for sign in [1.0, -1.0] {
            let pulse = [(0.0, 0.0), (1e-6, 4.0), (0.25, 4.0), (0.250_001, 0.0), (1.0, 0.0)];
            let samples = pulse.map(|(t, a)| (t, sign * a));
            assert!((slip_on_ground(&samples, 2.0) / (-sign * exact) - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_pulse_at_the_yield_acceleration_moves_nothing() {
        assert_eq!(rectangular_pulse_slip(5.0, 5.0, 1.0), 0.0);
        assert!((rectangular_pulse_slip(2.0, 4.0, 1.0) - 2.0).abs() < 1e-15);
    }
}
