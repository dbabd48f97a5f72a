//! Checks of a scheme: the mass of the water counts once, states are restored, and the size of the rounding floor.

use super::Scheme;
use crate::convergence::norm;
use crate::participant::ParticipantError;
use crate::scheme::{CouplingError, Graph, Purpose, SchemeKind, WindowReport};

/// Changes of pressure by which the rounding floor is measured, in units in the last place of the largest pressure.
pub(super) const FLOOR_PROBE: f64 = 2.0;

impl Scheme {
    /// Repeats the last iteration: units that return to their saved states give identical answers.
    pub(super) fn check_states(
        &self,
        graph: &mut Graph,
        unknowns: &[f64],
        iteration: u32,
        report: &mut WindowReport,
    ) -> Result<(), CouplingError> {
        self.restore(graph)?;
        self.evaluate(graph, unknowns, iteration, Purpose::States, report)?;
        let (before, after) =
            report.exchanges.split_at(report.exchanges.len() - self.blanks.len() * report.steps.len());
        for (first, second) in before[before.len() - after.len()..].iter().zip(after) {
            let bits = |(a, b): (&f64, &f64)| a.to_bits() != b.to_bits();
            let different = first.outputs.iter().zip(&second.outputs).position(bits);
            // If a structure's answer differs, so does the request to its fluid, whose answer then proves nothing.
            let Some(position) = different.filter(|_| first.inputs == second.inputs) else { continue };
            let unit = &graph[first.unit];
            let (variable, index) = unit.description().outputs.locate(position).unwrap_or(("?", position));
            return Err(CouplingError::StateNotRestored {
                participant: unit.description().name.clone(),
                step: first.occasion.step,
                time: first.occasion.time,
                variable: variable.to_owned(),
                index,
                first: first.outputs[position],
                second: second.outputs[position],
            });
        }
        Ok(())
    }

    /// Change of the residual when the pressure changes by rounding, that is, by `change` (Pa).
    pub(super) fn measure_floor(
        &mut self,
        graph: &mut Graph,
        [unknowns, residual]: [&[f64]; 2],
        change: f64,
        iteration: u32,
        report: &mut WindowReport,
    ) -> Result<(), CouplingError> {
        self.restore(graph)?;
        let moved: Vec<f64> =
            unknowns.iter().enumerate().map(|(i, x)| x + if i % 2 == 0 { change } else { -change }).collect();
        let answered = self.evaluate(graph, &moved, iteration, Purpose::RoundingFloor, report)?.unknowns;
        let changes = answered.iter().zip(&moved).zip(residual).map(|((q, p), r)| q - p - r);
        self.memory.floor = Some(norm(changes));
        Ok(())
    }
}

/// The water's mass must be counted once.
pub(super) fn added_mass(graph: &mut Graph, kind: SchemeKind) -> Result<(), CouplingError> {
    for id in graph.ids() {
        if !graph.is_structure(id) {
            continue;
        }
        let included = match graph[id].read("added_mass_included") {
            Ok(value) => value.first().is_some_and(|x| *x != 0.0),
            Err(ParticipantError::Missing { .. }) => false,
            Err(error) => return Err(error.into()),
        };
        if included != (kind == SchemeKind::AddedMass) {
            return Err(CouplingError::AddedMass {
                participant: graph[id].description().name.clone(),
                included,
            });
        }
    }
    Ok(())
}
