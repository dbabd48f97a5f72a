//! Output of `--json`.

use cofferdam_coupling::observer::WallTime;
use cofferdam_report::{Quantity, Summary};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The results of a run that reached its first step.
#[derive(Serialize)]
pub struct Answer<'a> {
    status: &'a str,
    folder: &'a Path,
    /// s.
    simulated_time: f64,
    notes: &'a [String],
    /// Damping and fidelity of the dam.
    model: BTreeMap<&'a str, &'a str>,
    key_figures: Vec<&'a Quantity>,
    quantities: &'a [Quantity],
    /// s, of the whole run and of its parts.
    wall_time: BTreeMap<&'a str, f64>,
}

impl<'a> Answer<'a> {
    pub fn of(folder: &'a Path, summary: &'a Summary, dam: &'a [(&str, String)], wall: &'a WallTime) -> Self {
        let whole =
            [("total", wall.total), ("exchange", wall.exchange()), ("log and histories", wall.observers)];
        let units = wall.inside.iter().map(|(unit, time)| (unit.as_str(), *time));
        Self {
            status: &summary.status,
            folder,
            simulated_time: summary.simulated_time,
            notes: &summary.notes,
            model: dam.iter().map(|(what, words)| (*what, words.as_str())).collect(),
            key_figures: summary.key_figures(),
            quantities: &summary.quantities,
            wall_time: whole
                .into_iter()
                .chain(units)
                .map(|(name, time)| (name, time.as_secs_f64()))
                .collect(),
        }
    }
}

/// A run without results.
#[derive(Serialize)]
pub struct NoAnswer {
    pub status: String,
    pub exit_status: u8,
}
