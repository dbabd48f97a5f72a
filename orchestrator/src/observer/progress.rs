use super::{Ending, Observer, ObserverError, Start, Status};
use crate::participant::Level;
use crate::scheme::WindowReport;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeSet;
use std::io::Write;
use std::time::{Duration, Instant};

/// The progress line: simulated time, speed relative to real time, iterations a step, residual, relaxation factor,
/// estimate of the coupling error over the largest pressure, the units' shares of the time, steps that did not converge.
///
/// On a terminal it is a bar that is updated in place; elsewhere it is a line every tenth of the run. Warnings of the
/// units are printed above it, each once, also without a progress line.
pub struct Progress {
    bar: ProgressBar,
    plain: bool,
    began: Instant,
    duration: f64,
    /// Time from which on it was computed here, s.
    from: f64,
    /// Number of accepted windows, and of their iterations.
    windows: u64,
    iterations: u64,
    unconverged: u64,
    /// Time inside each unit, by its name.
    inside: Vec<(String, Duration)>,
    shown: u64,
    warned: BTreeSet<(String, String)>,
}

/// Resolution of the bar.
const PARTS: u64 = 1000;
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
            from: 0.0,
            windows: 0,
            iterations: 0,
            unconverged: 0,
            inside: Vec::new(),
            shown: 0,
            warned: BTreeSet::new(),
        }
    }

    fn count(&mut self, report: &WindowReport) {
        self.iterations += u64::from(report.iterations());
        if report.is_accepted() {
            self.windows += 1;
            self.unconverged += if report.converged { 0 } else { report.steps.len() as u64 };
        }
    }

    /// Shows the warnings that are new.
    fn warn(&mut self, report: &WindowReport) {
        for message in report.messages.iter().filter(|m| m.level >= Level::Warning) {
            if self.warned.insert((message.unit.clone(), message.text.clone())) {
                let (kind, unit, text) = (message.level, &message.unit, &message.text);
                self.bar.suspend(|| print(&format!("{kind}: {unit}: {text}")));
            }
        }
    }

    fn line(&self, report: &WindowReport) -> String {
        let time = report.end();
        let elapsed = self.began.elapsed().as_secs_f64().max(1e-9);
        let speed = (time - self.from) / elapsed;
        let share = |(name, time): &(String, Duration)| {
            format!("{name} {:.0} %", 100.0 * time.as_secs_f64() / elapsed)
        };
        let inside = self.inside.iter().map(share).collect::<Vec<_>>().join(", ");
        // A factor of one and quasi-Newton schemes are not shown.
        let relaxation = match report.correction().map_or(1.0, |correction| correction.relaxation) {
            1.0 => String::new(),
            factor => format!("  ω {factor:.2}"),
        };
        let estimate = report
            .relative_interpolation_error()
            .map_or_else(String::new, |e| format!("  coupling error {e:.0e}"));
        let unconverged = match self.unconverged {
            0 => String::new(),
            count => format!("  {count} NOT CONVERGED"),
        };
        format!(
            "{time:.2}/{:.2} s  {speed:.1}× real time  {:.1} iterations  residual {:.0e} Pa{relaxation}{estimate}  \
             {inside}{unconverged}",
            self.duration,
            self.iterations as f64 / self.windows.max(1) as f64,
            report.residuals().map_or(0.0, |r| r.pressure),
        )
    }
}

/// Prints a line on standard error; a closed output does not end the run.
fn print(line: &str) {
    // If the output is closed, no reader is left.
    let _ = writeln!(std::io::stderr(), "{line}");
}

impl Observer for Progress {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        self.duration = start.stepping.end();
        self.inside = start.units.iter().map(|unit| (unit.name.clone(), Duration::ZERO)).collect();
        self.bar.set_length(PARTS);
        if let Ok(style) = ProgressStyle::with_template(STYLE) {
            self.bar.set_style(style);
        }
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.warn(report);
        if report.step() == 0 {
            self.began = Instant::now();
            self.bar.reset_eta();
            return Ok(());
        }
        for ((_, sum), time) in self.inside.iter_mut().zip(&report.solver_time) {
            *sum += *time;
        }
        self.count(report);
        if !report.is_accepted() {
            return Ok(());
        }
        let share = report.end() / self.duration.max(f64::MIN_POSITIVE);
        let tenths = (10.0 * share + 1e-9) as u64;
        if self.plain && tenths > self.shown {
            self.shown = tenths;
            print(&format!("{:>3} %  {}", 10 * tenths, self.line(report)));
        }
        if !self.bar.is_hidden() && self.windows.is_multiple_of(16) {
            self.bar.set_message(self.line(report));
            self.bar.set_position((PARTS as f64 * share) as u64);
        }
        Ok(())
    }

    /// Counts, and says nothing.
    fn past(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.warned.extend(report.messages.iter().map(|m| (m.unit.clone(), m.text.clone())));
        if report.step() > 0 {
            self.count(report);
        }
        self.from = self.from.max(report.end());
        self.shown = (10.0 * self.from / self.duration.max(f64::MIN_POSITIVE) + 1e-9) as u64;
        self.began = Instant::now();
        self.bar.reset_eta();
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
