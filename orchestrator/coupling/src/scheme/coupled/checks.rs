//! Checks of a scheme: no response counts twice, states are restored, and the size of the rounding floor.

use super::Scheme;
use crate::convergence::norm;
use crate::participant::ParticipantError;
use crate::scheme::{CouplingError, Graph, Purpose, SchemeKind, WindowReport};

/// Changes of values by which the rounding floor is measured, in units in the last place of the largest value.
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
            report.exchanges.split_at(report.exchanges.len() - self.templates.len() * report.steps.len());
        for (first, second) in before[before.len() - after.len()..].iter().zip(after) {
            let bits = |(a, b): (&f64, &f64)| a.to_bits() != b.to_bits();
            let different = first.outputs.iter().zip(&second.outputs).position(bits);
            // If the answer of a first unit differs, so does the request to its second, whose answer then proves nothing.
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

    /// Change of the residual when values change by rounding, that is, by `change`.
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

/// The response of a second unit must be included in the first in a one-way scheme, and only there.
pub(super) fn included(graph: &mut Graph, kind: SchemeKind) -> Result<(), CouplingError> {
    for interface in graph.interfaces().to_vec() {
        let first = interface.first.unit;
        let included = match &interface.included {
            None => false,
            Some(variable) => match graph[first].read(variable) {
                Ok(value) => value.first().is_some_and(|x| *x != 0.0),
                Err(ParticipantError::Missing { .. }) => false,
                Err(error) => return Err(error.into()),
            },
        };
        if included != (kind == SchemeKind::OneWay) {
            return Err(CouplingError::Included {
                participant: graph[first].description().name.clone(),
                other: graph[interface.second.unit].description().name.clone(),
                variable: interface.included.unwrap_or_default(),
                included,
            });
        }
    }
    Ok(())
}
