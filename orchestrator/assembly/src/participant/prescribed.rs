use cofferdam_coupling::participant::{Description, Occasion, Participant, ParticipantError};
use cofferdam_unit::{EndAcceleration, StateError, Variable, WetFace, open, seal, variables::dam};
use serde::{Deserialize, Serialize};

/// A stand-in for the dam that moves rigidly with the ground.
///
/// Its inputs are those of the dam, so that the two can be exchanged; the pressure has no effect. Displacement and
/// velocity are relative to the ground and therefore zero; the total acceleration of the face along n is the mean of
/// the ground's over the step.
pub struct Prescribed {
    description: Description,
    face: WetFace,
    state: State,
    saved: State,
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    ground_acceleration: [f64; 2],
    of_face: EndAcceleration,
}

const INPUTS: [Variable; 3] = [dam::INTERFACE_PRESSURE, dam::HYDROSTATIC_PRESSURE, dam::GROUND_ACCELERATION];
const FIXED: [Variable; 2] = [dam::INTERFACE_X, dam::INTERFACE_Y];
const OUTPUTS: [Variable; 4] = [
    dam::INTERFACE_DISPLACEMENT,
    dam::INTERFACE_VELOCITY,
    dam::INTERFACE_ACCELERATION,
    dam::INTERFACE_ACCELERATION_END,
];

impl Prescribed {
    /// A rigid dam whose wet face is `face`.
    ///
    /// **Errors**: the face cannot be hashed.
    pub fn new(face: WetFace) -> Result<Self, StateError> {
        let variables = [INPUTS.as_slice(), &OUTPUTS, &FIXED];
        let description = Description::of_stand_in("dam", "prescribed", &face, variables)?;
        let state = State { ground_acceleration: [0.0; 2], of_face: EndAcceleration::at_rest(face.len()) };
        Ok(Self { description, face, saved: state.clone(), state })
    }

    fn read_ground(&self, inputs: &[f64]) -> [f64; 2] {
        let start = 2 * self.face.len();
        [inputs[start], inputs[start + 1]]
    }
}

impl Participant for Prescribed {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        match variable {
            "interface_x" => Ok(self.face.points().iter().map(|p| p[0]).collect()),
            "interface_y" => Ok(self.face.points().iter().map(|p| p[1]).collect()),
            _ => Err(self.description.missing(variable)),
        }
    }

    fn initialise(
        &mut self,
        _start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.state.ground_acceleration = self.read_ground(inputs);
        outputs.fill(0.0);
        self.save_state()
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        let end = self.read_ground(inputs);
        let mean = [0, 1].map(|i| 0.5 * (self.state.ground_acceleration[i] + end[i]));
        let along = |n: &[f64; 2]| mean[0] * n[0] + mean[1] * n[1];
        let means: Vec<f64> = self.face.normals().iter().map(along).collect();
        self.state.of_face.step(&means, occasion.communication_step);
        self.state.ground_acceleration = end;
        let points = means.len();
        outputs[..2 * points].fill(0.0);
        outputs[2 * points..3 * points].copy_from_slice(&means);
        outputs[3 * points..].copy_from_slice(&self.state.of_face.at_end);
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.saved.clone_from(&self.state);
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.state.clone_from(&self.saved);
        Ok(())
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let bytes = seal(self.description.fingerprint, &self.state);
        bytes.map(Some).map_err(|cause| self.description.no_state(cause))
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        let read: State =
            open(self.description.fingerprint, state).map_err(|cause| self.description.no_state(cause))?;
        if !read.of_face.is_of(self.face.len()) {
            return Err(self.description.no_state(StateError::NotAState { length: state.len() }));
        }
        self.state = read;
        Ok(())
    }
}
