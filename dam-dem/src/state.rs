use cofferdam_unit::{EndAcceleration, Fingerprint};
use serde::{Deserialize, Serialize};

use crate::contact::JointState;
use crate::energy::{EnergyLedger, EnergyWatch};
use crate::envelope::Envelope;
use crate::loads::Opened;
use crate::modal_field::INSTANTS;
use crate::reduction::ModalMotion;
use crate::structure::Motion;

/// Complete state of a dam: all data on which its further motion depends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DamState {
    /// Fingerprint of the dam to which the state belongs.
    pub(crate) fingerprint: Fingerprint,
    pub(crate) initialised: bool,
    pub(crate) time: f64,
    pub(crate) motion: DamMotion,
    /// Displacement in the state of rest before time 0, in the coordinates of the motion.
    pub(crate) rest: Vec<f64>,
    /// Acceleration relative to the ground, mean over the last communication step, in the coordinates of the motion.
    pub(crate) mean_acceleration: Vec<f64>,
    /// Acceleration of the ground, mean over the last communication step, m/s².
    pub(crate) mean_ground_acceleration: [f64; 2],
    /// Force on the ground, mean over the last communication step, N/m.
    pub(crate) mean_base_force: [f64; 2],
    /// Total acceleration of the wet face along its normals, m/s².
    pub(crate) interface_acceleration: EndAcceleration,
    pub(crate) energy: EnergyLedger,
    pub(crate) hydrostatic_pressure: Vec<f64>,
    /// Pressure of the water in joints at the current time, at each contact, Pa; empty without uplift.
    pub(crate) uplift: Vec<f64>,
    /// How far each joint with water was open at rest, m.
    pub(crate) opened_at_rest: Vec<Opened>,
    /// Inputs at the current time.
    pub(crate) accepted: Inputs,
    /// Inputs for the end of the next step.
    pub(crate) next: Inputs,
    /// What was seen of the energy balance up to the last step.
    pub(crate) energy_watch: EnergyWatch,
    /// What is kept of stresses and motion up to now, if it is.
    pub(crate) envelope: Option<Envelope>,
}

/// Motion relative to the ground, in the coordinates of the dam's level of fidelity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum DamMotion {
    /// Motion of all nodes: x, then y of each, m.
    Nodes(Motion),
    /// Motion of the modes.
    Modes(ModalMotion),
}

impl DamMotion {
    /// Displacement, one value for each coordinate.
    pub fn displacement(&self) -> &[f64] {
        match self {
            Self::Nodes(motion) => motion.displacement.as_flattened(),
            Self::Modes(motion) => &motion.coordinates,
        }
    }

    /// Rate of the displacement.
    pub fn velocity(&self) -> &[f64] {
        match self {
            Self::Nodes(motion) => motion.velocity.as_flattened(),
            Self::Modes(motion) => &motion.rates,
        }
    }

    /// States of the contacts of each crack; none in an intact dam.
    pub fn joints(&self) -> &[Vec<JointState>] {
        match self {
            Self::Nodes(motion) => &motion.joints,
            Self::Modes(motion) => &motion.joints,
        }
    }

    /// The same, to be changed.
    pub(crate) fn joints_mut(&mut self) -> &mut [Vec<JointState>] {
        match self {
            Self::Nodes(motion) => &mut motion.joints,
            Self::Modes(motion) => &mut motion.joints,
        }
    }

    /// Motion of all nodes, if these are the coordinates.
    pub fn of_nodes(&self) -> Option<&Motion> {
        match self {
            Self::Nodes(motion) => Some(motion),
            Self::Modes(_) => None,
        }
    }
}

/// Inputs at one communication point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Inputs {
    pub pressure: Vec<f64>,
    pub ground_acceleration: [f64; 2],
}

impl DamState {
    /// Whether this state has the same coordinates and the same numbers of nodes, cells, contacts and
    /// interface points as `other`.
    pub(crate) fn has_shape_of(&self, other: &Self) -> bool {
        let shape = |state: &Self| {
            let (coordinates, others) = match &state.motion {
                DamMotion::Nodes(motion) => (
                    motion.displacement.len(),
                    [motion.velocity.len(), motion.acceleration.len(), motion.viscous.len()],
                ),
                DamMotion::Modes(motion) => {
                    (motion.coordinates.len(), [motion.rates.len(), motion.contact_forces.len(), usize::MAX])
                }
            };
            let means = [&state.rest, &state.mean_acceleration].map(Vec::len);
            let points = [&state.hydrostatic_pressure, &state.accepted.pressure, &state.next.pressure];
            let contacts: Vec<usize> = state.motion.joints().iter().map(Vec::len).collect();
            let face = &state.interface_acceleration;
            let points = (points.map(Vec::len), state.uplift.len(), state.opened_at_rest.len());
            let envelope = state.envelope.as_ref().map(Envelope::shape);
            (coordinates, others, means, points, [face.mean.len(), face.at_end.len()], contacts, envelope)
        };
        let mut waiting = self.envelope.iter().flat_map(Envelope::waiting);
        let few = waiting.clone().count() < INSTANTS;
        shape(self) == shape(other)
            && few
            && waiting.all(|instant| instant.coordinates.len() == self.rest.len())
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Work and stored energy since the state of rest.
    pub fn energy(&self) -> &EnergyLedger {
        &self.energy
    }

    /// Motion relative to the ground.
    pub fn motion(&self) -> &DamMotion {
        &self.motion
    }
}
