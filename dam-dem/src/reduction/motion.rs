use serde::{Deserialize, Serialize};

use crate::contact::JointState;

/// Motion in modal coordinates, relative to the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalMotion {
    /// Coordinates q of modes with unit mass, m √(kg/m).
    pub coordinates: Vec<f64>,
    /// Rates of the coordinates.
    pub rates: Vec<f64>,
    /// Modal forces of the contacts, padded with zeros.
    pub contact_forces: Vec<f64>,
    /// States of the contacts of each crack.
    pub joints: Vec<Vec<JointState>>,
}
