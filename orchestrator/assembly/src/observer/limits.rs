use super::StartOfDam;
use crate::units::DAM;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start, Status};
use cofferdam_coupling::scheme::WindowReport;
use cofferdam_scene::{StopAction, StopQuantity, StopScene};
use std::ops::Range;

/// Kinetic energy, J/m, up to which the energy balance is dominated by rounding.
const STANDSTILL: f64 = 1e-3;

/// Checks whether a quantity of the run exceeds a limit; flags it or ends the run. A dam that does not output the quantity is refused.
#[derive(Default)]
pub struct Limits {
    conditions: Vec<Watch>,
    peak_kinetic: f64,
    kinetic: Option<Range<usize>>,
}

struct Watch {
    condition: StopScene,
    /// Place of the quantity in the dam's outputs; `None` for iterations.
    range: Option<Range<usize>>,
    /// Time (s) and value where the limit was exceeded.
    passed: Option<(f64, f64)>,
}

impl Limits {
    /// The limits of a scene.
    pub fn new(conditions: &[StopScene]) -> Self {
        let watch = |&condition| Watch { condition, range: None, passed: None };
        Self { conditions: conditions.iter().map(watch).collect(), ..Self::default() }
    }

    /// A line for each limit that was exceeded, in the order of the scene.
    pub fn flags(&self) -> Vec<String> {
        self.conditions.iter().filter_map(Watch::says).collect()
    }
}

impl Watch {
    fn says(&self) -> Option<String> {
        let (time, value) = self.passed?;
        let StopScene { quantity, above, .. } = self.condition;
        let (word, unit) = (quantity.word(), quantity.unit());
        Some(format!("{word} {value:.4}{unit} above {above}{unit} from t = {time:.4} s"))
    }
}

impl Observer for Limits {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        for watch in &mut self.conditions {
            let variable = watch.condition.quantity.variable();
            watch.range = variable.map(|variable| start.output("stop", variable)).transpose()?;
            if watch.condition.quantity == StopQuantity::EnergyError {
                self.kinetic = Some(start.output("stop", "kinetic_energy")?);
            }
        }
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        for interval in &report.steps {
            let Some(dam) = report.accepted(DAM, interval.step) else { continue };
            let values =
                |range: &Option<Range<usize>>| range.clone().map_or(&[][..], |range| &dam.outputs[range]);
            self.peak_kinetic = values(&self.kinetic).iter().copied().fold(self.peak_kinetic, f64::max);
            for watch in self.conditions.iter_mut().filter(|watch| watch.passed.is_none()) {
                let largest = values(&watch.range).iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                let value = match watch.condition.quantity {
                    StopQuantity::Iterations => f64::from(report.iterations()),
                    StopQuantity::EnergyError => largest / self.peak_kinetic.max(STANDSTILL),
                    _ => largest,
                };
                if value > watch.condition.above {
                    watch.passed = Some((interval.end(), value));
                }
            }
        }
        Ok(())
    }

    fn end(&mut self, _ending: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }

    fn ends(&self) -> Option<Status> {
        let ends = |watch: &&Watch| watch.condition.action == StopAction::End;
        self.conditions.iter().filter(ends).find_map(Watch::says).map(Status::Stopped)
    }
}
