use super::StartOfDam;
use crate::observer::Histories;
use crate::units::DAM;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start, Status};
use cofferdam_coupling::scheme::WindowReport;
use cofferdam_coupling::signal::Signal;
use cofferdam_scene::{REST, Time};
use std::ops::Range;

/// The part of a run at its end, s, over which means are taken.
pub const AVERAGED: f64 = 1.0;
/// Speed of sliding, m/s, above which a block is not at rest, and the share of the peak kinetic energy: means over that part.
pub const STILL_SLIDES: f64 = 1e-4;
/// See [`STILL_SLIDES`].
pub const STILL_MOVES: f64 = 1e-2;

/// Sliding, m, beyond which a joint counts as having slid away: drains, grout curtain and waterstops have failed long before, and the
/// loads remain those of the undeformed section.
pub const SLID_AWAY: f64 = 1.0;
/// Speed of sliding, m/s, beyond which a joint slides away: 1 m in less than two minutes.
pub const SLIDES_AWAY: f64 = 1e-2;

/// How the block above a crack moves in the last second of a run, or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastSecond {
    /// Mean sliding, m.
    pub sliding: f64,
    /// Mean speed of sliding, m/s.
    pub speed: f64,
    /// Mean kinetic energy of the dam over its peak.
    pub kinetic_share: f64,
}

impl LastSecond {
    /// Of the histories with this `column` of sliding; none without it.
    pub fn of(histories: &Histories, column: &str) -> Option<Self> {
        Self::until(histories, column, f64::INFINITY)
    }

    /// The same of the last second before the time `end` (s), at the latest that of the histories.
    pub fn until(histories: &Histories, column: &str, end: f64) -> Option<Self> {
        let (time, sliding) = (histories.column("time")?, histories.column(column)?);
        let kinetic = histories.column("dam.kinetic_energy").unwrap_or(&[]);
        let peak = kinetic.iter().copied().fold(0.0, f64::max);
        let rows = time.partition_point(|time| *time <= end + 1e-9);
        let kinetic = &kinetic[..rows.min(kinetic.len())];
        Some(Self::of_rows(&time[..rows], &sliding[..rows.min(sliding.len())], kinetic, peak))
    }

    /// Of times (s), sliding (m) and kinetic energies (J/m), of which `peak` is the largest of the whole run.
    fn of_rows(time: &[f64], sliding: &[f64], kinetic: &[f64], peak: f64) -> Self {
        let from = last_second(time);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let last = &sliding[from..];
        let (first_half, second_half) = last.split_at(last.len() / 2);
        Self {
            sliding: mean(last),
            speed: (mean(second_half) - mean(first_half)) / (AVERAGED / 2.0),
            kinetic_share: if peak > 0.0 { mean(kinetic.get(from..).unwrap_or(&[])) / peak } else { 0.0 },
        }
    }

    /// Whether the block slides away: it has slid farther than [`SLID_AWAY`], or `after` the ground came to rest it slides faster than
    /// [`SLIDES_AWAY`].
    pub fn slides_away(&self, after: bool) -> bool {
        self.sliding.abs() > SLID_AWAY || after && self.speed.abs() > SLIDES_AWAY
    }

    /// Whether the block is at rest.
    pub fn is_rest(&self) -> bool {
        self.speed.abs() <= STILL_SLIDES && self.kinetic_share <= STILL_MOVES
    }
}

/// Index of the first of the times (s) in the last second.
fn last_second(time: &[f64]) -> usize {
    time.partition_point(|t| *t < time.last().copied().unwrap_or(0.0) - AVERAGED)
}

/// Ends a run once the dam is at rest, if the scene asks for that.
#[derive(Default)]
pub struct Rest {
    /// How long the ground has to be quiet before, s; `None` if the scene does not ask.
    quiet: Option<f64>,
    /// From when on the dam can be at rest, s; `None` if the run does not wait for it.
    from: Option<f64>,
    /// Places of sliding and of the kinetic energy in the dam's outputs.
    outputs: [Option<Range<usize>>; 2],
    peak_kinetic: f64,
    /// Of the run so far: times, sliding of each crack, and the kinetic energy.
    time: Vec<f64>,
    sliding: Vec<Vec<f64>>,
    kinetic: Vec<f64>,
}

impl Rest {
    /// As the clock of a scene says.
    pub fn new(time: &Time) -> Self {
        Self { quiet: time.longest_quiet.map(|_| time.quiet.max(REST)), ..Self::default() }
    }

    /// Takes the state at `time` (s).
    fn add(&mut self, time: f64, sliding: &[f64], kinetic: f64) {
        // A dam without cracks slides nowhere.
        let sliding = if sliding.is_empty() { &[0.0] } else { sliding };
        self.peak_kinetic = self.peak_kinetic.max(kinetic);
        self.time.push(time);
        self.sliding.resize_with(sliding.len(), Vec::new);
        for (crack, sliding) in self.sliding.iter_mut().zip(sliding) {
            crack.push(*sliding);
        }
        self.kinetic.push(kinetic);
    }
}

/// Time from which on the ground does not accelerate, s; `None` if it never ends.
fn ground_at_rest_from(start: &Start<'_>) -> Option<f64> {
    let mut ground = start.signals.iter().filter(|signal| signal.input == "ground_acceleration");
    ground.try_fold(0.0, |rest: f64, signal: &Signal| Some(rest.max(signal.zero_from()?)))
}

impl Observer for Rest {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        self.from = self.quiet.and_then(|quiet| Some(ground_at_rest_from(start)? + quiet));
        if self.from.is_some() {
            let kinetic = start.output("time.longest_quiet", "kinetic_energy")?;
            self.outputs = [start.dam().outputs.range("crack_sliding"), Some(kinetic)];
        }
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        if self.from.is_none() {
            return Ok(());
        }
        for interval in &report.steps {
            let Some(dam) = report.accepted(DAM, interval.step) else { continue };
            let [sliding, kinetic] =
                self.outputs.clone().map(|range| range.map_or(&[][..], |range| &dam.outputs[range]));
            self.add(interval.end(), sliding, kinetic.iter().sum());
        }
        Ok(())
    }

    fn end(&mut self, _ending: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }

    fn ends(&self) -> Option<Status> {
        let (from, time) = (self.from?, self.time.last()?);
        let rests = |crack: &Vec<f64>| {
            LastSecond::of_rows(&self.time, crack, &self.kinetic, self.peak_kinetic).is_rest()
        };
        (*time >= from - 1e-9 && self.sliding.iter().all(rests)).then_some(Status::Completed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_coupling::stepping::Stepping;

    #[test]
    fn the_ground_is_quiet_when_all_components_are() {
        let signal = |component, held, samples| Signal {
            held,
            component,
            ..Signal::new("s", "ground_acceleration", 0.5, samples)
        };
        let rest = |signals: &[Signal]| {
            let stepping =
                Stepping { communication_step: 0.5, steps: 9, window: 1, halve: false, adaptive: None };
            ground_at_rest_from(&Start { units: Vec::new(), signals, stepping })
        };
        let (short, long) = (signal(0, false, vec![1.0; 2]), signal(1, false, vec![1.0; 5]));
        assert_eq!(rest(&[short.clone(), long.clone()]), Some(2.5));
        assert_eq!(rest(std::slice::from_ref(&short)), Some(1.0));
        assert_eq!(rest(&[short, signal(1, true, vec![1.0])]), None);
        assert_eq!(rest(&[]), Some(0.0));
    }

    /// Two cracks after 1 s of motion, asked every 0.01 s; the second slides on with `creep` (m/s), the energy is `kinetic`.
    fn rest_at(quiet: Option<f64>, creep: f64, kinetic: fn(f64) -> f64) -> Option<f64> {
        let mut rest = Rest { quiet, from: quiet.map(|quiet| 1.0 + quiet), ..Rest::default() };
        (1..=2000).map(|step| 0.01 * f64::from(step)).find(|time| {
            rest.add(*time, &[0.2, creep * time], kinetic(*time));
            rest.ends().is_some()
        })
    }

    #[test]
    fn a_run_waits_for_rest() {
        let still = |time: f64| if time < 1.0 { 1.0 } else { 0.0 };
        // not before the ground has been quiet for long enough
        assert_eq!(rest_at(Some(5.0), 0.0, still), Some(6.0));
        assert_eq!(rest_at(Some(8.0), 0.0, still), Some(9.0));
        assert_eq!(rest_at(None, 0.0, still), None);
        // either bound alone keeps it going
        assert_eq!(rest_at(Some(5.0), 1.1 * STILL_SLIDES, still), None);
        assert_eq!(rest_at(Some(5.0), -0.9 * STILL_SLIDES, still), Some(6.0));
        assert_eq!(rest_at(Some(5.0), 0.0, |time| if time < 1.0 { 1.0 } else { 1.1 * STILL_MOVES }), None);
        // exp(-t/2) is below a hundredth from 9.21 s on, its mean over a second 0.5 s later
        let late = rest_at(Some(5.0), 0.0, |time| (-time / 2.0).exp()).expect("rest");
        assert!((late - 9.73).abs() < 0.02, "{late}");
    }
}
