use super::{Channel, Description, Layout, Occasion, Participant, ParticipantError};
use interface::{Capabilities, Fingerprint, Shape, StateError, Variable, WetFace, variables::reservoir};

/// Stands in for a reservoir without water: no pressure, neither hydrostatic nor hydrodynamic.
///
/// Its inputs are the reservoir's, and have no effect. It has no state, takes steps of any length, and costs nothing:
/// with [`SerialExplicit`](crate::scheme::SchemeKind::SerialExplicit), whose first guess is its answer, a run is the dam alone.
pub struct EmptyReservoir {
    description: Description,
    face: WetFace,
}

const INPUTS: [Variable; 2] = [reservoir::INTERFACE_ACCELERATION, reservoir::GROUND_ACCELERATION];
const FIXED: [Variable; 3] =
    [reservoir::HYDROSTATIC_PRESSURE, reservoir::INTERFACE_X, reservoir::INTERFACE_Y];
const OUTPUTS: [Variable; 1] = [reservoir::INTERFACE_PRESSURE];

impl EmptyReservoir {
    /// No water before `face`.
    ///
    /// **Errors**: the face cannot be hashed.
    pub fn new(face: WetFace) -> Result<Self, StateError> {
        let channel = |v: &Variable| Channel {
            name: v.name.to_owned(),
            value_reference: v.value_reference,
            unit: v.unit.to_owned(),
            size: if v.shape == Shape::Plane { 2 } else { face.len() },
            array: true,
        };
        let description = Description {
            name: "reservoir".to_owned(),
            solver: format!("empty {}", env!("CARGO_PKG_VERSION")),
            fingerprint: Fingerprint::of("empty reservoir", &face)?,
            inputs: Layout::new(INPUTS.iter().map(channel).collect()),
            outputs: Layout::new(OUTPUTS.iter().map(channel).collect()),
            fixed: Layout::new(FIXED.iter().map(channel).collect()),
            capabilities: Capabilities { variable_communication_step: true, directional_derivative: false },
        };
        Ok(Self { description, face })
    }
}

impl Participant for EmptyReservoir {
    fn description(&self) -> &Description {
        &self.description
    }

    fn fixed(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let coordinate = |axis: usize| self.face.points().iter().map(|p| p[axis]).collect();
        match variable {
            "hydrostatic_pressure" => Ok(vec![0.0; self.face.len()]),
            "interface_x" => Ok(coordinate(0)),
            "interface_y" => Ok(coordinate(1)),
            _ => Err(ParticipantError::Missing {
                participant: self.description.name.clone(),
                variable: variable.to_owned(),
            }),
        }
    }

    fn initialise(
        &mut self,
        _start_time: f64,
        _inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        outputs.fill(0.0);
        Ok(())
    }

    fn step(
        &mut self,
        _occasion: &Occasion,
        _inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        outputs.fill(0.0);
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }
}
