//! The envelopes of the dam: sampled at the end of every step, and read.

use interface::{Variable, variables::dam as variable};
use std::sync::OnceLock;

use super::Dam;
use crate::StressRecovery;
use crate::contact::Crack;
use crate::envelope::{AtContact, AtCorner, Envelope, Sample};
use crate::material::Materials;
use crate::modal_field::ModalField;
use crate::model::Model;

/// Where stresses and displacements are sampled: at the corners of cells.
#[derive(Clone, Debug)]
pub(super) struct Sampling {
    /// The nodes of the corners.
    corners: Vec<usize>,
    /// Tensile strength at each, Pa; infinite without one.
    strengths: Vec<f64>,
    /// Their displacements, of modes.
    displacements: Option<ModalField<2>>,
}

impl Sampling {
    /// At the corners of the cells of `model`, as `recovery` has them.
    pub fn new(materials: &Materials, model: &Model, recovery: &StressRecovery) -> Self {
        let mesh = &model.body().structure.mesh;
        let corners = recovery.nodes().to_vec();
        let strength = |zone: &Option<usize>| materials.tensile_strength(*zone).unwrap_or(f64::INFINITY);
        let displacements = model.superposition().map(|modes| {
            ModalField::new(mesh, modes, &corners, |shape| corners.iter().map(|&node| shape[node]).collect())
        });
        Self { strengths: recovery.zones().iter().map(strength).collect(), displacements, corners }
    }

    /// Envelopes before the first sample.
    pub fn nothing(&self, model: &Model) -> Envelope {
        let contacts = match model.superposition() {
            Some(modes) => modes.at_rest().joints.iter().map(Vec::len).sum(),
            None => model.body().structure.cracks.iter().map(Crack::contact_count).sum(),
        };
        Envelope::new(self.corners.len(), contacts)
    }

    /// Displacements since the state of `rest`, m.
    fn since(&self, rest: &[f64], now: &[f64]) -> Vec<[f64; 2]> {
        let since: Vec<f64> = now.iter().zip(rest).map(|(now, rest)| now - rest).collect();
        match &self.displacements {
            Some(field) => field.at(&since),
            None => self.corners.iter().map(|&node| since.as_chunks().0[node]).collect(),
        }
    }
}

impl Dam {
    /// Takes the current state, at the end of a `step` (s), into the envelopes, if they are kept.
    pub(super) fn sample(&mut self, step: f64) {
        let Some(sampling) = &self.sampling else { return };
        let Some(mut envelope) = self.state.envelope.take() else { return };
        let (state, kinematics) = (&self.state, self.parameters.kinematics);
        let coordinates = state.motion.displacement();
        let stresses = self.nodal_stresses.stresses(&self.model, coordinates, kinematics);
        let displacements = sampling.since(&state.rest, coordinates);
        let sample = Sample { time: state.time, step, stresses: &stresses, displacements: &displacements };
        envelope.add(&sample, &sampling.strengths);
        envelope.add_contacts(&self.structure().cracks, state.motion.joints());
        // The outputs need the same stresses.
        self.derived.stresses = OnceLock::from(self.nodal_stresses.principal(&stresses, &self.stress_points));
        self.state.envelope = Some(envelope);
    }

    /// Values of a variable of the envelopes at all nodes or contacts; none if there are no envelopes or `variable` is another.
    pub(super) fn envelope(&self, variable: &Variable) -> Option<Vec<f64>> {
        let (sampling, envelope) = (self.sampling.as_ref()?, self.state.envelope.as_ref()?);
        let nodes = |value: fn(&AtCorner, f64) -> f64| {
            let all = envelope.at_nodes(&self.structure().mesh, &sampling.corners, &sampling.strengths);
            Some(all.iter().map(|(at, ratio)| value(at, *ratio)).collect())
        };
        let contacts = |value: fn(&AtContact) -> f64| {
            let values = envelope.contacts().iter().map(value);
            // Contacts whose sides had left each other from the beginning were never sampled.
            Some(values.map(|value| if value.is_finite() { value } else { 0.0 }).collect())
        };
        match *variable {
            variable::ENVELOPE_END => Some(vec![self.state.time]),
            variable::ENVELOPE_MAJOR_PRINCIPAL_STRESS => nodes(|at, _| at.major[0]),
            variable::ENVELOPE_MAJOR_PRINCIPAL_STRESS_TIME => nodes(|at, _| at.major[1]),
            variable::ENVELOPE_MINOR_PRINCIPAL_STRESS => nodes(|at, _| at.minor[0]),
            variable::ENVELOPE_MINOR_PRINCIPAL_STRESS_TIME => nodes(|at, _| at.minor[1]),
            variable::ENVELOPE_DISPLACEMENT_X_LEAST => nodes(|at, _| at.displacement[0][0]),
            variable::ENVELOPE_DISPLACEMENT_X_MOST => nodes(|at, _| at.displacement[0][1]),
            variable::ENVELOPE_DISPLACEMENT_Y_LEAST => nodes(|at, _| at.displacement[1][0]),
            variable::ENVELOPE_DISPLACEMENT_Y_MOST => nodes(|at, _| at.displacement[1][1]),
            variable::ENVELOPE_DISPLACEMENT_MAGNITUDE => nodes(|at, _| at.magnitude),
            variable::ENVELOPE_OVERSTRESS_DURATION => nodes(|at, _| at.overstressed),
            variable::ENVELOPE_DEMAND_CAPACITY_RATIO => nodes(|_, ratio| ratio),
            variable::ENVELOPE_CONTACT_OPENING => contacts(|at| at.opening),
            variable::ENVELOPE_CONTACT_SLIP_LEAST => contacts(|at| at.slip[0]),
            variable::ENVELOPE_CONTACT_SLIP_MOST => contacts(|at| at.slip[1]),
            _ => None,
        }
    }
}
