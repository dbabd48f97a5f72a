use crate::boundary::BoundaryMesh;
use crate::outline::Outline;
use crate::{ElementOrder, Fidelity, Method, ReservoirError};
use cofferdam_unit::variables::reservoir as variables;
use cofferdam_unit::{Variable, WetFace};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Everything a reservoir is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReservoirParameters {
    /// Interface points, from the heel up to the water level; of a tailwater as its water sees them, x from the toe into
    /// the dam.
    pub wet_face: WetFace,
    /// Of a tailwater: x of the dam's toe, m, from the heel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toe: Option<f64>,
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
    /// Gravity waves on the surface, `∂p/∂n = −s² p/g`, in place of `p = 0`.
    pub surface_waves: bool,
    /// Corners of the bed, m, from the heel upstream; from the last one on it is level. None: level from the heel on. Of a
    /// tailwater from the toe, as its water sees it: x is negative downstream.
    pub bed: Vec<[f64; 2]>,
    /// Shape functions of the boundary elements.
    pub element_order: ElementOrder,
    /// Largest length of a boundary element, m.
    pub element_size: f64,
    /// The same on bed, far end and meshed surface, m, if it is another one than on the face.
    pub bed_element_size: Option<f64>,
    /// Length of the elements at the corners, m, from where each is at most twice as long as the one before; if
    /// none, all are as long as they may.
    pub corner_element_size: Option<f64>,
    /// Distance L of the far end from the most upstream point of face and bed, m; h/2 is ample.
    pub far_end_distance: f64,
    /// Length of a communication step H, s; water without memory and the recursion take others too.
    pub communication_step: f64,
    /// Longest time that can be simulated, s; at least a communication step. Only convolutions end there.
    pub horizon: f64,
    /// How compressible water is stepped in time.
    pub method: Method,
    /// 1 if the ground acceleration has the value that is set over the whole next step; 0 if it changes linearly within it. A number, as
    /// importers of FMUs change it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub inputs_held: f64,
    /// For a master that repeats no step and a dam whose mass contains
    /// [`Reservoir::instantaneous_added_mass`](crate::Reservoir::instantaneous_added_mass): the pressure is only the rest, and
    /// that of the step to come.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub explicit_coupling: bool,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The water of [`before`](ReservoirParameters::before) in front of a vertical face of 100 m with 40 panels.
impl Default for ReservoirParameters {
    fn default() -> Self {
        Self::before(WetFace::default())
    }
}

/// Wave reflection coefficient from which on no recursion was found passive but over a level, rigid bed.
pub(crate) const ALMOST_RIGID: f64 = 0.995;

/// Samples of the frequency response that a recursion takes, at most, a cut-off frequency.
const SAMPLES: f64 = 45.0;

impl ReservoirParameters {
    /// Compressible water of 1000 kg/m³ and 1440 m/s before `wet_face`, over a rigid level bed; linear elements of
    /// h/16, the far end at h/2, steps of 2.5 ms for 20 s by [`Method::Radau2`]. A downstream face makes a tailwater.
    pub fn before(wet_face: WetFace) -> Self {
        let (depth, toe) = (wet_face.depth(), wet_face.toe());
        Self {
            wet_face: toe.map_or(wet_face.clone(), |toe| wet_face.mirrored(toe)),
            toe,
            density: 1000.0,
            sound_speed: 1440.0,
            wave_reflection_coefficient: 1.0,
            gravity: 9.81,
            fidelity: Fidelity::Compressible,
            surface_waves: false,
            bed: Vec::new(),
            element_order: ElementOrder::Linear,
            element_size: depth / 16.0,
            bed_element_size: None,
            corner_element_size: None,
            far_end_distance: depth / 2.0,
            communication_step: 0.0025,
            horizon: 20.0,
            method: Method::Radau2,
            inputs_held: 0.0,
            explicit_coupling: false,
        }
    }

    /// The wet face in the coordinates of the dam.
    pub fn face_of_dam(&self) -> WetFace {
        self.toe.map_or_else(|| self.wet_face.clone(), |toe| self.wet_face.mirrored(toe))
    }

    /// An acceleration (x, y) of the ground as the water sees it: a tailwater counts x upstream.
    pub(crate) fn seen(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [if self.toe.is_some() { -x } else { x }, y]
    }

    /// Checks every value; making the reservoir finds out the rest.
    ///
    /// **Errors**: that of [`problem`](Self::problem).
    pub fn validate(&self) -> Result<(), ReservoirError> {
        self.problem().map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Whether it is a channel of constant depth before a vertical face, without gravity waves.
    pub(crate) fn is_channel(&self) -> bool {
        self.wet_face.points().iter().all(|point| point[0] == 0.0)
            && self.bed.iter().all(|corner| corner[1] == 0.0)
            && !self.surface_waves
    }

    /// Whether a recursion is worth a try: not with gravity waves, nor over an almost rigid bed, unless it is level and rigid.
    pub(crate) fn may_be_fitted(&self) -> bool {
        let alpha = self.wave_reflection_coefficient;
        let rigid = alpha == 1.0 && self.is_channel();
        !self.surface_waves && (alpha < ALMOST_RIGID || rigid)
    }

    /// The first value that is wrong: the parameter to change, and why.
    pub fn problem(&self) -> Option<(&'static str, ReservoirError)> {
        if let Some(x) = self.wet_face.toe() {
            return Some(("wet_face", ReservoirError::NotFromTheToe { x }));
        }
        if let Some(toe) = self.toe.filter(|toe| !(*toe > 0.0 && toe.is_finite())) {
            let error = ReservoirError::NotPositive { parameter: "toe", value: toe, unit: "m" };
            return Some(("toe", error));
        }
        let alpha = self.wave_reflection_coefficient;
        if !(0.0..=1.0).contains(&alpha) {
            let error = ReservoirError::WaveReflectionCoefficient { value: alpha };
            return Some(("wave_reflection_coefficient", error));
        }
        for (parameter, value, unit) in [
            ("density", self.density, "kg/m³"),
            ("sound_speed", self.sound_speed, "m/s"),
            ("gravity", self.gravity, "m/s²"),
            ("element_size", self.element_size, "m"),
            ("far_end_distance", self.far_end_distance, "m"),
            ("communication_step", self.communication_step, "s"),
            ("horizon", self.horizon, "s"),
            ("bed_element_size", self.bed_element_size.unwrap_or(1.0), "m"),
            ("corner_element_size", self.corner_element_size.unwrap_or(1.0), "m"),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Some((parameter, ReservoirError::NotPositive { parameter, value, unit }));
            }
        }
        if !self.fidelity.supports_surface_waves() && self.surface_waves {
            let (what, remedy) = ("Westergaard's water", "unset `surface_waves` or choose another fidelity");
            return Some(("surface_waves", ReservoirError::GravityWaves { what, remedy }));
        }
        let memory = self.fidelity.has_memory();
        if memory && !self.method.supports_surface_waves() && self.surface_waves {
            let (what, remedy) = ("a recursion", "unset `surface_waves` or choose another method");
            return Some(("surface_waves", ReservoirError::GravityWaves { what, remedy }));
        }
        let (horizon, communication_step) = (self.horizon, self.communication_step);
        if memory && self.method.has_horizon() && horizon < communication_step {
            return Some(("horizon", ReservoirError::HorizonTooShort { horizon, communication_step }));
        }
        match Outline::new(self) {
            Ok(outline) => self.too_large(&outline),
            Err(error) => Some(("bed", error)),
        }
    }

    /// What no machine can hold, found before memory is asked for it.
    fn too_large(&self, outline: &Outline) -> Option<(&'static str, ReservoirError)> {
        let (depth, points) = (self.channel_depth(), self.wet_face.len() as f64);
        let steps = self.horizon / self.communication_step;
        let elements = BoundaryMesh::count(outline, self);
        let cut_offs = 8.0 * depth / (PI * self.sound_speed * self.communication_step);
        let (solved, memory) = (self.fidelity.is_solved(), self.fidelity.has_memory());
        let fitted = self.method == Method::Automatic && self.may_be_fitted();
        let convolved = memory && self.method.has_horizon() && !fitted;
        let weights = steps * points * points;
        let sampled = SAMPLES * f64::max(8.0, 60.0 * depth / self.sound_speed) * points * points;
        let recursive = memory && (fitted || self.method == Method::Recursive);
        let finer_bed = self.bed_element_size.is_some_and(|size| size < self.element_size);
        let size = if finer_bed { "bed_element_size" } else { "element_size" };
        let limits = [
            (
                solved,
                size,
                "boundary elements",
                elements,
                3e3,
                "raise `element_size`, or lower `far_end_distance`",
            ),
            (
                convolved,
                "communication_step",
                "communication steps",
                steps,
                1e6,
                "shorten `horizon`, or lengthen the steps",
            ),
            (
                convolved,
                "communication_step",
                "convolution weights",
                weights,
                1e9,
                "shorten `horizon`, or take fewer points",
            ),
            (
                convolved,
                "communication_step",
                "cut-off frequencies",
                cut_offs,
                1e5,
                "raise `sound_speed`, or lengthen the steps",
            ),
            (recursive, "interface_size", "entries of sampled responses", sampled, 5e7, "take fewer points"),
            (
                !memory,
                "interface_size",
                "entries of the added mass",
                points * points,
                1e8,
                "take fewer points",
            ),
        ];
        let beyond = limits.into_iter().find(|(applies, _, _, value, most, _)| *applies && value > most);
        beyond.map(|(_, key, what, value, most, remedy)| {
            (key, ReservoirError::TooMuch { what, value, most, remedy })
        })
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
            variables::INPUTS_HELD => vec![&mut self.inputs_held],
            _ => Vec::new(),
        }
    }

    /// Admittance of the bed `q = (1 − α)/((1 + α) c)`, s/m.
    pub(crate) fn bed_admittance(&self) -> f64 {
        let alpha = self.wave_reflection_coefficient;
        (1.0 - alpha) / ((1.0 + alpha) * self.sound_speed)
    }

    /// Depth of the channel upstream of the bed's last corner, m.
    pub(crate) fn channel_depth(&self) -> f64 {
        self.wet_face.depth() - self.bed.last().map_or(0.0, |corner| corner[1])
    }

    /// Number of communication steps in the horizon.
    pub(crate) fn steps(&self) -> usize {
        (self.horizon / self.communication_step * (1.0 - 1e-9)).ceil() as usize
    }

    /// Branch points of the symbol (1/s): s = 0, where the kernel's logarithm is, and the cut-off
    /// frequencies `(2m − 1)iπc/2d + (c/2d) ln α` of the channel of depth d that matter on the contour.
    ///
    /// At cut-off κ = 0, so λ = ω/c and `e^{2iλd} = −(λ − ωq)/(λ + ωq) = −α`.
    pub(crate) fn branch_points(&self) -> Vec<Complex64> {
        let rate = self.sound_speed / (2.0 * self.channel_depth());
        let damping = rate * self.wave_reflection_coefficient.ln();
        let largest = 8.0 / self.communication_step;
        let cut_offs = (0..)
            .map(|m| PI * rate * f64::from(2 * m + 1))
            .take_while(|omega| *omega < largest && damping.is_finite())
            .map(|omega| Complex64::new(damping, omega));
        std::iter::once(Complex64::ZERO).chain(cut_offs).collect()
    }
}
