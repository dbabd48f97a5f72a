//! Explicit coupling: the pressure that does not depend on the motion of the step to come.
//!
//! Over equal steps H the pressure at the end of step n is linear in the means ā of the face's acceleration over the steps so
//! far. A₀ ([`Reservoir::instantaneous_added_mass`]) belongs to the last of them:
//!
//! ```text
//! p_n = −A₀ ā_n + r_n,    r_n from ā_1 … ā_{n−1} and the ground
//! ```
//!
//! A dam with A₀ in its mass matrix solves for ā_n together with −A₀ ā_n, so that only r_n is exchanged, which is known before
//! the step. A master that steps all units at once and then passes their outputs on gives the water ā_n in step n + 1, while
//! the dam needs r_{n+2} after it. Therefore, in step n + 1,
//!
//! ```text
//! ā_{n+1} ≈ 2 ā_n − ā_{n−1}
//! output  = r_{n+2} + ½ A₀ (ā_{n+1} − ā_n)
//! ```
//!
//! The dam's pressure is linear over a step where −A₀ ā is constant. The last term makes up for half a step of it, the difference
//! of their impulses, ½ A₀ (ā_{n+2} − ā_{n+1}) H, up to third order.

use super::input::Input;
use super::{Model, Motion, Reservoir, minus};
use crate::ReservoirError;
use crate::time_domain::Memory;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// What the water knows of the past beyond its motion, and its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LookAhead {
    /// Ground acceleration at the begin of the step before, m/s².
    ground: [f64; 2],
    /// ā_{n−1}, m/s².
    mean: Vec<f64>,
    /// The output, Pa.
    pub(super) pressure: Vec<f64>,
}

impl LookAhead {
    /// That of `points` points at rest.
    pub(super) fn at_rest(points: usize) -> Self {
        Self { ground: [0.0; 2], mean: vec![0.0; points], pressure: vec![0.0; points] }
    }

    /// Whether it has the values of `points` points.
    pub(super) fn is_of(&self, points: usize) -> bool {
        self.mean.len() == points && self.pressure.len() == points
    }
}

/// A step to come: mean acceleration of the face, and acceleration of the ground at begin and end.
type Coming<'a> = (&'a [f64], [[f64; 2]; 2]);

impl Reservoir {
    /// A₀ with `p_n = −A₀ ā_n + …`: the part of the pressure at the end of a step (Pa) that is due to the mean acceleration
    /// over it (m/s²), kg/m².
    ///
    /// Of compressible water `−H W₀`, about ρ c H: as much water as a wave passes in a step. Of water without memory the
    /// [`added_mass`](crate::added_mass()).
    pub fn instantaneous_added_mass(&self) -> DMatrix<f64> {
        let points = self.parameters.wet_face.len();
        match &self.model {
            Model::AddedMass(mass) => mass.columns(0, points).into_owned(),
            Model::Memory(water) => {
                let length = self.parameters.communication_step;
                water.instantaneous(length).columns(0, points) * -length
            }
        }
    }

    /// The output at the start: that of the first step, during which nothing is known of the motion.
    pub(super) fn look_from_rest(
        &self,
        motion: &Motion,
        memory: &Memory,
        ahead: &mut LookAhead,
    ) -> Result<(), ReservoirError> {
        let (still, ground) = (vec![0.0; ahead.mean.len()], motion.ground_acceleration);
        ahead.ground = ground;
        ahead.pressure = self.without_answer(motion, memory, &[(&still, [ground; 2])])?;
        Ok(())
    }

    /// Takes a step of the importer, the number of which `motion` already counts: the water itself takes the one before.
    pub(super) fn step_and_look_ahead(
        &self,
        motion: &mut Motion,
        memory: &mut Memory,
        ahead: &mut LookAhead,
    ) -> Result<(), ReservoirError> {
        let (step, length) = (motion.steps, self.parameters.communication_step);
        let [before, begin, end] =
            [ahead.ground, motion.last_ground_acceleration, motion.ground_acceleration];
        // In the first step the input is no mean over a step.
        if step > 1 {
            self.advance(motion, memory, [before, begin], 1, length)?;
        }
        let mean = &motion.acceleration;
        let linear = |(a, before): (&f64, &f64)| if step > 2 { 2.0 * a - before } else { *a };
        let next: Vec<f64> = mean.iter().zip(&ahead.mean).map(linear).collect();
        let still = vec![0.0; next.len()];
        let beyond = [0, 1].map(|axis| 2.0 * end[axis] - begin[axis]);
        let coming = [(&next[..], [begin, end]), (&still, [end, beyond])];
        let mut pressure = self.without_answer(motion, memory, &coming)?;
        if let Some(mass) = &self.mass_of_step {
            let change =
                DVector::from_iterator(next.len(), next.iter().zip(mean).map(|(next, mean)| next - mean));
            pressure.iter_mut().zip(&(mass * change)).for_each(|(p, change)| *p += 0.5 * change);
        }
        (ahead.pressure, ahead.ground, ahead.mean) = (pressure, begin, motion.acceleration.clone());
        Ok(())
    }

    /// The pressure at the end of the steps to come, the last of them without acceleration of the face.
    fn without_answer(
        &self,
        motion: &Motion,
        memory: &Memory,
        coming: &[Coming<'_>],
    ) -> Result<Vec<f64>, ReservoirError> {
        let seen = |ground: &[[f64; 2]; 2]| ground.map(|ground| self.parameters.seen(ground));
        match &self.model {
            Model::AddedMass(mass) => {
                let ground = coming.last().map_or([0.0; 2], |(_, ground)| seen(ground)[1]);
                Ok(minus(mass.columns(mass.ncols() - 2, 2) * DVector::from(ground.to_vec())))
            }
            Model::Memory(water) => {
                let (mut velocity, mut memory) = (motion.velocity.clone(), memory.clone());
                let mut pressure = motion.pressure.clone();
                for (face, ground) in coming {
                    let length = self.parameters.communication_step;
                    let input = Input { face, ground: seen(ground), own_steps: 1, length };
                    let answer = input.drive(&**water, &mut velocity, &mut memory);
                    pressure = answer.ok_or(ReservoirError::ForeignMemory)?;
                }
                Ok(pressure)
            }
        }
    }
}
