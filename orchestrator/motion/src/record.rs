//! Records of ground motion in files: columns, or PEER AT2.

use super::header::{self, Values};
use super::units::Units;
use crate::text_file;
use cofferdam_unit::number::{exact, plain};
use std::path::{Path, PathBuf};

/// Strongest acceleration of the ground, m/s²; some twenty times that of any earthquake. Beyond it lies a slip of units.
pub const STRONGEST: f64 = 1e3;

/// Interval between two samples from which on they are no earthquake's, s; that of times in ms is at least as long.
const LONGEST_INTERVAL: f64 = 1.0;
/// Share of an interval by which the interval between two printed times may differ from the usual one.
const UNEVENNESS: f64 = 0.02;

/// A record as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time between two samples, s.
    pub interval: f64,
    /// Acceleration, in the unit of the file.
    pub acceleration: Vec<f64>,
    /// Unit that the header names.
    pub units: Option<Units>,
    /// SHA-256 of the file, in hexadecimal digits.
    pub sha256: String,
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
    #[error("{}: records are two columns in a .csv (time in s, acceleration in `units`) or PEER .at2", path.display())]
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
    /// Values that are no accelerations, or in a unit that is not known.
    #[error("{}:{line}: by the header `{text}` the values are {values}; give accelerations in g, m/s² or cm/s²", path.display())]
    NoAcceleration {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The header.
        text: String,
        /// What the values are.
        values: &'static str,
    },
    /// A header that says otherwise than the scene.
    #[error("{}: the header says {header}, `units` {scene}; leave `units` out, or mend the header", path.display())]
    OtherUnits {
        /// The file.
        path: PathBuf,
        /// Unit in the header.
        header: Units,
        /// Unit in the scene.
        scene: Units,
    },
    /// Several columns of accelerations, and none chosen.
    #[error(
        "{}:{line}: `{text}` has {columns} columns after the time; choose one by `column`, or write decimal points instead of \
         commas", path.display()
    )]
    Columns {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What stands there.
        text: String,
        /// Columns after the time.
        columns: usize,
    },
    /// A column that the file does not have.
    #[error("{}:{line}: `column` is {column}, but this line has {columns} after the time; choose one of them", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The column, counted from 1.
        column: usize,
        /// Columns after the time.
        columns: usize,
    },
    /// A column of a file that has none.
    #[error(
        "{}: an .at2 file has one series of accelerations and no columns; leave `column` out, and give each component its own file",
        path.display()
    )]
    NoColumns {
        /// The file.
        path: PathBuf,
    },
    /// A second record without a sample at the instant at which the first begins.
    #[error(
        "{}: the horizontal motion begins at {} s, between two samples of this record, which are {} s apart; make the \
         `start` of the record a multiple of both intervals", path.display(), plain(*start), plain(*interval)
    )]
    Clock {
        /// The file.
        path: PathBuf,
        /// Where the other record begins, s.
        start: f64,
        /// Interval of this one, s.
        interval: f64,
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
    /// Samples so far apart that they cannot be an earthquake's.
    #[error(
        "{}: the samples are {} s apart, they must be less than {LONGEST_INTERVAL} s; is the time in ms? It must be in s", path.display(),
        plain(*interval)
    )]
    Interval {
        /// The file.
        path: PathBuf,
        /// Interval, s.
        interval: f64,
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
    /// Another record than the one that is wanted.
    #[error(
        "{}: the file's SHA-256 is {found}, not `sha256`: it is another record than the one that was run; find that one, or give \
         this one's `sha256`", path.display()
    )]
    Another {
        /// The file.
        path: PathBuf,
        /// Its SHA-256.
        found: String,
    },
    /// A crop that leaves nothing, or reaches beyond the record.
    #[error(
        "{}: {}–{} s is asked for, the record has samples from 0 to {} s; keep `start` and `end` within it, with two samples between",
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
    /// Reads a `.csv` or `.at2` file; of a `.csv` with several columns of accelerations the `column`, counted from 1.
    pub fn read(path: &Path, column: Option<usize>) -> Result<Self, RecordError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let columns = match extension.as_deref() {
            Some("csv") => true,
            Some("at2") if column.is_some() => return Err(RecordError::NoColumns { path: path.to_owned() }),
            Some("at2") => false,
            _ => return Err(RecordError::Format { path: path.to_owned() }),
        };
        let text =
            text_file::read(path).map_err(|cause| RecordError::Read { path: path.to_owned(), cause })?;
        let record =
            if columns { Self::parse_csv(path, &text, column) } else { Self::parse_at2(path, &text) }?;
        match record.acceleration.len() {
            samples @ 0..2 => Err(RecordError::Empty { path: path.to_owned(), samples }),
            _ if record.interval >= LONGEST_INTERVAL => {
                Err(RecordError::Interval { path: path.to_owned(), interval: record.interval })
            }
            _ => Ok(record),
        }
    }

    /// Columns, time in s and acceleration, between them a comma, a tab or blanks; `#` begins a comment, one header line may
    /// come first. Of several accelerations the `column` is taken.
    fn parse_csv(path: &Path, text: &str, column: Option<usize>) -> Result<Self, RecordError> {
        let mut samples: Vec<(usize, f64, f64)> = Vec::new();
        let mut headers = 0;
        let mut units = None;
        let marked = text.trim_start_matches('\u{feff}');
        for (line, content) in lines(marked).filter(|(_, l)| !l.is_empty() && !l.starts_with('#')) {
            let numbers: Option<Vec<f64>> = if content.contains(',') {
                content.split(',').map(|field| field.trim().parse().ok()).collect()
            } else {
                content.split_whitespace().map(|field| field.parse().ok()).collect()
            };
            let Some(&[time, ref values @ ..]) = numbers.as_deref().filter(|numbers| numbers.len() > 1)
            else {
                let named = content.starts_with(|c: char| c.is_alphabetic() || c == '"');
                headers += 1;
                if headers == 1 && samples.is_empty() && named {
                    units = of_header(path, line, &of_column(content, column))?;
                    continue;
                }
                let expected = "`time,acceleration`, two numbers with decimal points, and between them a comma, a tab or blanks";
                return Err(RecordError::Line {
                    path: path.to_owned(),
                    line,
                    text: content.to_owned(),
                    expected,
                });
            };
            let columns = values.len();
            let Some(&value) = values.get(column.unwrap_or(1).wrapping_sub(1)) else {
                let (path, column) = (path.to_owned(), column.unwrap_or(1));
                return Err(RecordError::Column { path, line, column, columns });
            };
            if column.is_none() && columns > 1 {
                let (path, text) = (path.to_owned(), content.to_owned());
                return Err(RecordError::Columns { path, line, text, columns });
            }
            if let Some(value) = [time, value].into_iter().find(|v| !v.is_finite()) {
                return Err(RecordError::NonFinite { path: path.to_owned(), line, value });
            }
            samples.push((line, time, value));
        }
        let acceleration: Vec<f64> = samples.iter().map(|(_, _, value)| *value).collect();
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            return Ok(Self { interval: 0.0, acceleration, units, sha256: cofferdam_unit::sha256(text) });
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
        Ok(Self { interval, acceleration, units, sha256: cofferdam_unit::sha256(text) })
    }

    /// PEER's format: four header lines, the third with the unit, the fourth with `NPTS=` and `DT=` or, in older files, with
    /// the two numbers before their names; then samples.
    fn parse_at2(path: &Path, text: &str) -> Result<Self, RecordError> {
        let units = of_header(path, 3, text.lines().nth(2).unwrap_or(""))?;
        let header = text.lines().nth(3).unwrap_or("");
        let number = |text: &str| {
            let number = text.trim_start_matches([' ', '=', ',']);
            number.split(|c: char| c == ',' || c.is_whitespace()).next()?.parse::<f64>().ok()
        };
        let named = |key: &str| number(&header[header.find(key)? + key.len()..]);
        let mut before = header.split_whitespace().map(number);
        let older = [before.next().flatten(), before.next().flatten()];
        let [count, interval] =
            if older.iter().all(Option::is_some) { older } else { [named("NPTS"), named("DT")] };
        let count = count.filter(|npts| npts.fract() == 0.0 && (0.0..1e9).contains(npts));
        let interval = interval.filter(|dt| *dt > 0.0 && dt.is_finite());
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
        Ok(Self { interval, acceleration, units, sha256: cofferdam_unit::sha256(text) })
    }
}

/// The part of a header that belongs to the time and a `column`, where it has a field for each.
fn of_column(header: &str, column: Option<usize>) -> String {
    let separator = if header.contains(',') { ',' } else { '\t' };
    let fields: Vec<&str> = header.split(separator).collect();
    match column.and_then(|column| fields.get(column)) {
        Some(field) => format!("{}{separator}{field}", fields[0]),
        None => header.to_owned(),
    }
}

/// The unit that a header names.
fn of_header(path: &Path, line: usize, header: &str) -> Result<Option<Units>, RecordError> {
    match header::values(header) {
        Values::Unsaid => Ok(None),
        Values::In(units) => Ok(Some(units)),
        Values::Other(values) => {
            let text = header.trim().to_owned();
            Err(RecordError::NoAcceleration { path: path.to_owned(), line, text, values })
        }
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
        let record = Record::parse_csv(path, csv, None)?;
        // by sha256sum
        assert_eq!(record.sha256, "34920f97ac833d02b27f32221c13688a1759caa459528af7a0a1d2c552545321");
        assert_eq!((record.units, record.acceleration.len()), (Some(Units::Gravity), 3));
        // of the same content, not of the same file
        let at2_record = |text: &str| -> Result<Record, RecordError> {
            Ok(Record { sha256: record.sha256.clone(), ..Record::parse_at2(path, text)? })
        };
        assert_eq!(record, at2_record(at2)?);
        let older = at2.replace("NPTS=   3, DT=  .0200 SEC", "    3   0.0200    NPTS, DT");
        assert_eq!(record, at2_record(&older)?);
        for columns in [csv.replace(',', "\t"), csv.replace(',', "   ")] {
            let found = Record::parse_csv(path, &columns, None)?;
            assert_eq!(record.acceleration, found.acceleration, "{columns}");
            assert!((record.interval, record.units) == (found.interval, found.units), "{found:?}");
            assert_ne!(record.sha256, found.sha256);
        }
        Ok(())
    }
}
