//! The ground motion, and response spectra.

use super::super::{RunSpectra, SPECTRAL_DAMPING, periods};
use super::data::{Abscissa, Chart, Mark, Row, Series};
use super::folder::RunFolder;
use super::thinning::{PARTS, kept, rounded};
use cofferdam_motion::{Component, STANDARD_GRAVITY};
use cofferdam_scene::LoadedScene;
use std::f64::consts::TAU;

/// Peaks, intensity and duration of a record; of a ramp its peak.
pub fn strength(run: &RunFolder) -> Vec<Row> {
    let motion = &run.loaded.ground_motion;
    let (peak, time) = motion.peak();
    let at = format!("at {time:.3} s");
    let mut rows = vec![Row::number("peak ground acceleration", peak / STANDARD_GRAVITY, "g").with(at)];
    if let Some(vertical) = motion.vertical() {
        let (peak, time) = vertical.peak();
        let at = format!("at {time:.3} s, positive upwards");
        rows.push(Row::number("peak vertical ground acceleration", peak / STANDARD_GRAVITY, "g").with(at));
    }
    if !is_record(&run.loaded) {
        return rows;
    }
    let (shocks, names) = (motion.shocks(), run.loaded.scene.ground_motion.shocks());
    for ((shock, begin), name) in shocks.iter().zip(motion.begins()).zip(&names) {
        let mut of = String::new();
        if shocks.len() > 1 {
            of = format!(", {}", name.label);
            let (peak, time) = shock.peak();
            let at = format!("at {:.3} s", begin + time);
            let name = format!("peak ground acceleration{of}");
            rows.push(Row::number(name, peak / STANDARD_GRAVITY, "g").with(at));
        }
        let [velocity, displacement] = shock.drift().map(|drift| drift.peak);
        let (intensity, duration) = shock.arias_intensity();
        rows.push(Row::number(format!("peak ground velocity{of}"), 1e2 * velocity, "cm/s"));
        rows.push(Row::number(format!("peak ground displacement{of}"), 1e2 * displacement, "cm"));
        rows.push(Row::number(format!("Arias intensity{of}"), intensity, "m/s").with("π/(2g) ∫ a² dt"));
        let row = Row::number(format!("significant duration{of}"), duration, "s");
        rows.push(row.with("5 to 95 % of the Arias intensity"));
    }
    for (water, frequency) in first_frequencies(run) {
        let period = TAU / frequency;
        let response = motion.response_spectrum(&[period], SPECTRAL_DAMPING)[0];
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
    let mut horizontal = history(motion.horizontal(), "Ground acceleration as recorded, g", "ground");
    let begins = loaded.scene.ground_motion.shocks().into_iter().zip(motion.begins()).skip(1);
    horizontal.marks = begins.map(|(shock, at)| Mark { horizontal: false, at, name: shock.label }).collect();
    let mut charts = vec![horizontal];
    charts.extend(motion.vertical().map(|vertical| {
        let title = "Vertical ground acceleration as recorded, g";
        history(vertical, title, "ground, positive upwards")
    }));
    let periods = periods();
    let values = motion.response_spectrum(&periods, SPECTRAL_DAMPING);
    let title = "Response spectrum of the record, pseudo-acceleration, g";
    charts.push(spectrum(title, &periods, &[("ground", &values)]));
    charts
}

/// The samples of a component.
fn history(component: &Component, title: &str, name: &str) -> Chart {
    let values: Vec<f64> = component.acceleration().iter().map(|a| a / STANDARD_GRAVITY).collect();
    let rows = kept(values.len(), &[&values], PARTS);
    let times: Vec<f64> = rows.iter().map(|row| *row as f64 * component.interval()).collect();
    let values: Vec<f64> = rows.iter().map(|row| values[*row]).collect();
    Chart {
        title: title.to_owned(),
        about: String::new(),
        abscissa: Abscissa::Times(rounded(&times)),
        logarithmic: false,
        range: None,
        series: vec![Series { name: name.to_owned(), values: rounded(&values) }],
        marks: Vec::new(),
    }
}

/// Spectra of crest and ground as they moved in the run, with the periods of the dam.
pub fn spectra(run: &RunFolder) -> Vec<Chart> {
    let Some(RunSpectra { periods, ground, crest }) = RunSpectra::of(&run.histories) else {
        return Vec::new();
    };
    let lines: [(&str, &[f64]); 2] = [("crest", &crest), ("base", &ground)];
    let mut chart = spectrum("Response spectra of crest and base, pseudo-acceleration, g", &periods, &lines);
    let mark = |(water, frequency): (&str, f64)| Mark {
        horizontal: false,
        at: TAU / frequency,
        name: format!("T₁ {water}"),
    };
    chart.marks = first_frequencies(run).into_iter().map(mark).collect();
    chart.about =
        "Total horizontal acceleration of the upstream crest corner and of the ground; 5 % damping."
            .to_owned();
    vec![chart]
}

/// A chart of spectra, m/s², over the `periods`, s.
fn spectrum(title: &str, periods: &[f64], lines: &[(&str, &[f64])]) -> Chart {
    let line = |(name, values): &(&str, &[f64])| {
        let values: Vec<f64> = values.iter().map(|a| a / STANDARD_GRAVITY).collect();
        Series { name: (*name).to_owned(), values: rounded(&values) }
    };
    Chart {
        title: title.to_owned(),
        about: String::new(),
        abscissa: Abscissa::Periods(rounded(periods)),
        logarithmic: false,
        range: None,
        series: lines.iter().map(line).collect(),
        marks: Vec::new(),
    }
}
