//! Response spectra of a run.

use cofferdam_assembly::observer::Histories;
use cofferdam_motion::response_spectrum;

/// Damping ratio of the oscillators.
pub const SPECTRAL_DAMPING: f64 = 0.05;
/// Shortest and longest period, s, and number of periods, at equal ratios.
const PERIODS: (f64, f64, i32) = (0.03, 3.0, 161);

/// The periods of all spectra, s.
pub fn periods() -> Vec<f64> {
    let (shortest, longest, count) = PERIODS;
    let ratio = (longest / shortest).powf(1.0 / f64::from(count - 1));
    (0..count).map(|i| shortest * ratio.powi(i)).collect()
}

/// Pseudo-acceleration response spectra of ground and upstream crest corner (horizontal, total acceleration) as they moved in a
/// run, m/s², with 5 % damping.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSpectra {
    /// Periods, s.
    pub periods: Vec<f64>,
    /// Of the ground.
    pub ground: Vec<f64>,
    /// Of the crest.
    pub crest: Vec<f64>,
}

impl RunSpectra {
    /// Those of `histories`; none without a dam or without a step.
    pub fn of(histories: &Histories) -> Option<Self> {
        let column = |name: &str| histories.column(name).unwrap_or(&[]);
        let [time, ground, crest] = ["time", "ground_acceleration.x", "dam.crest_acceleration.x"].map(column);
        if crest.len() < 2 {
            return None;
        }
        // To the picosecond, as times are written: equal steps of whole picoseconds then have equal intervals, whose oscillators need be found once only.
        let interval = |pair: &[f64]| ((pair[1] - pair[0]) * 1e12).round() / 1e12;
        let intervals: Vec<f64> = time.windows(2).map(interval).collect();
        // The ground acceleration is linear over a step, as in the units; that of the crest is a mean.
        let ground: Vec<f64> = ground.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
        let periods = periods();
        let of = |motion: &[f64]| response_spectrum(&intervals, motion, &periods, SPECTRAL_DAMPING);
        let (ground, crest) = (of(&ground), of(&crest[1..]));
        Some(Self { periods, ground, crest })
    }
}
