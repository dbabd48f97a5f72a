//! Ground motions: records and ramps, their spectra and intensities, and factors that fit them to a target spectrum.
//!
//! A record is a list of equally spaced accelerations, linear in between. Files are CSV or PEER AT2, in g, m/s² or cm/s²; whatever
//! is read becomes m/s². The response spectrum is exact for accelerations that are constant over each interval.
//!
//! ```
//! use cofferdam_motion::GroundMotion;
//!
//! // A sine of 1 m/s² and 2 Hz for 20 s: an oscillator of 0.5 s and 5 % amplifies it by 1/(2ξ) = 10.
//! let sine = (0..2000).map(|i| (std::f64::consts::TAU * 2.0 * 0.01 * f64::from(i)).sin()).collect();
//! let motion = GroundMotion::of_samples("sine", 0.01, sine);
//! let resonance = motion.response_spectrum(&[0.5], 0.05)[0];
//! assert!((resonance - 10.0).abs() < 0.1, "{resonance}");
//! assert!((motion.peak().0.abs() - 1.0).abs() < 2e-3);
//! ```

mod baseline;
mod header;
mod intensity;
mod noise;
mod record;
mod response_spectrum;
mod spectrum;
mod target_spectrum;
pub mod text_file;
mod units;

pub use record::{Record, RecordError, STRONGEST};
pub use response_spectrum::response_spectrum;
pub use target_spectrum::{SpectralFit, TargetError, TargetSpectrum, compared_periods};
pub use units::{STANDARD_GRAVITY, Units};

use std::path::Path;

/// Horizontal acceleration of the ground, linear between equally spaced samples, zero afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundMotion {
    source: String,
    file: Option<RecordFile>,
    interval: f64,
    acceleration: Vec<f64>,
    hold: bool,
}

/// What belongs to the file of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordFile {
    /// Unit of its accelerations.
    pub units: Units,
    /// Its SHA-256, in hexadecimal digits.
    pub sha256: String,
}

impl GroundMotion {
    /// A record from its file, whose accelerations are in `units`, else in what its header says, else in g, cropped to
    /// `start`–`end` (s, both within the record), times `factor`.
    pub fn from_record(
        path: &Path,
        units: Option<Units>,
        start: f64,
        end: f64,
        factor: f64,
    ) -> Result<Self, RecordError> {
        let record = Record::read(path)?;
        if let (Some(header), Some(scene)) = (record.units, units)
            && header != scene
        {
            return Err(RecordError::OtherUnits { path: path.to_owned(), header, scene });
        }
        let units = units.or(record.units).unwrap_or_default();
        let duration = record.interval * (record.acceleration.len() - 1) as f64;
        let first = (start / record.interval - 1e-6).ceil().max(0.0) as usize;
        let last = ((end.min(duration) / record.interval + 1e-6).floor().max(0.0) as usize)
            .min(record.acceleration.len() - 1);
        let beyond = end.is_finite() && end > duration + 1e-6 * record.interval;
        if first >= last || beyond {
            let end = if beyond { end } else { end.min(duration) };
            return Err(RecordError::Crop { path: path.to_owned(), start, end, duration });
        }
        let acceleration: Vec<f64> =
            record.acceleration[first..=last].iter().map(|a| a * factor * units.in_si()).collect();
        if let Some(index) = acceleration.iter().position(|a| a.abs() > STRONGEST) {
            let (path, sample) = (path.to_owned(), record.acceleration[first + index]);
            return Err(RecordError::TooStrong { path, sample, units, factor: factor.abs() });
        }
        let source = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let file = Some(RecordFile { units, sha256: record.sha256 });
        Ok(Self { source, file, interval: record.interval, acceleration, hold: false })
    }

    /// A ramp from 0 to `acceleration` (m/s²) over `rise` (s), then held.
    pub fn ramp(acceleration: f64, rise: f64) -> Self {
        let source = format!("ramp to {acceleration} m/s2 in {rise} s");
        Self { source, file: None, interval: rise, acceleration: vec![0.0, acceleration], hold: true }
    }

    /// Equally spaced samples (m/s²), `interval` (s) apart, zero afterwards.
    pub fn of_samples(source: &str, interval: f64, acceleration: Vec<f64>) -> Self {
        Self { source: source.to_owned(), file: None, interval, acceleration, hold: false }
    }

    /// The same with every sample after `time` (s) moved by what `change` (m/s²) gives for it.
    pub fn moved_after(&self, time: f64, mut change: impl FnMut() -> f64) -> Self {
        let mut moved = self.clone();
        let later = (time / self.interval).floor().max(0.0) as usize + 1;
        moved.acceleration.iter_mut().skip(later).for_each(|sample| *sample += change());
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

    /// Time of the last sample, s.
    pub fn duration(&self) -> f64 {
        self.interval * (self.acceleration.len() - 1) as f64
    }

    /// Time from which on the ground does not accelerate, s; `None` if it never ends.
    pub fn rest_from(&self) -> Option<f64> {
        let held = self.hold && self.acceleration.last().is_some_and(|a| *a != 0.0);
        (!held).then(|| self.duration() + if self.hold { 0.0 } else { self.interval })
    }

    /// Acceleration (x, y) at `time` (s), m/s²; after a record it falls to zero within one interval.
    pub fn at(&self, time: f64) -> [f64; 2] {
        let last = self.acceleration.len() - 1;
        let after = if self.hold { self.acceleration[last] } else { 0.0 };
        let position = (time / self.interval).max(0.0);
        if position >= (last + 1) as f64 {
            return [after, 0.0];
        }
        let index = position.floor() as usize;
        let a = self.acceleration[index];
        let b = self.acceleration.get(index + 1).copied().unwrap_or(after);
        [a + (position - index as f64) * (b - a), 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acceleration_is_linear_between_samples_and_ends_at_zero() {
        let motion = GroundMotion::of_samples("", 0.5, vec![1.0, 3.0, -2.0]);
        for (time, value) in [(0.0, 1.0), (0.25, 2.0), (1.0, -2.0), (1.25, -1.0), (1.5, 0.0), (9.0, 0.0)] {
            assert_eq!(motion.at(time), [value, 0.0], "at {time}");
        }
        assert_eq!(motion.rest_from(), Some(1.5));
        let ramp = GroundMotion::ramp(-2.0, 0.1);
        assert_eq!(ramp.rest_from(), None);
        assert_eq!([ramp.at(0.05)[0], ramp.at(0.1)[0], ramp.at(5.0)[0]], [-1.0, -2.0, -2.0]);
    }

    #[test]
    fn the_same_motion_in_three_units_is_the_same() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("r.csv");
        for (units, sample) in [
            (Units::Gravity, 0.2),
            (Units::Metres, 0.2 * STANDARD_GRAVITY),
            (Units::Centimetres, 20.0 * STANDARD_GRAVITY),
        ] {
            std::fs::write(&path, format!("0,0\n0.01,{sample}\n0.02,0\n"))?;
            let motion = GroundMotion::from_record(&path, Some(units), 0.0, f64::INFINITY, -1.5)?;
            assert!((motion.acceleration()[1] + 0.3 * STANDARD_GRAVITY).abs() < 1e-15, "{units}");
        }
        // 200 m/s² are no 200 g.
        std::fs::write(&path, "0,0\n0.01,200\n")?;
        assert!(GroundMotion::from_record(&path, Some(Units::Metres), 0.0, f64::INFINITY, 1.0).is_ok());
        let refused = GroundMotion::from_record(&path, None, 0.0, f64::INFINITY, 1.0);
        assert!(matches!(refused, Err(RecordError::TooStrong { units: Units::Gravity, .. })), "{refused:?}");
        Ok(())
    }
}
