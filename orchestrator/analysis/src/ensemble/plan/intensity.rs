//! Scaling of records.

use cofferdam_motion::{GroundMotion, STANDARD_GRAVITY};
use cofferdam_report::SPECTRAL_DAMPING;
use serde::Deserialize;
use std::path::PathBuf;

/// Scaling of records.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Intensity {
    /// The measure.
    pub measure: Measure,
    /// Period of the oscillator, s; by default that of the dam's first mode with the water.
    pub period: Option<f64>,
    /// Values of the measure to which every record is scaled, g.
    pub levels: Vec<f64>,
    /// Factors on the records, in place of levels.
    pub scales: Vec<f64>,
    /// A spectrum to which the records are scaled before.
    pub target: Option<Target>,
}

/// A spectrum to which records are scaled.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Its file, from the plan's folder.
    pub spectrum: PathBuf,
    /// The periods that are compared, as multiples of the intensity's.
    #[serde(default = "around_the_first_period")]
    pub range: [f64; 2],
}

fn around_the_first_period() -> [f64; 2] {
    [0.2, 2.0]
}

/// Intensity measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Peak ground acceleration.
    #[default]
    Pga,
    /// Spectral acceleration with 5 % damping.
    Sa,
}

impl Intensity {
    /// The levels as tables call them.
    pub fn level_names(&self) -> Vec<String> {
        match (&self.levels[..], &self.scales[..]) {
            ([], []) if self.target.is_some() => vec!["target".to_owned()],
            ([], []) => vec!["as recorded".to_owned()],
            _ => {
                let [before, after] = self.affixes();
                self.values().iter().map(|value| format!("{before}{value}{after}")).collect()
            }
        }
    }

    /// The levels, g, or factors on the records.
    pub fn values(&self) -> Vec<f64> {
        match (&self.levels[..], &self.scales[..]) {
            ([], []) => vec![1.0],
            ([], scales) => scales.to_vec(),
            (levels, _) => levels.to_vec(),
        }
    }

    /// Adds levels or, if the plan has no levels, factors; those that it has already are left out.
    pub fn add(&mut self, added: &[f64]) {
        let mut values = self.values();
        values.extend(added);
        values.sort_by(f64::total_cmp);
        values.dedup();
        *(if self.levels.is_empty() { &mut self.scales } else { &mut self.levels }) = values;
    }

    /// What stands before and after a level or factor.
    pub fn affixes(&self) -> [&'static str; 2] {
        match (self.levels.is_empty(), &self.target) {
            (false, _) => ["", " g"],
            (true, None) => ["× ", ""],
            (true, Some(_)) => ["target × ", ""],
        }
    }

    /// The name of the measure; `period` in s.
    pub fn name(&self, period: f64) -> String {
        match self.measure {
            Measure::Pga => "PGA".to_owned(),
            Measure::Sa => format!("Sa({period:.3} s)"),
        }
    }

    /// The measure of a motion, g; `period` in s.
    pub fn of(&self, motion: &GroundMotion, period: f64) -> f64 {
        let acceleration = match self.measure {
            Measure::Pga => motion.peak().0.abs(),
            Measure::Sa => motion.response_spectrum(&[period], SPECTRAL_DAMPING)[0],
        };
        acceleration / STANDARD_GRAVITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectral_acceleration_of_a_resonant_sine() {
        // 40 periods of a sine of 1 m/s² at 2 Hz: 1/(2ξ) = 10 times, up to what is still missing of the steady state.
        let samples =
            (0..=4000).map(|i| (std::f64::consts::TAU * 2.0 * f64::from(i) * 0.005).sin()).collect();
        let motion = GroundMotion::of_samples("sine", 0.005, samples);
        let sa = Intensity { measure: Measure::Sa, ..Intensity::default() };
        let found = sa.of(&motion, 0.5) * STANDARD_GRAVITY;
        assert!((found / 10.0 - 1.0).abs() < 0.01, "{found}");
        assert!((Intensity::default().of(&motion, 0.5) * STANDARD_GRAVITY - 1.0).abs() < 1e-4);
    }
}
