//! Ground motions: two-column CSV and PEER AT2 records, and the ramp.

use super::error::plain;
use std::path::{Path, PathBuf};

/// Standard gravity, m/s²: records are in units of it.
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// Share of an interval by which the interval between two printed times may differ from the usual one.
const UNEVENNESS: f64 = 0.02;

/// Horizontal acceleration of the ground, linear between equally spaced samples, zero afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundMotion {
    source: String,
    interval: f64,
    acceleration: Vec<f64>,
    hold: bool,
}

/// A record as its file has it, in units of g.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time between two samples, s.
    pub interval: f64,
    /// Acceleration, g.
    pub acceleration: Vec<f64>,
}

/// A record that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be read.
    #[error("{}: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// Neither `.csv` nor `.at2`.
    #[error("{}: records are two-column .csv (time in s, acceleration in g) or PEER .at2", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// A line that is no sample.
    #[error("{}:{line}: `{text}` is not {expected}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What stands there.
        text: String,
        /// What should.
        expected: &'static str,
    },
    /// A value that is NaN or infinite.
    #[error("{}:{line}: the value {value} is not finite; repair the record or crop it before this line", path.display())]
    NonFinite {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The value.
        value: f64,
    },
    /// Samples that are not equally spaced.
    #[error(
        "{}:{line}: the sample at {time} s comes {} s after the one before, the usual interval is {} s; \
         resample the record to equal intervals", path.display(), plain(*found), plain(*expected)
    )]
    NonUniform {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// Time of the sample, s.
        time: f64,
        /// Interval found, s.
        found: f64,
        /// Usual interval (the median), s.
        expected: f64,
    },
    /// Fewer than two samples.
    #[error("{}: the record has {samples} samples, two are the least", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// Number of samples.
        samples: usize,
    },
    /// An AT2 file with another number of samples than its header says.
    #[error("{}: the header promises {promised} samples, the file holds {found}; fetch the record again", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// NPTS of the header.
        promised: usize,
        /// Number of samples found.
        found: usize,
    },
    /// A crop that leaves nothing, or reaches beyond the record.
    #[error(
        "{}: {start}–{end} s is asked for, the record has samples from 0 to {duration} s; two of them must remain",
        path.display()
    )]
    Crop {
        /// The file.
        path: PathBuf,
        /// Start of the crop, s.
        start: f64,
        /// End of the crop, s.
        end: f64,
        /// Duration of the record, s.
        duration: f64,
    },
}

impl GroundMotion {
    /// A record from its file, cropped to `start`–`end` (s, both within the record), times `factor`.
    pub fn from_record(path: &Path, start: f64, end: f64, factor: f64) -> Result<Self, RecordError> {
        let record = Record::read(path)?;
        let duration = record.interval * (record.acceleration.len() - 1) as f64;
        let first = (start / record.interval - 1e-6).ceil().max(0.0) as usize;
        let last = ((end.min(duration) / record.interval + 1e-6).floor().max(0.0) as usize)
            .min(record.acceleration.len() - 1);
        let beyond = end.is_finite() && end > duration + 1e-6 * record.interval;
        if first >= last || beyond {
            let end = if beyond { end } else { end.min(duration) };
            return Err(RecordError::Crop { path: path.to_owned(), start, end, duration });
        }
        let acceleration =
            record.acceleration[first..=last].iter().map(|a| a * factor * STANDARD_GRAVITY).collect();
        let source = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        Ok(Self { source, interval: record.interval, acceleration, hold: false })
    }

    /// A ramp from 0 to `acceleration` (m/s²) over `rise` (s), then held.
    pub fn ramp(acceleration: f64, rise: f64) -> Self {
        let source = format!("ramp to {acceleration} m/s2 in {rise} s");
        Self { source, interval: rise, acceleration: vec![0.0, acceleration], hold: true }
    }

    /// Equally spaced samples (m/s²), `interval` (s) apart, zero afterwards.
    #[cfg(test)]
    pub(super) fn of_samples(source: &str, interval: f64, acceleration: Vec<f64>) -> Self {
        Self { source: source.to_owned(), interval, acceleration, hold: false }
    }

    /// Where it came from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Time between two samples, s.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// The samples, m/s².
    pub fn acceleration(&self) -> &[f64] {
        &self.acceleration
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

impl Record {
    /// Reads a `.csv` or `.at2` file.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let parse = match extension.as_deref() {
            Some("csv") => Self::parse_csv,
            Some("at2") => Self::parse_at2,
            _ => return Err(RecordError::Format { path: path.to_owned() }),
        };
        let text = std::fs::read_to_string(path)
            .map_err(|cause| RecordError::Read { path: path.to_owned(), cause })?;
        let record = parse(path, &text)?;
        match record.acceleration.len() {
            samples @ 0..2 => Err(RecordError::Empty { path: path.to_owned(), samples }),
            _ => Ok(record),
        }
    }

    /// Two columns, time in s and acceleration in g; `#` begins a comment, one header line may come first.
    fn parse_csv(path: &Path, text: &str) -> Result<Self, RecordError> {
        let mut samples: Vec<(usize, f64, f64)> = Vec::new();
        let mut headers = 0;
        let text = text.trim_start_matches('\u{feff}');
        for (line, content) in lines(text).filter(|(_, l)| !l.is_empty() && !l.starts_with('#')) {
            let numbers: Option<Vec<f64>> = content.split(',').map(|f| f.trim().parse().ok()).collect();
            let Some(&[time, value]) = numbers.as_deref() else {
                let named = content.starts_with(|c: char| c.is_alphabetic() || c == '"');
                headers += 1;
                if headers == 1 && samples.is_empty() && named {
                    continue;
                }
                let expected = "`time,acceleration`, two numbers";
                return Err(RecordError::Line {
                    path: path.to_owned(),
                    line,
                    text: content.to_owned(),
                    expected,
                });
            };
            if let Some(value) = [time, value].into_iter().find(|v| !v.is_finite()) {
                return Err(RecordError::NonFinite { path: path.to_owned(), line, value });
            }
            samples.push((line, time, value));
        }
        let acceleration: Vec<f64> = samples.iter().map(|(_, _, value)| *value).collect();
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            return Ok(Self { interval: 0.0, acceleration });
        };
        let mut intervals: Vec<f64> = samples.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
        intervals.sort_by(f64::total_cmp);
        let typical = intervals.get(intervals.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
        let uneven = |pair: &&[(usize, f64, f64)]| {
            let found = pair[1].1 - pair[0].1;
            !(found > 0.0 && (found - typical).abs() <= UNEVENNESS * typical)
        };
        if let Some(&[(_, before, _), (line, time, _)]) = samples.windows(2).find(uneven) {
            let (path, found) = (path.to_owned(), time - before);
            return Err(RecordError::NonUniform { path, line, time, found, expected: typical });
        }
        // The mean, because printed times are rounded.
        let interval = (last.1 - first.1) / (samples.len() - 1).max(1) as f64;
        Ok(Self { interval, acceleration })
    }

    /// PEER's format: four header lines, the last with `NPTS=` and `DT=`, then samples in g.
    fn parse_at2(path: &Path, text: &str) -> Result<Self, RecordError> {
        let header = text.lines().nth(3).unwrap_or("");
        let entry = |key: &str| {
            let rest = &header[header.find(key)? + key.len()..];
            let number = rest.trim_start_matches([' ', '=']);
            number.split(|c: char| c == ',' || c.is_whitespace()).next()?.parse::<f64>().ok()
        };
        let (Some(samples), Some(interval)) = (entry("NPTS"), entry("DT").filter(|dt| *dt > 0.0)) else {
            let expected = "a PEER header with NPTS= and DT=";
            return Err(RecordError::Line {
                path: path.to_owned(),
                line: 4,
                text: header.to_owned(),
                expected,
            });
        };
        let mut acceleration = Vec::new();
        for (line, content) in lines(text).skip(4) {
            for field in content.split_whitespace() {
                match field.parse::<f64>() {
                    Ok(value) if value.is_finite() => acceleration.push(value),
                    Ok(value) => return Err(RecordError::NonFinite { path: path.to_owned(), line, value }),
                    Err(_) => {
                        let (path, text) = (path.to_owned(), field.to_owned());
                        return Err(RecordError::Line { path, line, text, expected: "a number" });
                    }
                }
            }
        }
        let (promised, found) = (samples as usize, acceleration.len());
        if promised != found {
            return Err(RecordError::Truncated { path: path.to_owned(), promised, found });
        }
        Ok(Self { interval, acceleration })
    }
}

fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_formats_give_the_same_record() -> Result<(), RecordError> {
        let csv = "# comment\ntime_s,acc_g\n0,0.1\n0.02,-0.2\n0.04,0.05\n";
        let at2 = "PEER\nevent\nunits of g\nNPTS=   3, DT=  .0200 SEC\n  1.0E-01 -2.0E-01\n .5E-01\n";
        let path = Path::new("r");
        assert_eq!(Record::parse_csv(path, csv)?, Record::parse_at2(path, at2)?);
        Ok(())
    }

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
}
