//! What observers of a run were told, from its log.

use super::{Entries, Entry, Log, LogReadError, LoggedExchange, LoggedStep};
use crate::ground_motion::GroundMotion;
use crate::observer::Past;
use crate::participant::Occasion;
use crate::scheme::{Exchange, Interval, WindowReport};
use std::iter::Peekable;
use std::ops::Range;
use std::time::Duration;

/// Reads a log window by window, as the reports that observers had; wall times are rounded. A window without its last `/step`,
/// because the log ends before, is left out.
pub struct Reports {
    entries: Peekable<Entries>,
    ground_motion: GroundMotion,
    /// Where the request to each unit holds the acceleration of the ground.
    told: Vec<Option<Range<usize>>>,
    done: bool,
}

impl Log {
    /// The windows and checkpoints from the first on.
    ///
    /// **Errors**: the log can no longer be opened.
    pub fn reports(&self) -> Result<Reports, LogReadError> {
        let ground_motion = self.head().ground_motion();
        let told = self.head().units.iter().map(|unit| unit.inputs.range("ground_acceleration")).collect();
        Ok(Reports { entries: self.entries()?.peekable(), ground_motion, told, done: false })
    }
}

impl Reports {
    /// The next window or checkpoint; `None` at the end.
    fn read(&mut self) -> Result<Option<Past>, LogReadError> {
        let mut report = WindowReport::default();
        let mut steps: Vec<LoggedStep> = Vec::new();
        loop {
            // The steps of a window stand together.
            let goes_on = match self.entries.peek() {
                Some(Ok(Entry::Step(step))) => {
                    steps.first().is_none_or(|first| first.occasion.attempt == step.occasion.attempt)
                }
                _ => steps.is_empty(),
            };
            if !goes_on {
                return Ok(Some(Past::Window(self.window(report, &steps))));
            }
            match self.entries.next().transpose()? {
                None | Some(Entry::End(_) | Entry::Cut(_)) => return Ok(None),
                Some(Entry::Checkpoint(checkpoint)) => return Ok(Some(Past::Checkpoint(checkpoint))),
                Some(Entry::Exchange(logged)) => report.exchanges.push(exchange(logged)),
                Some(Entry::Message(message)) => report.messages.push(message),
                Some(Entry::Iteration(iteration)) => report.iterates.push(iteration.report),
                Some(Entry::Step(step)) => steps.push(step),
            }
        }
    }

    /// The report with what its steps say.
    fn window(&self, mut report: WindowReport, steps: &[LoggedStep]) -> WindowReport {
        for step in steps {
            let occasion = step.occasion;
            report.attempt = occasion.attempt;
            let interval = Interval {
                step: occasion.step,
                time: occasion.time,
                communication_step: occasion.communication_step,
                ground_acceleration: self.ground_acceleration(&report.exchanges, &occasion),
            };
            report.steps.push(interval);
            if step.accepted {
                report.interfaces.push(step.interfaces.clone());
            }
            report.converged = step.converged;
            report.outcome.clone_from(&step.outcome);
            report.fallbacks = step.fallbacks;
            report.interpolation_error = step.interpolation_error;
            report.largest_pressure = step.largest_pressure;
            report.rounding_floor = step.rounding_floor;
            report.solver_time.resize(step.unit_times.len(), Duration::ZERO);
            for (sum, time) in report.solver_time.iter_mut().zip(&step.unit_times) {
                *sum += seconds(*time);
            }
        }
        report
    }

    /// What the units were told of the ground in a step: the run may have rounded the step's end otherwise.
    fn ground_acceleration(&self, exchanges: &[Exchange], occasion: &Occasion) -> [f64; 2] {
        let mut of_step = exchanges.iter().filter(|exchange| exchange.occasion.step == occasion.step);
        let told = |exchange: &Exchange| {
            let range = self.told[exchange.unit.0].clone()?;
            exchange.inputs.get(range)?.try_into().ok()
        };
        of_step.find_map(told).unwrap_or_else(|| self.ground_motion.at(occasion.end()))
    }
}

impl Iterator for Reports {
    type Item = Result<Past, LogReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let item = self.read().transpose();
        self.done = !matches!(item, Some(Ok(_)));
        item
    }
}

fn exchange(logged: LoggedExchange) -> Exchange {
    let LoggedExchange { unit, occasion, accepted, inputs, outputs, wall_time, .. } = logged;
    let [sent, answered] = wall_time.map(seconds);
    Exchange { unit, occasion, accepted, inputs, outputs: outputs.unwrap_or_default(), sent, answered }
}

/// Wall time in seconds; nothing where that is none.
fn seconds(time: f64) -> Duration {
    Duration::try_from_secs_f64(time).unwrap_or_default()
}
