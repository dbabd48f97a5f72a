use super::{Exchange, UnitId, WindowReport};
use serde::{Deserialize, Serialize};

/// Steps with the same answers after which a unit counts as frozen.
const PATIENCE: u32 = 20;

/// Watches whether a unit still responds to its inputs.
///
/// A unit is not watched if it never responded to a change within a step, such as a prescribed motion or any unit of
/// a scheme without iterations, nor if its answer is zero.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct FrozenWatch {
    responds: bool,
    /// Accepted request and answer of the last step.
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// Steps whose answers were the same.
    same: u32,
}

impl FrozenWatch {
    /// The number of steps with equal answers, if `unit` counts as frozen with the window that is about
    /// to be accepted.
    pub fn frozen(&self, unit: UnitId, report: &WindowReport) -> Option<u32> {
        let same = self.same_with(report, last(unit, report)?);
        (self.responds && same >= PATIENCE).then_some(same)
    }

    /// Takes an accepted window.
    pub fn accept(&mut self, unit: UnitId, report: &WindowReport) {
        let Some(last) = last(unit, report) else { return };
        self.same = self.same_with(report, last);
        let step =
            report.exchanges.iter().filter(|e| e.unit == unit && e.occasion.step == last.occasion.step);
        for (earlier, later) in step.clone().zip(step.skip(1)) {
            self.responds |= earlier.inputs != later.inputs && earlier.outputs != later.outputs;
        }
        self.last = Some((last.inputs.clone(), last.outputs.clone()));
    }

    fn same_with(&self, report: &WindowReport, last: &Exchange) -> u32 {
        let same = self.last.as_ref().is_some_and(|(inputs, outputs)| {
            *inputs != last.inputs && *outputs == last.outputs && outputs.iter().any(|x| *x != 0.0)
        });
        if same { self.same + report.steps.len() as u32 } else { 0 }
    }
}

fn last(unit: UnitId, report: &WindowReport) -> Option<&Exchange> {
    report.exchanges.iter().rfind(|e| e.unit == unit)
}
