//! The ground motion, and response spectra.

use super::super::response_spectrum;
use super::data::{Abscissa, Chart, Mark, Row, Series};
use super::folder::RunFolder;
use super::thinning::{kept, rounded};
use crate::ground_motion::{GroundMotion, STANDARD_GRAVITY};
use crate::scene::LoadedScene;
use std::f64::consts::TAU;

/// Damping ratio of the oscillators.
const DAMPING: f64 = 0.05;
/// Shortest and longest period, s, and number of periods, at equal ratios.
const PERIODS: (f64, f64, i32) = (0.03, 3.0, 161);

/// Peaks, intensity and duration of a record; of a ramp its peak.
pub fn strength(run: &RunFolder) -> Vec<Row> {
    let motion = &run.loaded.ground_motion;
    let (peak, time) = motion.peak();
    let at = format!("at {time:.3} s");
    let mut rows = vec![Row::number("peak ground acceleration", peak / STANDARD_GRAVITY, "g").with(at)];
    if !is_record(&run.loaded) {
        return rows;
    }
    let [velocity, displacement] = motion.drift().map(|drift| drift.peak);
    let (intensity, duration) = motion.arias_intensity();
    rows.push(Row::number("peak ground velocity", 1e2 * velocity, "cm/s"));
    rows.push(Row::number("peak ground displacement", 1e2 * displacement, "cm"));
    rows.push(Row::number("Arias intensity", intensity, "m/s").with("π/(2g) ∫ a² dt"));
    rows.push(Row::number("significant duration", duration, "s").with("5 to 95 % of the Arias intensity"));
    let (intervals, means) = intervals(motion);
    for (water, frequency) in first_frequencies(run) {
        let period = TAU / frequency;
        let response = response_spectrum(&intervals, &means, &[period], DAMPING)[0];
        let name = format!("spectral acceleration at T₁ ({water})");
        let remark = format!("T₁ = {period:.4} s of the intact dam, 5 % damping");
        rows.push(Row::number(name, response / STANDARD_GRAVITY, "g").with(remark));
    }
    rows
}

/// Whether the ground moves as in a record, which ends.
fn is_record(loaded: &LoadedScene) -> bool {
    loaded.scene.ground_motion.record.is_some()
}

/// Lengths of the intervals of a motion, and its mean over each.
fn intervals(motion: &GroundMotion) -> (Vec<f64>, Vec<f64>) {
    let means: Vec<f64> = motion.acceleration().windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
    (vec![motion.interval(); means.len()], means)
}

/// The lowest natural frequencies that the summary has, rad/s, and with what water.
fn first_frequencies(run: &RunFolder) -> Vec<(&'static str, f64)> {
    let of = |water: &'static str| {
        let value = run.summary.value(&format!("natural frequency 1 (intact, {water})"))?;
        (value > 0.0).then_some((water, value))
    };
    ["empty", "full"].into_iter().filter_map(of).collect()
}

/// The record and its response spectrum; nothing of a ramp.
pub fn charts(loaded: &LoadedScene) -> Vec<Chart> {
    let motion = &loaded.ground_motion;
    if !is_record(loaded) {
        return Vec::new();
    }
    let values: Vec<f64> = motion.acceleration().iter().map(|a| a / STANDARD_GRAVITY).collect();
    let rows = kept(values.len(), &[&values]);
    let times: Vec<f64> = rows.iter().map(|row| *row as f64 * motion.interval()).collect();
    let values: Vec<f64> = rows.iter().map(|row| values[*row]).collect();
    let history = Chart {
        title: "Ground acceleration as recorded, g".to_owned(),
        about: String::new(),
        abscissa: Abscissa::Times(rounded(&times)),
        logarithmic: false,
        range: None,
        series: vec![Series { name: "ground".to_owned(), values: rounded(&values) }],
        marks: Vec::new(),
    };
    let (intervals, means) = intervals(motion);
    vec![
        history,
        spectrum(
            "Response spectrum of the record, pseudo-acceleration, g",
            &[("ground", &intervals, &means)],
        ),
    ]
}

/// Spectra of crest and ground as they moved in the run, with the periods of the dam.
pub fn spectra(run: &RunFolder) -> Vec<Chart> {
    let column = |name: &str| run.histories.column(name).unwrap_or(&[]);
    let [time, ground, crest] = ["time", "ground_acceleration.x", "dam.crest_acceleration.x"].map(column);
    if crest.len() < 2 {
        return Vec::new();
    }
    let intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // The ground acceleration is linear over a step; that of the crest is a mean.
    let ground: Vec<f64> = ground.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
    let motions: [(&str, &[f64], &[f64]); 2] =
        [("crest", &intervals, &crest[1..]), ("base", &intervals, &ground)];
    let mut chart = spectrum("Response spectra of crest and base, pseudo-acceleration, g", &motions);
    let mark = |(water, frequency): (&str, f64)| Mark {
        horizontal: false,
        at: TAU / frequency,
        name: format!("T₁ {water}"),
    };
    chart.marks = first_frequencies(run).into_iter().map(mark).collect();
    chart.about =
        "Total horizontal acceleration of the upstream crest corner, and of the ground; 5 % damping."
            .to_owned();
    vec![chart]
}

fn spectrum(title: &str, motions: &[(&str, &[f64], &[f64])]) -> Chart {
    let (shortest, longest, count) = PERIODS;
    let ratio = (longest / shortest).powf(1.0 / f64::from(count - 1));
    let periods: Vec<f64> = (0..count).map(|i| shortest * ratio.powi(i)).collect();
    let line = |(name, intervals, acceleration): &(&str, &[f64], &[f64])| {
        let values = response_spectrum(intervals, acceleration, &periods, DAMPING);
        let values: Vec<f64> = values.iter().map(|a| a / STANDARD_GRAVITY).collect();
        Series { name: (*name).to_owned(), values: rounded(&values) }
    };
    Chart {
        title: title.to_owned(),
        about: String::new(),
        abscissa: Abscissa::Periods(rounded(&periods)),
        logarithmic: false,
        range: None,
        series: motions.iter().map(line).collect(),
        marks: Vec::new(),
    }
}
