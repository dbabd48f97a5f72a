//! The envelopes of the dam: sampled at the end of every step, and read.

use cofferdam_unit::{Variable, variables::dam as variable};
use std::sync::OnceLock;

use super::Dam;
use crate::StressRecovery;
use crate::contact::Crack;
use crate::envelope::{AtContact, AtCorner, Envelope, Instant, Sample, StepEnd};
use crate::material::Materials;
use crate::modal_field::{INSTANTS, ModalField};
use crate::model::Model;
use crate::stress::modal_stresses;

/// Where stresses and displacements are sampled: at the corners of cells.
#[derive(Clone, Debug)]
pub(super) struct Sampling {
    /// The nodes of the corners.
    corners: Vec<usize>,
    /// Tensile strength at each, Pa; infinite without one.
    strengths: Vec<f64>,
    /// Displacements and stresses at them, of modes.
    fields: Option<(ModalField<2>, ModalField<3>)>,
}

impl Sampling {
    /// At the corners of the cells of `model`, as `recovery` has them.
    pub fn new(materials: &Materials, model: &Model, recovery: &StressRecovery) -> Self {
        let mesh = &model.body().structure.mesh;
        let corners = recovery.nodes().to_vec();
        let strength = |zone: &Option<usize>| materials.tensile_strength(*zone).unwrap_or(f64::INFINITY);
        let fields = model.superposition().map(|modes| {
            let all: Vec<usize> = (0..corners.len()).collect();
            let displacements = ModalField::new(mesh, modes, &corners, |shape| {
                corners.iter().map(|&node| shape[node]).collect()
            });
            (displacements, modal_stresses(model, modes, recovery, &all).1)
        });
        Self { strengths: recovery.zones().iter().map(strength).collect(), fields, corners }
    }

    /// Envelopes before the first sample.
    pub fn nothing(&self, model: &Model) -> Envelope {
        let contacts = match model.superposition() {
            Some(modes) => modes.at_rest().joints.iter().map(Vec::len).sum(),
            None => model.body().structure.cracks.iter().map(Crack::contact_count).sum(),
        };
        Envelope::new(self.corners.len(), contacts)
    }

    /// Adds what waits in `envelope` to it. All instants are computed at once, which takes a fraction of the time.
    fn settle(&self, envelope: &mut Envelope, rest: &[f64]) {
        let Some((displacements, stresses)) = &self.fields else { return };
        let mut ends = Vec::with_capacity(INSTANTS);
        let (mut now, mut since) = (vec![[0.0; INSTANTS]; rest.len()], vec![[0.0; INSTANTS]; rest.len()]);
        for (i, Instant { end, coordinates }) in envelope.waiting().enumerate().take(INSTANTS) {
            ends.push(*end);
            for (mode, (q, rest)) in coordinates.iter().zip(rest).enumerate() {
                (now[mode][i], since[mode][i]) = (*q, q - rest);
            }
        }
        envelope.settle(&Sample {
            ends: &ends,
            stresses: &stresses.at_instants(&now),
            displacements: &displacements.at_instants(&since),
            strengths: &self.strengths,
        });
    }
}

impl Dam {
    /// Takes the current state, at the end of a `step` (s), into the envelopes, if they are kept. Modes wait until there are
    /// [`INSTANTS`] states.
    pub(super) fn sample(&mut self, step: f64) {
        let Some(sampling) = &self.sampling else { return };
        let Some(mut envelope) = self.state.envelope.take() else { return };
        let state = &self.state;
        let end = StepEnd { time: state.time, step };
        envelope.add_contacts(&self.structure().cracks, state.motion.joints());
        let coordinates = state.motion.displacement();
        if sampling.fields.is_some() {
            envelope.wait(Instant { end, coordinates: coordinates.to_vec() });
            if envelope.waiting().len() >= INSTANTS {
                sampling.settle(&mut envelope, &state.rest);
            }
        } else {
            let stresses = self.nodal_stresses.stresses(&self.model, coordinates, self.parameters.kinematics);
            let since =
                |&node: &usize| [0, 1].map(|d| [coordinates[2 * node + d] - state.rest[2 * node + d]]);
            envelope.add(&Sample {
                ends: &[end],
                stresses: &stresses.iter().map(|stress| stress.map(|value| [value])).collect::<Vec<_>>(),
                displacements: &sampling.corners.iter().map(since).collect::<Vec<_>>(),
                strengths: &sampling.strengths,
            });
            // The outputs need the same stresses.
            self.derived.stresses =
                OnceLock::from(self.nodal_stresses.principal(&stresses, &self.stress_points));
        }
        self.state.envelope = Some(envelope);
    }

    /// Values of a variable of the envelopes at all nodes or contacts; none if there are no envelopes or `variable` is another.
    pub(super) fn envelope(&self, variable: &Variable) -> Option<Vec<f64>> {
        let (sampling, envelope) = (self.sampling.as_ref()?, self.state.envelope.as_ref()?);
        // Nodes of the ground have no cell, and contacts whose sides had left each other from the beginning were never sampled.
        let sampled = |value: f64| if value.is_finite() { value } else { 0.0 };
        let nodes = |value: fn(&AtCorner, f64) -> f64| {
            let mut envelope = envelope.clone();
            sampling.settle(&mut envelope, &self.state.rest);
            let all = envelope.at_nodes(&self.structure().mesh, &sampling.corners, &sampling.strengths);
            Some(all.iter().map(|(at, ratio)| sampled(value(at, *ratio))).collect())
        };
        let contacts = |value: fn(&AtContact) -> f64| {
            Some(envelope.contacts().iter().map(|at| sampled(value(at))).collect())
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
