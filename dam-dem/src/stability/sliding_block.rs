//! Newmark's sliding block: a rigid body on a joint that slides along it and does nothing else.

use super::{JointLoad, Strength};

/// Longest step of the integration, s. The acceleration of a step is that at its middle; 1e-4 s gives the exact slips of
/// `tests/newmark_loads.rs` within 0.01 mm.
const STEP: f64 = 1e-4;

/// Forces on the body above a joint: N normal to it, in compression, and T along it, downstream, N/m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Forces {
    normal: f64,
    shear: f64,
}

impl Forces {
    fn of(load: JointLoad) -> Self {
        Self { normal: load.normal, shear: load.shear }
    }

    /// `self + factor · other`.
    fn plus(self, factor: f64, other: Self) -> Self {
        Self { normal: self.normal + factor * other.normal, shear: self.shear + factor * other.shear }
    }
}

/// The body above a joint as a rigid block that keeps contact along the whole joint: it slides in both directions, and neither
/// rocks nor deforms.
///
/// With the ground acceleration `a` (downstream, upwards) and the slip `s` along the joint,
///
/// ```text
/// N = N₀ + a·N_a + s̈ N_s − U,  T = T₀ + a·T_a + s̈ T_s
/// at rest  |T| ≤ μN + c A,   sliding  T = ±μ_r N
/// ```
///
/// where the water takes part by Westergaard's added mass (within `T_a` and `T_s`), the uplift `U` is that at rest, and the bond
/// breaks as soon as the block slides.
///
/// **Source**: N.M. Newmark, *Effects of earthquakes on dams and embankments*, Géotechnique 15 (1965) 139–160; tested in
/// `tests/newmark_loads.rs`.
#[derive(Clone, Debug, PartialEq)]
pub struct SlidingBlock {
    at_rest: Forces,
    /// Change of the forces by an acceleration of the ground downstream and upwards, per m/s².
    ground: [Forces; 2],
    /// Change of the forces by an acceleration of the slip, per m/s².
    slip: Forces,
    /// Friction before and after the first slip.
    friction: [f64; 2],
    /// Cohesion times bonded length, N/m.
    bond: f64,
    motion: Motion,
}

/// How far the block is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Motion {
    time: f64,
    slip: f64,
    velocity: f64,
    has_slid: bool,
}

impl SlidingBlock {
    /// A block at rest at time 0 from the `loads` on the body without acceleration, with inertia of 1 g downstream, and with
    /// inertia of 1 g downwards ([`LoadCase::seismic`](super::LoadCase)), without uplift; `gravity` in m/s², the `tangent` of the joint
    /// downstream, the `uplift` (N/m), its peak and residual `strength` and the `bonded` length (m).
    pub fn new(
        loads: [JointLoad; 3],
        gravity: f64,
        tangent: [f64; 2],
        uplift: f64,
        strength: [Strength; 2],
        bonded: f64,
    ) -> Self {
        let [still, downstream, downwards] = loads.map(Forces::of);
        let nothing = Forces { normal: 0.0, shear: 0.0 };
        let per_g = |inertia: Forces, sign: f64| nothing.plus(sign / gravity, inertia.plus(-1.0, still));
        // ground that accelerates downstream pushes the body upstream; upwards, down
        let ground = [per_g(downstream, -1.0), per_g(downwards, 1.0)];
        Self {
            at_rest: Forces { normal: still.normal - uplift, ..still },
            ground,
            slip: nothing.plus(tangent[0], ground[0]).plus(tangent[1], ground[1]),
            friction: strength.map(|strength| strength.friction),
            bond: strength[0].cohesion * bonded,
            motion: Motion::default(),
        }
    }

    /// Slip so far, m, positive downstream.
    pub fn slip(&self) -> f64 {
        self.motion.slip
    }

    /// Least constant acceleration of the ground, upstream, at which the block slides downstream, m/s², with its peak strength and
    /// with the residual one; `None` if it slides without any, or if none makes it slide.
    ///
    /// With inertia `k` (as a share of g) downstream, `k = (μN₀ + cA − T₀)/(T_k − μN_k)`.
    pub fn yield_accelerations(&self) -> [Option<f64>; 2] {
        [(self.friction[0], self.bond), (self.friction[1], 0.0)].map(|(friction, bond)| {
            let reserve = friction * self.at_rest.normal + bond - self.at_rest.shear;
            // of an acceleration upstream
            let per_acceleration = friction * self.ground[0].normal - self.ground[0].shear;
            (reserve > 0.0 && per_acceleration > 0.0).then(|| reserve / per_acceleration)
        })
    }

    /// Moves the block to `time` (s), with the acceleration of the ground, downstream and upwards, m/s², at any time before.
    ///
    /// A body that the ground would leave in the air (`N < 0`) slides without friction.
    pub fn advance(&mut self, time: f64, ground: impl Fn(f64) -> [f64; 2]) {
        let begin = self.motion.time;
        let count = ((time - begin) / STEP).ceil().max(0.0) as usize;
        let step = (time - begin) / count.max(1) as f64;
        for i in 0..count {
            let [downstream, upwards] = ground(begin + (i as f64 + 0.5) * step);
            let forces = self.at_rest.plus(downstream, self.ground[0]).plus(upwards, self.ground[1]);
            self.step(step, forces);
        }
        self.motion.time = begin.max(time);
    }

    /// A step under these forces, those of the slip aside.
    fn step(&mut self, step: f64, forces: Forces) {
        let Motion { velocity, has_slid, .. } = self.motion;
        let friction = self.friction[usize::from(has_slid)];
        let bond = if has_slid { 0.0 } else { self.bond };
        if velocity == 0.0 && forces.shear.abs() <= friction * forces.normal.max(0.0) + bond {
            return;
        }
        let direction = if velocity != 0.0 { velocity.signum() } else { forces.shear.signum() };
        let sliding = if forces.normal > 0.0 { direction * self.friction[1] } else { 0.0 };
        let acceleration =
            (sliding * forces.normal - forces.shear) / (self.slip.shear - sliding * self.slip.normal);
        let next = velocity + step * acceleration;
        // a block that comes to rest within the step stays at rest until the next one
        let stops = velocity != 0.0 && next * velocity <= 0.0;
        self.motion.slip +=
            if stops { -0.5 * velocity * velocity / acceleration } else { step * (velocity + next) / 2.0 };
        self.motion.velocity = if stops { 0.0 } else { next };
        self.motion.has_slid = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAVITY: f64 = 10.0;

    /// A block of 1 kg on a plane inclined by `angle`, downstream down.
    fn inclined(angle: f64, strength: [Strength; 2], bonded: f64) -> SlidingBlock {
        let (sine, cosine) = angle.sin_cos();
        // inertia (x downstream, y down) along and normal to the plane, with the weight
        let load = |x: f64, y: f64| JointLoad {
            normal: GRAVITY * ((1.0 + y) * cosine - x * sine),
            shear: GRAVITY * ((1.0 + y) * sine + x * cosine),
            moment: 0.0,
        };
        let loads = [load(0.0, 0.0), load(1.0, 0.0), load(0.0, 1.0)];
        SlidingBlock::new(loads, GRAVITY, [cosine, -sine], 0.0, strength, bonded)
    }

    fn rough(friction: f64) -> [Strength; 2] {
        [Strength { friction, ..Strength::default() }; 2]
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} instead of {expected}");
    }

    /// `s̈ = g(sin θ − μ cos θ)` on ground at rest; on ground that falls at g nothing presses the block.
    #[test]
    fn block_slides_down_a_steep_plane() {
        let mut block = inclined(0.5, rough(0.3), 0.0);
        block.advance(2.0, |_| [0.0; 2]);
        near(block.slip(), GRAVITY * (0.5f64.sin() - 0.3 * 0.5f64.cos()) * 2.0);
        assert_eq!(block.yield_accelerations(), [None; 2]);
        let mut falling = inclined(0.5, rough(0.3), 0.0);
        falling.advance(2.0, |_| [0.0, -GRAVITY]);
        near(1.0 + falling.slip(), 1.0);
    }

    /// `k = tan(φ − θ)` of a block on a plane that falls downstream by θ, and the slip of a rectangular pulse from there.
    #[test]
    fn yield_acceleration_is_the_tangent_of_what_friction_leaves() {
        let (angle, friction) = (0.1, 0.5f64);
        let mut block = inclined(angle, rough(friction), 0.0);
        let yields = (friction.atan() - angle).tan() * GRAVITY;
        near(block.yield_accelerations()[0].expect("stable at rest"), yields);
        let below = 0.999 * yields;
        block.advance(5.0, |_| [-below, 0.0]);
        assert_eq!(block.slip(), 0.0);
        // downstream inertia A: s̈ = (A − k) cos(φ − θ)/cos φ, also when the pulse is over
        let (pulse, duration) = (2.0 * yields, 0.25);
        let share = (friction.atan() - angle).cos() / friction.atan().cos();
        let velocity = (pulse - yields) * share * duration;
        let expected = velocity * duration / 2.0 + velocity * velocity / (2.0 * yields * share);
        block.advance(9.0, |time| [if time < 5.25 { -pulse } else { 0.0 }, 0.0]);
        near(block.slip(), expected);
    }

    /// Cohesion holds until the first slip; from then on the residual strength does.
    #[test]
    fn bond_breaks_at_the_first_slip() {
        let strength = [Strength { friction: 0.6, cohesion: 1.0, tensile_strength: 0.0 }, rough(0.4)[0]];
        let block = inclined(0.0, strength, 3.0);
        let yields = block.yield_accelerations().map(|found| found.expect("stable at rest"));
        near(yields[0], 0.6 * GRAVITY + 3.0);
        near(yields[1], 0.4 * GRAVITY);
        let pulse = |size: f64| {
            let mut block = block.clone();
            block.advance(20.0, |time| [if time < 0.5 { -size } else { 0.0 }, 0.0]);
            block.slip()
        };
        assert_eq!(pulse(8.99), 0.0);
        near(pulse(9.01), crate::analytical::newmark_1965::rectangular_pulse_slip(4.0, 9.01, 0.5));
    }
}
