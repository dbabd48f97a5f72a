use crate::{Fidelity, ReservoirError};
use interface::variables::reservoir as variables;
use interface::{Variable, WetFace};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Everything a reservoir is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReservoirParameters {
    /// Interface points, from the heel up to the water level.
    pub wet_face: WetFace,
    /// Density of the water ρ, kg/m³.
    pub density: f64,
    /// Speed of sound in the water c, m/s.
    pub sound_speed: f64,
    /// Wave reflection coefficient of the bed α, from 0 (absorbing) to 1 (rigid).
    pub wave_reflection_coefficient: f64,
    /// Gravitational acceleration, m/s².
    pub gravity: f64,
    /// Model of the water.
    pub fidelity: Fidelity,
    /// Largest length of a boundary element, m.
    pub element_size: f64,
    /// Distance L of the far end from the face's most upstream point, m; h/2 is ample.
    pub far_end_distance: f64,
    /// Length of a communication step H, s; water without memory takes others too.
    pub communication_step: f64,
    /// Longest time that can be simulated, s; at least a communication step. Without effect on water without memory.
    pub horizon: f64,
}

impl ReservoirParameters {
    /// Checks every value; making the reservoir finds out the rest.
    ///
    /// **Errors**: the [`ReservoirError`] that names the parameter.
    pub fn validate(&self) -> Result<(), ReservoirError> {
        let alpha = self.wave_reflection_coefficient;
        if !(0.0..=1.0).contains(&alpha) {
            return Err(ReservoirError::WaveReflectionCoefficient { value: alpha });
        }
        for (parameter, value, unit) in [
            ("density", self.density, "kg/m³"),
            ("sound_speed", self.sound_speed, "m/s"),
            ("gravity", self.gravity, "m/s²"),
            ("element_size", self.element_size, "m"),
            ("far_end_distance", self.far_end_distance, "m"),
            ("communication_step", self.communication_step, "s"),
            ("horizon", self.horizon, "s"),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ReservoirError::NotPositive { parameter, value, unit });
            }
        }
        let (horizon, communication_step) = (self.horizon, self.communication_step);
        if self.fidelity.has_memory() && horizon < communication_step {
            return Err(ReservoirError::HorizonTooShort { horizon, communication_step });
        }
        self.check_size()
    }

    /// Refuses what no machine can hold, before memory is asked for it.
    fn check_size(&self) -> Result<(), ReservoirError> {
        let (depth, points) = (self.wet_face.depth(), self.wet_face.len() as f64);
        let steps = self.horizon / self.communication_step;
        let elements = (2.0 * depth + self.far_end_distance) / self.element_size;
        let cut_offs = 8.0 * depth / (PI * self.sound_speed * self.communication_step);
        let (solved, memory) = (self.fidelity != Fidelity::Westergaard, self.fidelity.has_memory());
        let weights = steps * points * points;
        for (applies, what, value, most, remedy) in [
            (solved, "boundary elements", elements, 2e3, "raise `element_size`, or lower `far_end_distance`"),
            (memory, "communication steps", steps, 1e6, "shorten `horizon`, or lengthen the steps"),
            (memory, "convolution weights", weights, 1e9, "shorten `horizon`, or take fewer points"),
            (memory, "cut-off frequencies", cut_offs, 1e5, "raise `sound_speed`, or lengthen the steps"),
            (!memory, "entries of the added mass", points * points, 1e8, "take fewer points"),
        ] {
            if applies && value > most {
                return Err(ReservoirError::TooMuch { what, value, most, remedy });
            }
        }
        Ok(())
    }

    /// The numbers behind a variable that an importer may change.
    pub(crate) fn numbers(&mut self, variable: &Variable) -> Vec<&mut f64> {
        match *variable {
            variables::WATER_DENSITY => vec![&mut self.density],
            variables::SOUND_SPEED => vec![&mut self.sound_speed],
            variables::WAVE_REFLECTION_COEFFICIENT => vec![&mut self.wave_reflection_coefficient],
            variables::GRAVITY => vec![&mut self.gravity],
            variables::ELEMENT_SIZE => vec![&mut self.element_size],
            variables::FAR_END_DISTANCE => vec![&mut self.far_end_distance],
            variables::HORIZON => vec![&mut self.horizon],
            _ => Vec::new(),
        }
    }

    /// Admittance of the bed `q = (1 − α)/((1 + α) c)`, s/m.
    pub(crate) fn bed_admittance(&self) -> f64 {
        let alpha = self.wave_reflection_coefficient;
        (1.0 - alpha) / ((1.0 + alpha) * self.sound_speed)
    }

    /// Number of communication steps in the horizon.
    pub(crate) fn steps(&self) -> usize {
        (self.horizon / self.communication_step * (1.0 - 1e-9)).ceil() as usize
    }

    /// Branch points of the symbol (1/s): s = 0, where the kernel's logarithm is, and the cut-off
    /// frequencies `(2m − 1)iπc/2h + (c/2h) ln α` that matter on the contour.
    ///
    /// At cut-off κ = 0, so λ = ω/c and `e^{2iλh} = −(λ − ωq)/(λ + ωq) = −α`.
    pub(crate) fn branch_points(&self) -> Vec<Complex64> {
        let rate = self.sound_speed / (2.0 * self.wet_face.depth());
        let damping = rate * self.wave_reflection_coefficient.ln();
        let largest = 8.0 / self.communication_step;
        let cut_offs = (0..)
            .map(|m| PI * rate * f64::from(2 * m + 1))
            .take_while(|omega| *omega < largest && damping.is_finite())
            .map(|omega| Complex64::new(damping, omega));
        std::iter::once(Complex64::ZERO).chain(cut_offs).collect()
    }
}
