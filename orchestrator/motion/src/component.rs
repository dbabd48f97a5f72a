//! One component of a ground motion.

use super::{Record, RecordError, STRONGEST, Units};
use std::path::Path;

/// Acceleration of the ground along one axis, linear between equally spaced samples, zero afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    pub(super) source: String,
    pub(super) file: Option<RecordFile>,
    pub(super) interval: f64,
    pub(super) acceleration: Vec<f64>,
    pub(super) hold: bool,
}

/// What belongs to the file of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordFile {
    /// Unit of its accelerations.
    pub units: Units,
    /// Its SHA-256, in hexadecimal digits.
    pub sha256: String,
}

/// The part of a record that moves the ground.
#[derive(Clone, Copy, Debug)]
pub struct Excerpt<'a> {
    /// The file.
    pub path: &'a Path,
    /// Column of the acceleration in a `.csv`, counted from 1 after the time; `None` for files with one.
    pub column: Option<usize>,
    /// Unit of the accelerations; `None` for what the header says, or g.
    pub units: Option<Units>,
    /// Where it begins, s, within the record.
    pub start: f64,
    /// Where it ends, s: within the record, or infinite.
    pub end: f64,
    /// Factor on the accelerations.
    pub factor: f64,
    /// Whether it follows the clock of another record: it then has a sample at `start`, and its record may end before `end`.
    pub follows: bool,
}

impl<'a> Excerpt<'a> {
    /// All of the record in a file with one column of accelerations.
    pub fn whole(path: &'a Path) -> Self {
        let (start, end) = (0.0, f64::INFINITY);
        Self { path, column: None, units: None, start, end, factor: 1.0, follows: false }
    }

    /// Time in the record, s, of the first sample, of a record with this `interval` (s).
    pub fn begins(&self, interval: f64) -> f64 {
        self.first(interval) as f64 * interval
    }

    fn first(&self, interval: f64) -> usize {
        (self.start / interval - 1e-6).ceil().max(0.0) as usize
    }
}

impl Component {
    /// The excerpt of a record.
    ///
    /// **Errors**: [`RecordError`].
    pub fn from_record(excerpt: &Excerpt<'_>) -> Result<Self, RecordError> {
        let Excerpt { path, column, start, end, factor, follows, .. } = *excerpt;
        let record = Record::read(path, column)?;
        if let (Some(header), Some(scene)) = (record.units, excerpt.units)
            && header != scene
        {
            return Err(RecordError::OtherUnits { path: path.to_owned(), header, scene });
        }
        let units = excerpt.units.or(record.units).unwrap_or_default();
        let interval = record.interval;
        let duration = interval * (record.acceleration.len() - 1) as f64;
        let first = excerpt.first(interval);
        let last = ((end.min(duration) / interval + 1e-6).floor().max(0.0) as usize)
            .min(record.acceleration.len() - 1);
        let beyond = !follows && end.is_finite() && end > duration + 1e-6 * interval;
        if first >= last || beyond {
            let end = if beyond { end } else { end.min(duration) };
            return Err(RecordError::Crop { path: path.to_owned(), start, end, duration });
        }
        if follows && (excerpt.begins(interval) - start).abs() > 1e-5 * interval {
            return Err(RecordError::Clock { path: path.to_owned(), start, interval });
        }
        let acceleration: Vec<f64> =
            record.acceleration[first..=last].iter().map(|a| a * factor * units.in_si()).collect();
        if let Some(index) = acceleration.iter().position(|a| a.abs() > STRONGEST) {
            let (path, sample) = (path.to_owned(), record.acceleration[first + index]);
            return Err(RecordError::TooStrong { path, sample, units, factor: factor.abs() });
        }
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let source = column.map_or_else(|| name.clone(), |column| format!("{name}, column {column}"));
        let file = Some(RecordFile { units, sha256: record.sha256 });
        Ok(Self { source, file, interval, acceleration, hold: false })
    }

    /// A ramp from 0 to `acceleration` (m/s²) over `rise` (s), then held.
    pub fn ramp(acceleration: f64, rise: f64) -> Self {
        let source = format!("ramp to {acceleration} m/s2 in {rise} s");
        Self { hold: true, ..Self::of_samples(&source, rise, vec![0.0, acceleration]) }
    }

    /// Equally spaced samples (m/s²), `interval` (s) apart, zero afterwards.
    pub fn of_samples(source: &str, interval: f64, acceleration: Vec<f64>) -> Self {
        Self { source: source.to_owned(), file: None, interval, acceleration, hold: false }
    }

    /// The same with every sample after `time` (s) moved by what `change` (m/s²) gives for the magnitude of the peak (m/s²).
    pub fn moved_after(&self, time: f64, change: &mut impl FnMut(f64) -> f64) -> Self {
        let mut moved = self.clone();
        let (later, peak) = ((time / self.interval).floor().max(0.0) as usize + 1, self.largest());
        moved.acceleration.iter_mut().skip(later).for_each(|sample| *sample += change(peak));
        moved
    }

    /// The same, its last sample held from there on.
    pub fn held(self) -> Self {
        Self { hold: true, ..self }
    }

    /// Whether the last sample is held.
    pub fn is_held(&self) -> bool {
        self.hold
    }

    /// Where it came from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The file of a record.
    pub fn file(&self) -> Option<&RecordFile> {
        self.file.as_ref()
    }

    /// Time between two samples, s.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// The samples, m/s².
    pub fn acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// The sample that is farthest from zero, m/s², and its time, s.
    pub fn peak(&self) -> (f64, f64) {
        let samples = self.acceleration.iter().enumerate();
        let peak = samples.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        peak.map_or((0.0, 0.0), |(index, peak)| (*peak, index as f64 * self.interval))
    }

    /// Magnitude of the peak, m/s².
    pub fn largest(&self) -> f64 {
        self.acceleration.iter().fold(0.0, |peak: f64, a| peak.max(a.abs()))
    }

    /// Time of the last sample, s.
    pub fn duration(&self) -> f64 {
        self.interval * (self.acceleration.len() - 1) as f64
    }

    /// Time from which on the acceleration is zero, s; `None` if it never ends.
    pub fn rest_from(&self) -> Option<f64> {
        let held = self.hold && self.acceleration.last().is_some_and(|a| *a != 0.0);
        (!held).then(|| self.duration() + if self.hold { 0.0 } else { self.interval })
    }

    /// Acceleration at `time` (s), m/s²; after a record it falls to zero within one interval.
    pub fn at(&self, time: f64) -> f64 {
        let last = self.acceleration.len() - 1;
        let after = if self.hold { self.acceleration[last] } else { 0.0 };
        let position = (time / self.interval).max(0.0);
        if position >= (last + 1) as f64 {
            return after;
        }
        let index = position.floor() as usize;
        let a = self.acceleration[index];
        let b = self.acceleration.get(index + 1).copied().unwrap_or(after);
        a + (position - index as f64) * (b - a)
    }
}
