use interface::Fingerprint;
use serde::{Deserialize, Serialize};

use crate::energy::EnergyLedger;
use crate::structure::Motion;

/// Everything that the later motion of a dam depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DamState {
    /// That of the dam it belongs to.
    pub(crate) fingerprint: Fingerprint,
    pub(crate) initialised: bool,
    pub(crate) time: f64,
    pub(crate) motion: Motion,
    /// Displacement in the state of rest before time 0, m.
    pub(crate) rest: Vec<[f64; 2]>,
    /// Total acceleration, mean over the last communication step, m/s².
    pub(crate) mean_acceleration: Vec<[f64; 2]>,
    pub(crate) energy: EnergyLedger,
    pub(crate) hydrostatic_pressure: Vec<f64>,
    /// Inputs at the current time.
    pub(crate) accepted: Inputs,
    /// Inputs for the end of the next step.
    pub(crate) next: Inputs,
}

/// Inputs at one communication point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Inputs {
    pub pressure: Vec<f64>,
    pub ground_acceleration: [f64; 2],
}

impl DamState {
    /// Whether this state has as many nodes, cells, contacts and interface points as `other`.
    pub(crate) fn has_shape_of(&self, other: &Self) -> bool {
        let shape = |state: &Self| {
            let motion = &state.motion;
            let nodes = [&motion.displacement, &motion.velocity, &motion.acceleration, &state.rest];
            let points = [&state.hydrostatic_pressure, &state.accepted.pressure, &state.next.pressure];
            let contacts: Vec<usize> = motion.joints.iter().map(Vec::len).collect();
            let others = [motion.viscous.len(), state.mean_acceleration.len()];
            (nodes.map(Vec::len), points.map(Vec::len), others, contacts)
        };
        shape(self) == shape(other)
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Work and stored energy since the state of rest.
    pub fn energy(&self) -> &EnergyLedger {
        &self.energy
    }

    /// Motion of the nodes, relative to the ground.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }
}
