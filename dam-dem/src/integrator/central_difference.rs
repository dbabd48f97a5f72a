use crate::contact::ContactLaw;
use crate::energy::Work;
use crate::loads::LoadPath;
use crate::structure::{Motion, Structure};

/// Central differences as kick, drift, kick:
///
/// ```text
/// vⁿ⁺½ = vⁿ + Δt/2 aⁿ
/// uⁿ⁺¹ = uⁿ + Δt vⁿ⁺½
/// aⁿ⁺¹ = M⁻¹ (F(tⁿ⁺¹) − F_int(uⁿ⁺¹) − C vⁿ⁺½)
/// vⁿ⁺¹ = vⁿ⁺½ + Δt/2 aⁿ⁺¹
/// ```
///
/// M is the lumped mass, with the dense [`AddedMass`](crate::AddedMass) of the wet nodes if there is any.
///
/// Second order for the elastic part; damping lags by half a step, its stiffness part also by its memory
/// ([`StiffnessDamping`](crate::StiffnessDamping)), which keeps the scheme explicit and only shifts the limit of
/// stability ([`CriticalTimeStep`](crate::CriticalTimeStep)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentralDifference {
    /// Δt, s.
    pub time_step: f64,
    /// Number of time steps.
    pub steps: usize,
}

impl CentralDifference {
    /// The fewest equal time steps, none longer than `limit` (s), that make up `duration` (s).
    pub fn covering(duration: f64, limit: f64) -> Self {
        let steps = (duration / limit).ceil().max(1.0);
        Self { time_step: duration / steps, steps: steps as usize }
    }

    /// Advances `motion`, whose acceleration must be that of its start, under `loads`, which vary over all
    /// the steps; adds what was done to `work`.
    pub fn advance(
        &self,
        structure: &Structure<impl ContactLaw>,
        motion: &mut Motion,
        loads: &LoadPath,
        work: &mut Work,
    ) {
        let dt = self.time_step;
        let damping = structure.damping;
        let mut forces = vec![[0.0; 2]; motion.displacement.len()];
        kick(motion, dt / 2.0);
        for step in 0..self.steps {
            let share = |n: f64| n / self.steps as f64;
            let (middle, end) = (share(step as f64 + 0.5), share(step as f64 + 1.0));
            let mut input = 0.0;
            for ((((u, v), f), start), change) in motion
                .displacement
                .iter_mut()
                .zip(&motion.velocity)
                .zip(&mut forces)
                .zip(&loads.start)
                .zip(&loads.change)
            {
                for d in 0..2 {
                    u[d] += dt * v[d];
                    input += v[d] * (start[d] + middle * change[d]);
                    f[d] = start[d] + end * change[d];
                }
            }
            let losses = structure.add_internal_forces(motion, structure.stiffness_damping(), &mut forces);
            if let Some(water) = &structure.added_mass {
                water.take_share(&mut forces, &motion.velocity, &structure.mass, damping.mass);
            }
            let advance = if step + 1 < self.steps { dt } else { dt / 2.0 };
            work.damping += dt * structure.damp_locally(&motion.velocity, &mut forces);
            let mut twice_kinetic = 0.0;
            for ((((a, v), f), m), inverse) in motion
                .acceleration
                .iter_mut()
                .zip(&mut motion.velocity)
                .zip(&forces)
                .zip(&structure.mass)
                .zip(&structure.inverse_mass)
            {
                twice_kinetic += m * (v[0] * v[0] + v[1] * v[1]);
                for d in 0..2 {
                    a[d] = f[d] * inverse - damping.mass * v[d];
                    v[d] += advance * a[d];
                }
            }
            work.input += dt * input;
            work.friction += losses.friction;
            work.damping += dt * (losses.damping_power + damping.mass * twice_kinetic);
        }
    }
}

fn kick(motion: &mut Motion, duration: f64) {
    for (v, a) in motion.velocity.iter_mut().zip(&motion.acceleration) {
        v[0] += duration * a[0];
        v[1] += duration * a[1];
    }
}

/// Velocity around which the sign of local damping changes, m/s: with a jump the dam's motion would be no continuous
/// function of the pressure on it.
const STANDSTILL: f64 = 1e-3;

impl<L: ContactLaw> Structure<L> {
    /// Takes local damping `κ |F| v/√(v² + v₀²)` off `forces` (N/m); returns its power, W/m.
    fn damp_locally(&self, velocity: &[[f64; 2]], forces: &mut [[f64; 2]]) -> f64 {
        let mut power = 0.0;
        if self.local_damping == 0.0 {
            return power;
        }
        let free =
            self.inverse_mass.iter().map(|inverse| if *inverse > 0.0 { self.local_damping } else { 0.0 });
        for ((force, v), coefficient) in forces.iter_mut().zip(velocity).zip(free) {
            for d in 0..2 {
                let damping = coefficient * force[d].abs() * v[d] / v[d].hypot(STANDSTILL);
                power += damping * v[d];
                force[d] -= damping;
            }
        }
        power
    }

    /// Sets the acceleration of `motion` to that under `forces` (N/m).
    ///
    /// **Call order**: once, at the start: it takes one step of the damping's memory.
    pub fn accelerate(&self, motion: &mut Motion, forces: &[[f64; 2]]) {
        let mut total = forces.to_vec();
        self.add_internal_forces(motion, self.stiffness_damping(), &mut total);
        if let Some(water) = &self.added_mass {
            water.take_share(&mut total, &motion.velocity, &self.mass, self.damping.mass);
        }
        for (i, force) in total.iter().enumerate() {
            let v = motion.velocity[i];
            motion.acceleration[i] =
                [0, 1].map(|d| force[d] * self.inverse_mass[i] - self.damping.mass * v[d]);
        }
    }
}
