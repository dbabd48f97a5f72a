//! Records of ground motion in files: two-column CSV and PEER AT2.

use interface::number::{exact, plain};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Standard gravity, m/s².
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// Strongest acceleration of the ground, m/s²; some twenty times that of any earthquake. Beyond it lies a slip of units.
pub const STRONGEST: f64 = 1e3;

/// Share of an interval by which the interval between two printed times may differ from the usual one.
const UNEVENNESS: f64 = 0.02;

/// Unit of the accelerations in the file of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Units {
    /// Standard gravity, 9.80665 m/s².
    #[default]
    #[serde(rename = "g")]
    Gravity,
    /// Metres a second squared.
    #[serde(rename = "m/s2")]
    Metres,
    /// Centimetres a second squared (gal).
    #[serde(rename = "cm/s2")]
    Centimetres,
}

impl Units {
    /// One of them, m/s².
    pub fn in_si(self) -> f64 {
        match self {
            Self::Gravity => STANDARD_GRAVITY,
            Self::Metres => 1.0,
            Self::Centimetres => 0.01,
        }
    }
}

impl std::fmt::Display for Units {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Gravity => "g",
            Self::Metres => "m/s²",
            Self::Centimetres => "cm/s²",
        })
    }
}

/// A record as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time between two samples, s.
    pub interval: f64,
    /// Acceleration, in the unit of the file.
    pub acceleration: Vec<f64>,
}

/// A record that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be read.
    #[error("{}: {cause}; a record is a text file, named relative to the scene's folder", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// Neither `.csv` nor `.at2`.
    #[error("{}: records are two-column .csv (time in s, acceleration in `units`) or PEER .at2", path.display())]
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
        "{}:{line}: the sample at {} s comes {} s after the one before, the usual interval is {} s; \
         resample the record to equal intervals", path.display(), exact(*time), plain(*found), plain(*expected)
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
    #[error("{}: the record has {samples} samples; give two or more", path.display())]
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
        "{}: {}–{} s is asked for, the record has samples from 0 to {} s; two of them must remain",
        path.display(), exact(*start), exact(*end), plain(*duration)
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
    /// Stronger than any earthquake.
    #[error(
        "{}: a sample of {} {units}, times `scale` {}, is more than {} m/s²; check `units`, or give a smaller scale",
        path.display(), plain(*sample), plain(*factor), STRONGEST
    )]
    TooStrong {
        /// The file.
        path: PathBuf,
        /// The sample, in `units`.
        sample: f64,
        /// Unit of the file's accelerations.
        units: Units,
        /// Factor on it.
        factor: f64,
    },
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

    /// Two columns, time in s and acceleration; `#` begins a comment, one header line may come first.
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
        let count = entry("NPTS").filter(|npts| npts.fract() == 0.0 && (0.0..1e9).contains(npts));
        let interval = entry("DT").filter(|dt| *dt > 0.0 && dt.is_finite());
        let (Some(samples), Some(interval)) = (count, interval) else {
            let expected = "a PEER header with NPTS=, a count of samples, and DT=, an interval in s";
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
}
