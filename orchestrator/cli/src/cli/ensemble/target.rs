//! Records scaled to a target spectrum, and which polarity of a record governs.

use super::EnsembleError;
use super::plan::{RecordEntry, Target};
use super::runs::{Runs, digits};
use crate::cli::table::Table;
use cofferdam_analysis::statistics::quantile;
use cofferdam_motion::{GroundMotion, SpectralFit, TargetSpectrum, compared_periods};
use cofferdam_report::SPECTRAL_DAMPING;
use std::path::Path;

/// Factors within which practice keeps.
const USUAL: [f64; 2] = [0.25, 4.0];

/// How records were scaled to a target spectrum.
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

    /// What stands above its table.
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

/// Which polarity governs, of every quantity of the short tables: a row for each record and level, and for each level; none of one polarity.
pub fn governing(runs: &Runs<'_>) -> Option<(Table, Table)> {
    let plan = &runs.ensemble.plan;
    if plan.polarities.len() < 2 {
        return None;
    }
    let mut table = Table::new(["quantity", "level", "record", "+1", "-1", "governs"]);
    let mut short = Table::new(["quantity", "level", "+1 governs", "-1 governs", "largest", "of"]);
    for (name, unit) in runs.shown() {
        for (level, of_level) in runs.levels() {
            let (mut counts, mut largest) = ([0usize; 2], None::<(f64, String)>);
            for (number, record) in plan.records.iter().enumerate() {
                let median = |polarity: i64| {
                    let of_record = of_level.iter().filter(|index| {
                        let sample = &runs.ensemble.samples[**index];
                        sample.record == number && sample.polarity == polarity
                    });
                    let mut values: Vec<f64> =
                        of_record.map(|index| runs.kept[*index].value(&name).abs()).collect();
                    values.retain(|value| !value.is_nan());
                    values.sort_by(f64::total_cmp);
                    if values.is_empty() { f64::NAN } else { quantile(&values, 0.5) }
                };
                let both = [median(1), median(-1)];
                let governs = match both {
                    [plus, minus] if plus > minus => Some(0),
                    [plus, minus] if minus > plus => Some(1),
                    _ => None,
                };
                let words = ["+1", "-1"];
                if let Some(governs) = governs {
                    counts[governs] += 1;
                    if largest.as_ref().is_none_or(|(value, _)| both[governs] > *value) {
                        largest = Some((both[governs], format!("{}, {}", record.name, words[governs])));
                    }
                }
                let number = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
                let row = [format!("{name} [{unit}]"), level.clone(), record.name.clone()];
                let governs = governs.map_or("", |governs| words[governs]).to_owned();
                table.row(row.into_iter().chain(both.map(number)).chain([governs]));
            }
            let (value, of) = largest.unwrap_or_default();
            let counts = counts.map(|count| format!("{count} of {}", plan.records.len()));
            short.row(
                [format!("{name} [{unit}]"), level].into_iter().chain(counts).chain([digits(value), of]),
            );
        }
    }
    Some((table, short))
}
