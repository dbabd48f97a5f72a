use crate::time_domain::{Memory, TimeDomain};

/// The motion over a communication step of several `own_steps`, each of `length` (s).
pub(super) struct Input<'a> {
    /// Mean acceleration of the face, constant over the communication step, m/s².
    pub(super) face: &'a [f64],
    /// Acceleration of the ground at its begin and end, linear in between, m/s².
    pub(super) ground: [[f64; 2]; 2],
    pub(super) own_steps: usize,
    pub(super) length: f64,
}

impl Input<'_> {
    /// Takes the steps from `velocity` and `memory`; returns the pressure at the end, none for a foreign memory.
    pub(super) fn drive(
        &self,
        water: &dyn TimeDomain,
        velocity: &mut [f64],
        memory: &mut Memory,
    ) -> Option<Vec<f64>> {
        let [begin, end] = self.ground;
        let ground = |step: usize, axis: usize| match step == self.own_steps {
            true => end[axis],
            false => begin[axis] + (end[axis] - begin[axis]) * step as f64 / self.own_steps as f64,
        };
        let mut pressure = None;
        for step in 1..=self.own_steps {
            let of_ground = [0, 1].map(|axis| 0.5 * (ground(step - 1, axis) + ground(step, axis)));
            let means = self.face.iter().chain(&of_ground);
            velocity.iter_mut().zip(means).for_each(|(v, a)| *v += self.length * a);
            if step == self.own_steps {
                pressure = Some(water.pressure(memory, velocity, self.length)?);
            }
            *memory = water.push(memory, velocity, self.length)?;
        }
        pressure
    }
}
