use crate::ReservoirParameters;

/// The water's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Density, kg/m³.
    pub density: f64,
    /// Speed of sound, m/s; infinite in incompressible water.
    pub sound_speed: f64,
    /// Admittance of the bed `q = (1 − α)/((1 + α) c)`, s/m.
    pub bed_admittance: f64,
    /// Gravitational acceleration, m/s²; none without gravity waves.
    pub gravity: Option<f64>,
}

impl Water {
    /// The water of the parameters. Incompressible water has an infinite speed of sound and a rigid bed.
    pub(crate) fn of(parameters: &ReservoirParameters) -> Self {
        let gravity = parameters.surface_waves.then_some(parameters.gravity);
        let density = parameters.density;
        if parameters.fidelity.has_memory() {
            let bed_admittance = parameters.bed_admittance();
            Self { density, sound_speed: parameters.sound_speed, bed_admittance, gravity }
        } else {
            Self { density, sound_speed: f64::INFINITY, bed_admittance: 0.0, gravity }
        }
    }
}
