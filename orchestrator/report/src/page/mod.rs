//! The report of a run: one self-contained HTML page.
//!
//! Data flow one way: [`RunFolder`] (files of a run) → [`ReportData`] (contents) → [`html`] (text). [`pair`] does the
//! same for two runs, [`ensemble`] for an ensemble.

mod acceptance;
mod animation;
mod charts;
mod checks;
mod data;
mod document;
pub mod ensemble;
mod envelope_picture;
pub mod file;
mod folder;
mod ground;
mod inputs;
mod limits;
mod number;
pub mod pair;
mod performance;
mod profile;
mod profile_picture;
mod remarks;
mod tables;
mod thinning;
mod westergaard;

pub use data::{
    Abscissa, Animation, Chart, Check, Counted, Envelope, Group, Mark, MovingWater, Performance, Profile,
    ReportData, Rounded, Row, Series, Value,
};
pub use document::html;
pub use file::PageError;
pub use folder::{ReportError, RunFolder};
pub use limits::not_modelled;
pub use thinning::kept;

use super::envelopes::{END, overstress};
use super::stability::{StabilityTable, notes, of_run, tables as tables_of};
use super::{RangeQuantity, RangeRecord};
use cofferdam_assembly::vtk::Grid;
use cofferdam_log::LogReadError;
use std::collections::BTreeMap;

impl ReportData {
    /// Reads the contents from the files of a run; `section` is a picture of its section as SVG.
    ///
    /// **Errors**: its log cannot be read.
    pub fn of(run: &RunFolder, section: Option<String>) -> Result<Self, LogReadError> {
        let (scene, summary) = (&run.loaded.scene, &run.summary);
        let (warnings, notes) = remarks::of(run)?;
        let (stability, notes_of_stability, resultants) = stability(run);
        Ok(Self {
            title: scene.title.clone(),
            name: run.manifest.name.clone(),
            status: summary.status.clone(),
            complete: summary.status == cofferdam_coupling::observer::Status::Completed.to_string(),
            started: run.manifest.started.clone(),
            simulated_time: summary.simulated_time,
            project: scene.report.texts().into_iter().map(|(_, name, text)| Row::text(name, text)).collect(),
            acceptance: acceptance::criteria(&scene.report.limits, summary),
            key_figures: summary.key_figures().into_iter().cloned().collect(),
            ranges: BTreeMap::new(),
            warnings,
            notes,
            not_modelled: limits::not_modelled(scene),
            section,
            envelope: run.envelope.as_ref().and_then(|grid| envelope(run, grid)),
            animation: animation::of(run),
            inputs: inputs::of(scene, &run.manifest, &run.loaded.ground_motion),
            provenance: inputs::provenance(run),
            scene: inputs::scene_text(scene),
            ground: ground::strength(run),
            time: run.histories.column("time").unwrap_or(&[]).to_vec(),
            ground_charts: ground::charts(&run.loaded),
            histories: charts::of(run),
            sliding_times: charts::sliding_times(run),
            spectra: ground::spectra(run),
            profiles: profile::of(run)?,
            stability: (stability, notes_of_stability),
            resultants: resultants.into_iter().collect(),
            checks: checks::of(run),
            quantities: summary.quantities.clone(),
        })
    }

    /// The same with the `range` of the scene at its key figures, and what it rests on in the notes.
    #[must_use]
    pub fn with_range(mut self, range: &RangeRecord) -> Self {
        for figure in &self.key_figures {
            if let Some(quantity) = range.of_quantity(&figure.name) {
                let magnitude =
                    if figure.value < 0.0 && quantity.as_it_is > 0.0 { "magnitude: " } else { "" };
                self.ranges.insert(figure.name.clone(), format!("{magnitude}{}", in_words(quantity)));
            }
        }
        let all = match range.samples {
            0 => "one factor changed at a time".to_owned(),
            samples => format!("{samples} runs in which all factors vary"),
        };
        let factors: Vec<&str> = range.factors.iter().map(|factor| &*factor.name).collect();
        let failed = match range.failed.len() {
            0 => String::new(),
            count => format!("; {count} of {} runs failed", range.runs),
        };
        self.notes.push(format!(
            "ranges of key figures: {all} ({}); {}{failed}",
            factors.join(", "),
            range.model
        ));
        self
    }
}

/// The range of a quantity and what dominates it.
fn in_words(quantity: &RangeQuantity) -> String {
    let interval = match &quantity.combined {
        Some(all) => {
            format!("range {}, 5 to 95 % of {} runs", quantity.shown_interval(all.interval), all.runs)
        }
        None => {
            let swings = quantity.swings.iter().map(|swing| swing.interval(quantity.as_it_is));
            let [low, high] =
                swings.fold([quantity.as_it_is; 2], |[a, b], [low, high]| [a.min(low), b.max(high)]);
            format!("range {}, one factor at a time", quantity.shown_interval([low, high]))
        }
    };
    match quantity.dominant().as_slice() {
        [] => interval,
        factors => format!("{interval}; dominated by {}", factors.join(", ")),
    }
}

/// The stability of the joints that the run could open, and what its numbers rest on.
fn stability(run: &RunFolder) -> (Vec<StabilityTable>, Vec<String>, Option<Chart>) {
    let scene = &run.loaded.scene;
    match of_run(&run.loaded, &run.histories, &[]) {
        Ok((joints, shaken)) if !joints.is_empty() => {
            let lengths: BTreeMap<usize, f64> =
                joints.iter().map(|joint| (joint.crack, joint.length)).collect();
            let chart = charts::resultants(run, &lengths);
            (tables_of(scene, &joints, &shaken), notes(scene, &joints), chart)
        }
        // the scene was computed, so that nothing but joints can be missing
        _ => (Vec::new(), Vec::new(), None),
    }
}

/// The envelope of the largest principal stress, and the overstress.
fn envelope(run: &RunFolder, grid: &Grid) -> Option<Envelope> {
    let (_, end) = grid.field_data.iter().find(|(name, _)| name == END)?;
    let overstress = overstress(grid);
    let performance = performance::of(run, grid, &overstress);
    let rows = overstress.into_iter().map(|quantity| Row {
        value: Value::Number(quantity.value, unit(&quantity.unit)),
        remark: quantity.place.map_or_else(String::new, |[x, y]| format!("x = {x} m, y = {y} m")),
        name: quantity.name,
    });
    let strength = run.loaded.scene.dam.as_ref().and_then(|dam| dam.material.tensile_strength);
    let given = strength.map(|strength| Row::number("tensile strength", 1e-6 * strength, "MPa"));
    Some(Envelope {
        end: *end.first()?,
        picture: envelope_picture::picture(grid)?,
        rows: given.into_iter().chain(rows).collect(),
        performance,
    })
}

/// The unit of an overstress.
fn unit(of: &str) -> &'static str {
    ["m²", "%", "s"].into_iter().find(|known| *known == of).unwrap_or("1")
}
