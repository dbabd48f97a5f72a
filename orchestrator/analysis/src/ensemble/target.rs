//! Records scaled to a target spectrum.

use super::EnsembleError;
use super::plan::{RecordEntry, Target};
use super::runs::digits;
use crate::table::Table;
use cofferdam_motion::{GroundMotion, SpectralFit, TargetSpectrum, compared_periods};
use cofferdam_report::SPECTRAL_DAMPING;
use std::path::Path;

/// Factors within which practice keeps.
const USUAL: [f64; 2] = [0.25, 4.0];

/// Scaling of records to a target spectrum.
pub struct Scaled {
    /// The periods that were compared, s.
    pub periods: Vec<f64>,
    /// The target at these, m/s².
    pub target: Vec<f64>,
    /// The scaled spectrum of each record at these, m/s².
    pub spectra: Vec<Vec<f64>>,
    /// Of each record.
    pub fits: Vec<SpectralFit>,
}

impl Scaled {
    /// Scales `motions` to `target` around `period` (s). `folder` is the plan's.
    ///
    /// **Errors**: [`EnsembleError::Target`].
    pub fn to(
        target: &Target,
        folder: &Path,
        period: f64,
        motions: &[GroundMotion],
    ) -> Result<Self, EnsembleError> {
        let range = target.range.map(|multiple| multiple * period);
        let wanted = TargetSpectrum::read(&folder.join(&target.spectrum), range)?;
        let periods = compared_periods(range);
        let fits: Vec<SpectralFit> =
            motions.iter().map(|motion| wanted.fit(motion, range, SPECTRAL_DAMPING)).collect();
        let spectrum = |(motion, fit): (&GroundMotion, &SpectralFit)| {
            let own = motion.response_spectrum(&periods, SPECTRAL_DAMPING);
            own.into_iter().map(|acceleration| fit.factor * acceleration).collect()
        };
        Ok(Self {
            target: periods.iter().map(|period| wanted.at(*period)).collect(),
            spectra: motions.iter().zip(&fits).map(spectrum).collect(),
            periods,
            fits,
        })
    }

    /// Text above the table.
    pub fn about(&self) -> String {
        let [from, to] = [self.periods.first(), self.periods.last()].map(|period| period.map_or(0.0, |t| *t));
        format!(
            "Records scaled to the target spectrum from {from:.3} to {to:.3} s: the factor makes the mean square of ln (spectrum over target) \
             least.\n\n"
        )
    }

    /// A row for each record, with all digits and in short.
    pub fn tables(&self, records: &[RecordEntry]) -> (Table, Table) {
        let headings = ["record", "factor", "misfit", "least ratio", "largest ratio"];
        let mut tables = (Table::new(headings), Table::new(headings));
        for (record, SpectralFit { factor, misfit, ratios: [least, largest] }) in
            records.iter().zip(&self.fits)
        {
            let row = |words: &dyn Fn(f64) -> String| {
                let numbers = [*factor, *misfit, *least, *largest].map(words);
                std::iter::once(record.name.clone()).chain(numbers).collect::<Vec<_>>()
            };
            tables.0.row(row(&|number| number.to_string()));
            tables.1.row(row(&digits));
        }
        tables
    }

    /// Factors that practice avoids.
    pub fn warnings(&self, records: &[RecordEntry]) -> Vec<String> {
        let [least, most] = USUAL;
        let unusual =
            records.iter().zip(&self.fits).filter(|(_, fit)| fit.factor < least || fit.factor > most);
        let warning = |(record, fit): (&RecordEntry, &SpectralFit)| {
            let factor = digits(fit.factor);
            format!(
                "{}: the factor {factor} to the target spectrum lies outside {least} to {most}; take a record of the target's strength",
                record.name
            )
        };
        unusual.map(warning).collect()
    }
}
