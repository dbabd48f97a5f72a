//! The report of two runs side by side; A is the reference.
//!
//! Data flow as for one run: two [`RunFolder`]s → [`PairData`] → [`html`].

mod charts;
mod compared;
mod data;
mod document;
mod inputs;

pub use data::{
    Beside, Compared, CrestAgreement, Head, PairChart, PairData, PairGroup, PairProfile, Shared, Within,
};
pub use document::html;

use super::folder::RunFolder;
use super::{ReportData, profile};
use cofferdam_log::{LogReadError, equal_keys};

impl PairData {
    /// Reads the contents from the files of two runs; `folders` are the names of their folders.
    ///
    /// **Errors**: a log cannot be read.
    pub fn of(runs: [&RunFolder; 2], folders: [String; 2]) -> Result<Self, LogReadError> {
        let data = [ReportData::of(runs[0], None)?, ReportData::of(runs[1], None)?];
        let [a, b] = &data;
        let (scene, origin) = inputs::differing(runs);
        let equal = inputs::equal(runs, equal_keys(runs.map(|run| &run.log)));
        let quantities = compared::of([&a.quantities, &b.quantities]);
        // What matters first in one run is shown of both.
        let first = a.key_figures.iter().chain(&b.key_figures);
        let mut names: Vec<&str> = Vec::new();
        first.map(|figure| &*figure.name).for_each(|name| {
            if !names.contains(&name) {
                names.push(name)
            }
        });
        let figure = |name: &&str| quantities.iter().find(|quantity| quantity.name == **name).cloned();
        let same_motion = runs[0].loaded.ground_motion == runs[1].loaded.ground_motion;
        let [first, second] = folders;
        Ok(Self {
            runs: [head(a, first), head(b, second)],
            dams: inputs::dams(runs),
            key_figures: names.iter().filter_map(figure).collect(),
            crest: compared::crest(runs.map(|run| &run.histories)),
            scene,
            origin,
            equal,
            warnings: Shared::of([a.warnings.clone(), b.warnings.clone()]),
            notes: Shared::of([a.notes.clone(), b.notes.clone()]),
            not_modelled: Shared::of([a.not_modelled.clone(), b.not_modelled.clone()]),
            times: [a.time.clone(), b.time.clone()],
            ground: [a.ground.clone(), b.ground.clone()],
            ground_charts: if same_motion {
                Vec::new()
            } else {
                charts::of([&a.ground_charts, &b.ground_charts])
            },
            histories: charts::of([&a.histories, &b.histories]),
            spectra: charts::of([&a.spectra, &b.spectra]),
            profiles: profiles(a, runs[1])?,
            checks: compared::checks([&a.checks, &b.checks]),
            quantities,
        })
    }
}

fn head(data: &ReportData, folder: String) -> Head {
    Head {
        title: data.title.clone(),
        folder,
        status: data.status.clone(),
        complete: data.complete,
        started: data.started.clone(),
        simulated_time: data.simulated_time,
    }
}

/// Pressures of A at its chosen instants, and of B at the same instants.
fn profiles(a: &ReportData, b: &RunFolder) -> Result<Vec<PairProfile>, LogReadError> {
    let of = |own: &super::Profile| {
        let (time, line) = profile::nearest(b, &own.water, own.time)?.unzip();
        Ok(PairProfile {
            instant: own.instant.clone(),
            water: own.water.clone(),
            times: [Some(own.time), time],
            lines: [own.computed.clone(), line.unwrap_or_default()],
        })
    };
    a.profiles.iter().map(of).collect()
}
