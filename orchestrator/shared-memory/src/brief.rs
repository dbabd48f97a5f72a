use cofferdam_coupling::participant::{AccelerationMeaning, ParameterValue};
use cofferdam_unit::Role;
use cofferdam_unit::WetFace;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a unit that is not ours is made from: it needs neither the scene nor a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brief {
    /// The side of the wet face on which the unit is.
    pub role: Role,
    /// The points of the wet face.
    pub points: BriefPoints,
    /// Depth of the water, m.
    pub depth: f64,
    /// Density of the water, kg/m³.
    pub density: f64,
    /// Gravitational acceleration, m/s².
    pub gravity: f64,
    /// Length H of a communication step, s; the first one, where it may vary.
    pub communication_step: f64,
    /// Duration of the run, s.
    pub duration: f64,
    /// What the unit takes the accelerations of the interface to mean.
    pub acceleration: AccelerationMeaning,
    /// The user's own parameters.
    pub parameters: BTreeMap<String, ParameterValue>,
}

/// The points of a wet face, from the heel up: one value a point in each list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BriefPoints {
    /// Coordinate x, from the heel, positive downstream, m.
    pub x: Vec<f64>,
    /// Coordinate y, from the heel, positive upwards, m.
    pub y: Vec<f64>,
    /// x component of n, the unit normal from the water into the dam.
    pub normal_x: Vec<f64>,
    /// y component of n.
    pub normal_y: Vec<f64>,
    /// Tributary length along the face, m.
    pub tributary_length: Vec<f64>,
}

impl From<&WetFace> for BriefPoints {
    fn from(face: &WetFace) -> Self {
        let axis = |vectors: &[[f64; 2]], axis: usize| vectors.iter().map(|v| v[axis]).collect();
        let normals = face.normals();
        Self {
            x: axis(face.points(), 0),
            y: axis(face.points(), 1),
            normal_x: axis(&normals, 0),
            normal_y: axis(&normals, 1),
            tributary_length: face.tributary_lengths(),
        }
    }
}
