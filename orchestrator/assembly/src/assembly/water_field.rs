//! The pressure inside the waters of a scene, for pictures.

use super::{Assembly, AssemblyError};
use crate::observer::WaterField;
use crate::units::water_unit;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_reservoir::PressureField;
use cofferdam_scene::Side;
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

impl Assembly<'_> {
    /// The pressure inside the water on a side; none where this program computes no water.
    ///
    /// **Errors**: the water has no pressure inside, or it cannot be meshed or stepped.
    pub fn water_field(&self, side: Side) -> Result<Option<Box<dyn WaterField>>, AssemblyError> {
        if !self.computes_water(side) {
            return Ok(None);
        }
        let parameters = PressureField::usual_mesh(&self.water_parameters(side)?);
        Ok(Some(Box::new(Field { unit: water_unit(side), field: PressureField::new(&parameters)? })))
    }
}
