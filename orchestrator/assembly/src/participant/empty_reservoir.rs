use cofferdam_coupling::participant::{Description, Occasion, Participant, ParticipantError};
use cofferdam_unit::{StateError, Variable, WetFace, variables::reservoir};

/// A stand-in for the reservoir without water: both hydrostatic and hydrodynamic pressure are zero.
///
/// Its inputs are those of the reservoir and have no effect. It has no state and takes steps of any length at no
/// cost: with [`SerialExplicit`](cofferdam_coupling::scheme::SchemeKind::SerialExplicit), whose first guess equals its answer, a
/// run computes the dam alone.
pub struct EmptyReservoir {
    description: Description,
    face: WetFace,
}

const INPUTS: [Variable; 2] = [reservoir::INTERFACE_ACCELERATION, reservoir::GROUND_ACCELERATION];
const FIXED: [Variable; 3] =
    [reservoir::HYDROSTATIC_PRESSURE, reservoir::INTERFACE_X, reservoir::INTERFACE_Y];
const OUTPUTS: [Variable; 1] = [reservoir::INTERFACE_PRESSURE];

impl EmptyReservoir {
    /// No water at `face`.
    ///
    /// **Errors**: the face cannot be hashed.
    pub fn new(face: WetFace) -> Result<Self, StateError> {
        let variables = [INPUTS.as_slice(), &OUTPUTS, &FIXED];
        let description = Description::of_stand_in("reservoir", "empty reservoir", &face, variables)?;
        Ok(Self { description, face })
    }
}

impl Participant for EmptyReservoir {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let coordinate = |axis: usize| self.face.points().iter().map(|p| p[axis]).collect();
        match variable {
            "hydrostatic_pressure" => Ok(vec![0.0; self.face.len()]),
            "interface_x" => Ok(coordinate(0)),
            "interface_y" => Ok(coordinate(1)),
            _ => Err(self.description.missing(variable)),
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

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        // A state without a byte would be none in the log.
        Ok(Some(vec![0]))
    }

    fn deserialise(&mut self, _state: &[u8]) -> Result<(), ParticipantError> {
        Ok(())
    }
}
