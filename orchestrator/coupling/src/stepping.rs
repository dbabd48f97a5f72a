//! Which communication steps a run takes: of equal length, halved where they fail, or as an error estimate asks.

use crate::scheme::{Interval, WindowReport};
use serde::{Deserialize, Serialize};

/// The communication steps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stepping {
    /// Length H of a communication step, s; the first one's, if they vary.
    pub communication_step: f64,
    /// Number of steps of that length that make up the run.
    pub steps: u64,
    /// Steps that are iterated together.
    pub window: usize,
    /// A step that does not converge is started again with half its length.
    pub halve: bool,
    /// The length follows an error estimate.
    pub adaptive: Option<Adaptive>,
}

/// Bounds of a step length that follows the estimate of the interpolation error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adaptive {
    /// Largest [`WindowReport::relative_interpolation_error`].
    pub tolerance: f64,
    /// Shortest step, s: one of this length is taken whatever its error.
    pub shortest: f64,
    /// Longest step, s.
    pub longest: f64,
}

impl Stepping {
    /// `steps` steps of equal length (s), each by itself.
    pub fn equal(communication_step: f64, steps: u64) -> Self {
        Self { communication_step, steps, window: 1, halve: false, adaptive: None }
    }

    /// End of the run, s.
    pub fn end(&self) -> f64 {
        self.steps as f64 * self.communication_step
    }

    /// The same, or the end of the last step where sums are rounded upwards, s: no step of equal length ends later.
    pub fn latest_end(&self) -> f64 {
        let last = self.steps.saturating_sub(1) as f64 * self.communication_step;
        self.end().max(last + self.communication_step)
    }

    /// Whether the length can change.
    pub fn varies(&self) -> bool {
        self.halve || self.adaptive.is_some()
    }
}

/// Halvings of a step after which it is given up.
const MOST_HALVINGS: u32 = 10;
/// Share of the length that the estimate would allow which is taken, and the bounds of a change.
const SAFETY: f64 = 0.9;
const LEAST_CHANGE: f64 = 0.2;
const LARGEST_CHANGE: f64 = 2.0;
/// Steps grow by so much or not at all.
const WORTHWHILE: f64 = 1.1;

/// Where a run stands, and what it takes next.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Clock {
    stepping: Stepping,
    taken: u64,
    attempt: u32,
    pace: Pace,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum Pace {
    /// `index` whole steps and `part` of 2^`halvings` parts of the next have been taken.
    Grid { index: u64, part: u64, halvings: u32 },
    /// Any time and any length, s.
    Free { time: f64, length: f64 },
}

impl Clock {
    pub fn new(stepping: Stepping) -> Self {
        let pace = match stepping.adaptive {
            None => Pace::Grid { index: 0, part: 0, halvings: 0 },
            Some(_) => Pace::Free { time: 0.0, length: stepping.communication_step },
        };
        Self { stepping, taken: 0, attempt: 1, pace }
    }

    /// The same place and time with other steps from there on; `None` where they do not begin.
    pub fn with(&self, stepping: Stepping) -> Option<Self> {
        let (old, time) = (&self.stepping, self.time());
        let pace = match (&self.pace, stepping.adaptive) {
            (Pace::Grid { .. }, None) if old.communication_step == stepping.communication_step => {
                self.pace.clone()
            }
            (Pace::Free { length, .. }, Some(Adaptive { shortest, longest, .. })) => {
                Pace::Free { time, length: length.clamp(shortest, longest) }
            }
            (Pace::Grid { .. }, Some(_)) => Pace::Free { time, length: stepping.communication_step },
            (_, None) => {
                let index = (time / stepping.communication_step).round();
                if (index * stepping.communication_step - time).abs() > 1e-9 * stepping.communication_step {
                    return None;
                }
                Pace::Grid { index: index as u64, part: 0, halvings: 0 }
            }
        };
        Some(Self { stepping, taken: self.taken, attempt: 1, pace })
    }

    /// Number of steps taken.
    pub fn taken(&self) -> u64 {
        self.taken
    }

    pub fn attempt(&self) -> u32 {
        self.attempt
    }

    /// Time reached, s.
    pub fn time(&self) -> f64 {
        match self.pace {
            Pace::Grid { index, part: 0, .. } => index as f64 * self.stepping.communication_step,
            Pace::Grid { index, part, halvings } => {
                (index as f64 + part as f64 / f64::from(1 << halvings)) * self.stepping.communication_step
            }
            Pace::Free { time, .. } => time,
        }
    }

    /// The steps of the next window; none at the end of the run.
    pub fn window(&self) -> Vec<Interval> {
        let Stepping { communication_step, steps, window, .. } = self.stepping;
        let interval = |step: u64, time: f64, length: f64| Interval::new(self.taken + step, time, length);
        match self.pace {
            Pace::Grid { index, part: 0, halvings: 0 } => {
                let at = |index: u64| index as f64 * communication_step;
                (index..steps.min(index + window as u64))
                    .map(|i| Interval {
                        signal_time: at(i + 1),
                        ..interval(1 + i - index, at(i), communication_step)
                    })
                    .collect()
            }
            Pace::Grid { halvings, .. } => {
                let length = communication_step / f64::from(1 << halvings);
                vec![interval(1, self.time(), length)]
            }
            Pace::Free { time, length } => {
                let rest = self.stepping.end() - time;
                let shortest = self.stepping.adaptive.map_or(0.0, |adaptive| adaptive.shortest);
                match length {
                    _ if rest <= 1e-9 * shortest => Vec::new(),
                    _ if rest <= length * (1.0 + 1e-9) => vec![interval(1, time, rest)],
                    // Two of equal length are left, rather than one and a remnant.
                    _ if rest < 2.0 * length => vec![interval(1, time, rest / 2.0)],
                    _ => vec![interval(1, time, length)],
                }
            }
        }
    }

    /// A window of the length `taken` (s) failed: true if it is to be started again, in shorter steps.
    pub fn shorten(&mut self, taken: f64) -> bool {
        let again = match (&mut self.pace, self.stepping.adaptive) {
            (Pace::Grid { part, halvings, .. }, _) if self.stepping.halve && *halvings < MOST_HALVINGS => {
                (*part, *halvings) = (2 * *part, *halvings + 1);
                true
            }
            (Pace::Free { length, .. }, Some(adaptive))
                if self.stepping.halve && taken > adaptive.shortest * (1.0 + 1e-9) =>
            {
                *length = adaptive.shortest.max(taken / 2.0);
                true
            }
            _ => false,
        };
        self.attempt += u32::from(again);
        again
    }

    /// Whether a window that could be accepted is to be taken; else it is started again, in shorter steps.
    pub fn takes(&mut self, report: &WindowReport) -> bool {
        let (Pace::Free { length, .. }, Some(adaptive)) = (&mut self.pace, self.stepping.adaptive) else {
            return true;
        };
        let taken = report.end() - report.time();
        let Some(error) = report.relative_interpolation_error().filter(|error| *error > adaptive.tolerance)
        else {
            return true;
        };
        if taken <= adaptive.shortest * (1.0 + 1e-9) {
            return true;
        }
        *length = adaptive.shortest.max(taken * change(error, adaptive.tolerance).min(SAFETY));
        self.attempt += 1;
        false
    }

    /// Goes on from the end of `report`.
    pub fn accept(&mut self, report: &WindowReport) {
        self.attempt = 1;
        self.taken += report.steps.len() as u64;
        match &mut self.pace {
            Pace::Grid { index, part, halvings } => {
                *part += report.steps.len() as u64;
                while *halvings > 0 && part.is_multiple_of(2) {
                    (*part, *halvings) = (*part / 2, *halvings - 1);
                }
                if *halvings == 0 {
                    (*index, *part) = (*index + *part, 0);
                }
            }
            Pace::Free { time, length } => {
                *time = report.end();
                if let (Some(error), Some(adaptive)) =
                    (report.relative_interpolation_error(), self.stepping.adaptive)
                {
                    let change = change(error, adaptive.tolerance);
                    if !(1.0..WORTHWHILE).contains(&change) {
                        *length = (*length * change).clamp(adaptive.shortest, adaptive.longest);
                    }
                }
            }
        }
    }
}

/// The factor that an error of second order in the length asks for.
fn change(error: f64, tolerance: f64) -> f64 {
    (SAFETY * (tolerance / error).sqrt()).clamp(LEAST_CHANGE, LARGEST_CHANGE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(clock: &Clock, interpolation_error: Option<f64>) -> WindowReport {
        let steps = clock.window();
        WindowReport { steps, interpolation_error, largest: 1.0, ..WindowReport::default() }
    }

    fn run(clock: &mut Clock, mut fails: impl FnMut(&Interval) -> bool) -> Vec<(f64, f64, u64)> {
        let mut all = Vec::new();
        loop {
            let report = taken(clock, None);
            let Some(first) = report.steps.first() else { return all };
            if fails(first) && clock.shorten(first.communication_step) {
                continue;
            }
            all.extend(report.steps.iter().map(|i| (i.time, i.communication_step, i.step)));
            clock.accept(&report);
        }
    }

    #[test]
    fn equal_steps_lie_on_the_grid_alone_or_in_windows() {
        for window in [1, 3, 7, 50] {
            let mut clock = Clock::new(Stepping { window, ..Stepping::equal(0.1, 20) });
            let all = run(&mut clock, |_| false);
            assert_eq!(all.len(), 20);
            for (i, (time, length, step)) in all.iter().enumerate() {
                assert_eq!((*time, *length, *step), (i as f64 * 0.1, 0.1, i as u64 + 1));
            }
        }
    }

    #[test]
    fn a_step_that_fails_is_halved_until_it_is_given_up_and_the_grid_is_met_again() {
        let mut clock = Clock::new(Stepping { halve: true, ..Stepping::equal(1.0, 4) });
        let all = run(&mut clock, |i| i.time >= 1.0 && i.time < 2.0 && i.communication_step > 0.3);
        let expected =
            [(0.0, 1.0), (1.0, 0.25), (1.25, 0.25), (1.5, 0.25), (1.75, 0.25), (2.0, 1.0), (3.0, 1.0)];
        assert_eq!(all.iter().map(|(t, h, _)| (*t, *h)).collect::<Vec<_>>(), expected);
        assert_eq!(all.last().map(|last| last.2), Some(7));
        let mut clock = Clock::new(Stepping { halve: true, ..Stepping::equal(1.0, 4) });
        assert_eq!((0..).take_while(|_| clock.shorten(1.0)).count(), 10);
        assert!(!Clock::new(Stepping::equal(1.0, 4)).shorten(1.0));
    }

    #[test]
    fn the_length_follows_the_error_within_its_bounds_and_the_end_is_met() {
        let adaptive = Adaptive { tolerance: 1e-3, shortest: 0.01, longest: 0.5 };
        let stepping = Stepping { adaptive: Some(adaptive), ..Stepping::equal(0.1, 100) };
        let mut clock = Clock::new(stepping);
        // An error that is h² until t = 5 s, and too large for any step from then on.
        let mut lengths = Vec::new();
        loop {
            let mut report = taken(&clock, None);
            let Some(i) = report.steps.first().copied() else { break };
            let error = if i.time < 5.0 { i.communication_step.powi(2) } else { 1.0 };
            report.interpolation_error = Some(error);
            if clock.takes(&report) {
                assert!(error <= 1e-3 || i.communication_step <= 0.01 * (1.0 + 1e-9), "{i:?}");
                lengths.push((i.end(), i.communication_step));
                clock.accept(&report);
            }
        }
        let end = lengths.last().map(|(end, _)| *end);
        assert!(end.is_some_and(|end| (end - 10.0).abs() < 1e-12), "{end:?}");
        let early = lengths.iter().filter(|(end, _)| (1.0..4.9).contains(end));
        assert!(early.clone().all(|(_, h)| (0.025..0.032).contains(h)), "{lengths:?}");
        assert!(lengths.iter().filter(|(end, _)| *end > 5.1).all(|(_, h)| *h < 0.0101));
    }
}
