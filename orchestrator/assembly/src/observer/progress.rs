use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start, Status};
use cofferdam_coupling::participant::Level;
use cofferdam_coupling::scheme::WindowReport;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeSet;
use std::io::Write;
use std::time::{Duration, Instant};

/// The progress line: simulated time, time left, steps that did not converge, speed relative to real time, iterations a step,
/// the units' shares of the time, residual, estimate of the coupling error over the largest pressure, relaxation factor: as
/// many of them as fit the terminal, in this order; time and share fit 20 columns.
///
/// On a terminal it is a bar that is updated in place; elsewhere it is a line every tenth of the run. Warnings of the
/// units are printed above it, each once, also without a progress line.
pub struct Progress {
    bar: ProgressBar,
    plain: bool,
    /// Of the terminal, or of lines elsewhere.
    columns: usize,
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
/// Columns of lines that do not go to a terminal.
const COLUMNS: usize = 80;
/// Columns from which on a bar is drawn.
const WIDE: usize = 60;
/// The share as text and as a bar, which take these columns.
const STYLES: [(&str, usize); 2] = [("{percent:>3} % {msg}", 6), ("{bar:10} {percent:>3} % {msg}", 17)];

impl Progress {
    /// A progress line on standard error, or none if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
        let plain = !quiet && bar.is_hidden();
        Self {
            bar,
            plain,
            columns: columns(),
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

    fn line(&self, report: &WindowReport, columns: usize) -> String {
        let time = report.end();
        let elapsed = self.began.elapsed().as_secs_f64().max(1e-9);
        let speed = (time - self.from) / elapsed;
        let share = |(name, time): &(String, Duration)| {
            format!("{name} {:.0} %", 100.0 * time.as_secs_f64() / elapsed)
        };
        let inside: Vec<String> = self.inside.iter().map(share).collect();
        let mut parts = vec![format!("{time:.2}/{:.2} s", self.duration)];
        if speed > 0.0 {
            parts.push(format!("{} left", left((self.duration - time) / speed)));
        }
        if self.unconverged > 0 {
            parts.push(format!("{} NOT CONVERGED", self.unconverged));
        }
        parts.push(format!("{speed:.1}× real time"));
        parts.push(format!("{:.1} iterations", self.iterations as f64 / self.windows.max(1) as f64));
        parts.push(inside.join(", "));
        parts.push(format!("residual {:.0e} Pa", report.residuals().map_or(0.0, |r| r.norm)));
        parts.extend(report.relative_interpolation_error().map(|e| format!("coupling error {e:.0e}")));
        // A factor of one and quasi-Newton schemes are not shown.
        let factor = report.correction().map_or(1.0, |correction| correction.relaxation);
        if factor != 1.0 {
            parts.push(format!("ω {factor:.2}"));
        }
        joined(&parts, columns)
    }

    /// Columns of the message on a terminal, and the style around it.
    fn style(&self) -> (&'static str, usize) {
        let (style, taken) = STYLES[usize::from(self.columns >= WIDE)];
        (style, self.columns.saturating_sub(taken))
    }
}

/// The first parts, and as many of the others as fit the columns.
fn joined(parts: &[String], columns: usize) -> String {
    let mut line = parts.first().cloned().unwrap_or_default();
    for part in parts.iter().skip(1) {
        if line.chars().count() + 2 + part.chars().count() > columns {
            break;
        }
        line = format!("{line}  {part}");
    }
    line
}

/// A time in s, or in min and h where it is long.
fn left(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Columns of the terminal behind standard error.
fn columns() -> usize {
    match rustix::termios::tcgetwinsize(std::io::stderr()) {
        Ok(size) if size.ws_col > 0 => size.ws_col.into(),
        _ => COLUMNS,
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
        if let Ok(style) = ProgressStyle::with_template(self.style().0) {
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
            print(&format!("{:>3} % {}", 10 * tenths, self.line(report, COLUMNS - STYLES[0].1)));
        }
        if !self.bar.is_hidden() && self.windows.is_multiple_of(16) {
            self.bar.set_message(self.line(report, self.style().1));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_matters_most_fits_twenty_columns() {
        let parts = ["10.50/25.00 s", "3 s left", "2 NOT CONVERGED"].map(str::to_owned);
        let [(_, taken), _] = STYLES;
        assert_eq!(joined(&parts, 20 - taken), "10.50/25.00 s");
        assert!(taken + joined(&parts, 20 - taken).len() <= 20);
        assert_eq!(joined(&parts, 23), "10.50/25.00 s  3 s left");
        assert_eq!(joined(&parts, 80), "10.50/25.00 s  3 s left  2 NOT CONVERGED");
    }

    #[test]
    fn times_left_are_told_in_units_that_suit() {
        assert_eq!(
            [3.4, 119.4, 121.0, 7000.0, 9000.0].map(left),
            ["3 s", "119 s", "2 min", "117 min", "2.5 h"]
        );
    }
}
