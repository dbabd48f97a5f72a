use super::{Ending, Observer, ObserverError, Start, Status};
use crate::participant::Level;
use crate::scheme::StepReport;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::HashSet;
use std::io::Write;
use std::time::{Duration, Instant};

/// The progress line: simulated time, speed relative to real time, iterations a step, residual.
///
/// On a terminal it is a bar that redraws itself; elsewhere a line every tenth of the run. What units warn
/// of stands above it, once, whether there is a progress line or none.
pub struct Progress {
    bar: ProgressBar,
    plain: bool,
    began: Instant,
    duration: f64,
    steps: u64,
    iterations: u64,
    shown: u64,
    warned: HashSet<(String, String)>,
}

const STYLE: &str = "{bar:10} {percent:>3} %  {msg}  {eta} left";

impl Progress {
    /// A progress line on standard error, or none if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
        let plain = !quiet && bar.is_hidden();
        Self {
            bar,
            plain,
            began: Instant::now(),
            duration: 0.0,
            steps: 0,
            iterations: 0,
            shown: 0,
            warned: HashSet::new(),
        }
    }

    /// Shows the warnings that are new.
    fn warn(&mut self, report: &StepReport) {
        for message in report.messages.iter().filter(|m| m.level >= Level::Warning) {
            if self.warned.insert((message.unit.clone(), message.text.clone())) {
                let (kind, unit, text) = (message.level, &message.unit, &message.text);
                self.bar.suspend(|| print(&format!("{kind}: {unit}: {text}")));
            }
        }
    }

    fn line(&self, report: &StepReport) -> String {
        let time = report.time + report.communication_step;
        let speed = time / self.began.elapsed().as_secs_f64().max(1e-9);
        format!(
            "{time:.2}/{:.2} s  {speed:.1}× real time  {:.1} iterations  residual {:.0e} Pa",
            self.duration,
            self.iterations as f64 / report.step.max(1) as f64,
            report.residuals.map_or(0.0, |r| r.pressure),
        )
    }
}

/// Prints a line on standard error; a reader that has gone away does not end the run.
fn print(line: &str) {
    // Nobody is left to be told.
    let _ = writeln!(std::io::stderr(), "{line}");
}

impl Observer for Progress {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        self.steps = start.steps;
        self.duration = start.steps as f64 * start.communication_step;
        self.bar.set_length(start.steps);
        if let Ok(style) = ProgressStyle::with_template(STYLE) {
            self.bar.set_style(style);
        }
        self.bar.enable_steady_tick(Duration::from_millis(200));
        Ok(())
    }

    fn step(&mut self, report: &StepReport) -> Result<(), ObserverError> {
        self.warn(report);
        if report.step == 0 {
            self.began = Instant::now();
            self.bar.reset_eta();
            return Ok(());
        }
        self.iterations += u64::from(report.iterations());
        let tenths = 10 * report.step / self.steps.max(1);
        if self.plain && tenths > self.shown {
            self.shown = tenths;
            print(&format!("{:>3} %  {}", 10 * tenths, self.line(report)));
        }
        if !self.bar.is_hidden() && report.step.is_multiple_of(16) {
            self.bar.set_message(self.line(report));
            self.bar.set_position(report.step);
        }
        Ok(())
    }

    fn end(&mut self, ending: &Ending) -> Result<(), ObserverError> {
        match ending.status {
            Status::Completed => self.bar.finish_and_clear(),
            _ => self.bar.abandon(),
        }
        Ok(())
    }
}
