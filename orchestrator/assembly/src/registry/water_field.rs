//! The pressure inside the waters of a scene, for pictures.

use super::{RegistryError, computed, parameters_of_water, unit_of};
use crate::observer::WaterField;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::{Scene, Side};
use reservoir::PressureField;
use std::error::Error;

struct Field {
    unit: UnitId,
    field: PressureField,
}

impl WaterField for Field {
    fn unit(&self) -> UnitId {
        self.unit
    }

    fn nodes(&self) -> Vec<[f64; 2]> {
        self.field.nodes()
    }

    fn triangles(&self) -> Vec<[usize; 6]> {
        self.field.triangles()
    }

    fn hydrostatic_pressure(&self) -> Vec<f64> {
        self.field.hydrostatic_pressure()
    }

    fn advance(
        &mut self,
        face: &[f64],
        ground: [[f64; 2]; 2],
        length: f64,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        Ok(self.field.advance(face, ground, length)?)
    }

    fn pressure(&self) -> Vec<f64> {
        self.field.pressure()
    }
}

/// The pressure inside the water on a side; none where this program computes no water.
///
/// **Errors**: the water has no pressure inside, or it cannot be meshed or stepped.
pub fn water_field(scene: &Scene, side: Side) -> Result<Option<Box<dyn WaterField>>, RegistryError> {
    if !computed(scene, side) {
        return Ok(None);
    }
    let parameters = PressureField::usual_mesh(&parameters_of_water(scene, side)?);
    Ok(Some(Box::new(Field { unit: unit_of(side), field: PressureField::new(&parameters)? })))
}
