//! The Koyna dam as the shipped scenes have it, for tests that build it without a scene.

use cofferdam_dam::{CrackParameters, DamParameters, Kinematics, Material, Section};
use cofferdam_reservoir::ReservoirParameters;
use cofferdam_unit::WetFace;

/// Elevation of the crest, m.
pub const CREST: f64 = 103.0;
/// Elevation of the neck, m.
pub const NECK: f64 = 66.5;
/// Depth of the water, m.
pub const DEPTH: f64 = 91.75;
/// Elastic modulus, Pa.
pub const YOUNG_MODULUS: f64 = 31e9;
/// Poisson's ratio.
pub const POISSON_RATIO: f64 = 0.2;
/// Density, kg/m³.
pub const DENSITY: f64 = 2640.0;

/// Width of the section at elevation `y`, m.
pub fn width(y: f64) -> f64 {
    if y < NECK {
        70.0 + (19.25 - 70.0) * y / NECK
    } else {
        19.25 + (14.8 - 19.25) * (y - NECK) / (CREST - NECK)
    }
}

/// The dam, with or without the crack at the neck.
pub fn dam(element_size: f64, cracked: bool) -> DamParameters {
    let crack = CrackParameters::sliding(NECK, 1.0, 1e11, 0.5e11);
    DamParameters {
        section: Section::new(
            vec![[0.0, 0.0], [0.0, CREST]],
            vec![[70.0, 0.0], [19.25, NECK], [14.8, CREST]],
        ),
        water_depth: DEPTH,
        cracks: if cracked { vec![crack] } else { Vec::new() },
        material: Material {
            young_modulus: YOUNG_MODULUS,
            poisson_ratio: POISSON_RATIO,
            density: DENSITY,
            ..Default::default()
        },
        kinematics: if cracked { Kinematics::Corotational } else { Kinematics::Small },
        element_size,
        envelopes: true,
        ..Default::default()
    }
}

/// The reservoir on `wet_face`.
pub fn reservoir(wet_face: WetFace, communication_step: f64, horizon: f64) -> ReservoirParameters {
    ReservoirParameters {
        wave_reflection_coefficient: 0.9,
        element_size: DEPTH / 16.0,
        far_end_distance: DEPTH / 2.0,
        communication_step,
        horizon,
        ..ReservoirParameters::before(wet_face)
    }
}
