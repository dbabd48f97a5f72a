//! Factors that scale records to a target spectrum.

use super::header::{self, Values};
use super::{GroundMotion, Units};
use crate::text_file;
use std::path::{Path, PathBuf};

/// Periods at which spectra are compared.
const PERIODS: usize = 61;

/// A response spectrum that records are scaled to, with straight lines between its points in logarithms of period and
/// acceleration.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSpectrum {
    /// Period, s, ascending, and spectral acceleration, m/s².
    points: Vec<[f64; 2]>,
}

/// How well a record, scaled, has the target spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralFit {
    /// Factor on the record.
    pub factor: f64,
    /// Root mean square of `ln (f S_a/S_t)`.
    pub misfit: f64,
    /// Smallest and largest `f S_a/S_t`.
    pub ratios: [f64; 2],
}

/// A target spectrum that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TargetError {
    /// The file cannot be read.
    #[error("{}: {cause}; a target spectrum is a text file, named relative to the plan's folder", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// A line that is no point of it.
    #[error("{}:{line}: `{text}` is not `period,acceleration`: two positive numbers, the periods in s and ascending", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What stands there.
        text: String,
    },
    /// Its header speaks of other values.
    #[error("{}: by the header `{text}` the values are {values}; give spectral accelerations in g, m/s² or cm/s²", path.display())]
    NoAcceleration {
        /// The file.
        path: PathBuf,
        /// The header.
        text: String,
        /// What the values are.
        values: &'static str,
    },
    /// Too few periods.
    #[error(
        "{}: the spectrum has periods from {has_from} to {has_to} s, those from {from:.3} to {to:.3} s are compared; give it for all \
         of them, or narrow `range`", path.display()
    )]
    Range {
        /// The file.
        path: PathBuf,
        /// Its first period, s.
        has_from: f64,
        /// Its last period, s.
        has_to: f64,
        /// First period that is wanted, s.
        from: f64,
        /// Last period that is wanted, s.
        to: f64,
    },
}

impl TargetSpectrum {
    /// Reads two columns, period in s and spectral acceleration in the unit that a header line names, else in g; `#` begins a
    /// comment. It must reach from the period `from` to `to` (s).
    ///
    /// **Errors**: [`TargetError`].
    pub fn read(path: &Path, [from, to]: [f64; 2]) -> Result<Self, TargetError> {
        let path = path.to_owned();
        let text = match text_file::read(&path) {
            Ok(text) => text,
            Err(cause) => return Err(TargetError::Read { path, cause }),
        };
        let mut units = None;
        let mut points: Vec<[f64; 2]> = Vec::new();
        let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim).enumerate();
        for (index, content) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
            let fields = content.split([',', ';', '\t', ' ']).filter(|field| !field.is_empty());
            let numbers: Option<Vec<f64>> = fields.map(|field| field.parse().ok()).collect();
            let earlier = points.last().map_or(0.0, |point| point[0]);
            match numbers.as_deref() {
                Some(&[period, value])
                    if period > earlier && value > 0.0 && period.is_finite() && value.is_finite() =>
                {
                    points.push([period, value]);
                }
                None if points.is_empty() && units.is_none() => match header::values(content) {
                    Values::Other(values) => {
                        return Err(TargetError::NoAcceleration { path, text: content.to_owned(), values });
                    }
                    Values::In(named) => units = Some(named),
                    Values::Unsaid => units = Some(Units::default()),
                },
                _ => return Err(TargetError::Line { path, line: index + 1, text: content.to_owned() }),
            }
        }
        let scale = units.unwrap_or_default().in_si();
        points.iter_mut().for_each(|point| point[1] *= scale);
        let [has_from, has_to] = [points.first(), points.last()].map(|point| point.map_or(0.0, |p| p[0]));
        if has_from > from * (1.0 + 1e-9) || has_to < to * (1.0 - 1e-9) {
            return Err(TargetError::Range { path, has_from, has_to, from, to });
        }
        Ok(Self { points })
    }

    /// Spectral acceleration at a `period` (s), m/s²; beyond its ends that of the end.
    pub fn at(&self, period: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] < period);
        let (Some([x0, y0]), Some([x1, y1])) = (
            self.points.get(after.saturating_sub(1)).copied(),
            self.points.get(after).or(self.points.last()).copied(),
        ) else {
            return f64::NAN;
        };
        if x1 <= x0 { y1 } else { y0 * (y1 / y0).powf((period / x0).ln() / (x1 / x0).ln()) }
    }

    /// The factor with which the spectrum of `motion` deviates least from this one over the periods from `from` to `to` (s):
    ///
    /// ```text
    /// ln f = mean of ln (S_t/S_a) over periods that are equally spaced in their logarithms
    /// ```
    ///
    /// which makes the sum of the squares of `ln (f S_a/S_t)` least. `damping` is that of both spectra.
    ///
    /// **Source**: the mean squared error of logarithms of the Pacific Earthquake Engineering Research Center's ground motion
    /// database (PEER 2010/109, equations 2 and 3, equal weights).
    pub fn fit(&self, motion: &GroundMotion, [from, to]: [f64; 2], damping: f64) -> SpectralFit {
        let periods = compared_periods([from, to]);
        let found = motion.response_spectrum(&periods, damping);
        let lacking: Vec<f64> =
            periods.iter().zip(&found).map(|(&period, found)| (self.at(period) / found).ln()).collect();
        let mean = lacking.iter().sum::<f64>() / lacking.len() as f64;
        let square = lacking.iter().map(|lack| (mean - lack).powi(2)).sum::<f64>() / lacking.len() as f64;
        let ratios = lacking.iter().map(|lack| (mean - lack).exp());
        let ratios =
            ratios.fold([f64::INFINITY, 0.0], |[low, high], ratio| [ratio.min(low), ratio.max(high)]);
        SpectralFit { factor: mean.exp(), misfit: square.sqrt(), ratios }
    }
}

/// The periods at which spectra are compared, s: equally spaced in their logarithms.
pub fn compared_periods([from, to]: [f64; 2]) -> Vec<f64> {
    (0..PERIODS).map(|i| from * (to / from).powf(i as f64 / (PERIODS - 1) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("target.csv");
        std::fs::write(&path, text).expect("a file");
        (folder, path)
    }

    fn motion() -> GroundMotion {
        let sample = |i: i32| {
            let t = f64::from(i) * 0.01;
            (9.0 * t).sin() * (-(t - 4.0).powi(2) / 4.0).exp() + 0.4 * (31.0 * t).sin() * (-t).exp()
        };
        GroundMotion::of_samples("pulse", 0.01, (0..1500).map(sample).collect())
    }

    /// The spectrum of a record, times a factor, is fitted with this factor, and nothing is left.
    #[test]
    fn a_record_fits_its_own_spectrum() {
        let range = [0.05, 1.2];
        let periods = compared_periods(range);
        let own = motion().response_spectrum(&periods, 0.05);
        for (unit, scale) in [("m/s2", 1.0), ("g", 1.0 / 9.80665), ("cm/s2", 100.0)] {
            let lines = periods.iter().zip(&own).map(|(t, a)| format!("{t},{}\n", 2.5 * a * scale));
            let (_folder, path) =
                file(&format!("# made\nperiod_s,sa [{unit}]\n{}", lines.collect::<String>()));
            let fit = TargetSpectrum::read(&path, range).expect("a spectrum").fit(&motion(), range, 0.05);
            assert!((fit.factor / 2.5 - 1.0).abs() < 1e-9 && fit.misfit < 1e-9, "{unit}: {fit:?}");
            assert!(fit.ratios.iter().all(|ratio| (ratio - 1.0).abs() < 1e-9), "{fit:?}");
        }
    }

    /// No other factor fits better.
    #[test]
    fn the_factor_is_the_best_one() {
        let range = [0.1, 1.0];
        let (_folder, path) = file("period_s,sa_g\n0.05,0.2\n0.3,0.5\n2.0,0.1\n");
        let target = TargetSpectrum::read(&path, range).expect("a spectrum");
        let (fit, periods) = (target.fit(&motion(), range, 0.05), compared_periods(range));
        let found = motion().response_spectrum(&periods, 0.05);
        let misfit = |factor: f64| {
            let square = |(t, a): (&f64, &f64)| (factor * a / target.at(*t)).ln().powi(2);
            (periods.iter().zip(&found).map(square).sum::<f64>() / periods.len() as f64).sqrt()
        };
        assert!((misfit(fit.factor) / fit.misfit - 1.0).abs() < 1e-12);
        assert!([0.97, 1.03].iter().all(|other| misfit(fit.factor * other) > fit.misfit), "{fit:?}");
        assert!(fit.ratios[0] < 1.0 && fit.ratios[1] > 1.0, "{fit:?}");
    }

    #[test]
    fn points_lie_on_straight_lines_in_logarithms() {
        let (_folder, path) = file("0.1 0.2\n0.4 0.8\n1.6 0.2\n");
        let target = TargetSpectrum::read(&path, [0.1, 1.6]).expect("a spectrum");
        for (period, share) in [(0.1, 0.2), (0.2, 0.4), (0.4, 0.8), (0.8, 0.4), (1.6, 0.2), (3.0, 0.2)] {
            let found = target.at(period) / super::super::STANDARD_GRAVITY;
            assert!((found - share).abs() < 1e-12, "{period}: {found}");
        }
    }

    #[test]
    fn a_wrong_file_says_where() {
        for (text, wanted) in [
            ("period,sa\n0.1,0.2\n0.1,0.3\n", ":3: `0.1,0.3` is not `period,acceleration`"),
            ("0.1,0.2\n0.2,-0.3\n", ":2: `0.2,-0.3`"),
            ("0.1,0.2\nx,y\n", ":2: `x,y`"),
            ("0.1,0.2,0.3\n", ":1: `0.1,0.2,0.3`"),
            ("period_s,sv [cm/s]\n0.1,0.2\n", "the values are velocities"),
            ("0.1,0.2\n0.5,0.3\n", "periods from 0.1 to 0.5 s, those from 0.100 to 1.000 s are compared"),
            ("", "periods from 0 to 0 s"),
        ] {
            let (_folder, path) = file(text);
            let error = TargetSpectrum::read(&path, [0.1, 1.0]).expect_err(wanted).to_string();
            assert!(error.contains(wanted), "{error}\nwanted: {wanted}");
        }
    }
}
