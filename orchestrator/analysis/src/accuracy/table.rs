//! The table of measured errors of levels, which `cofferdam-lab accuracy` writes.

use super::{CREST, HISTORY, Ladder, SLIDING};
use cofferdam_scene::{DamFidelityScene, Scene};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Errors by level.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorTable {
    /// Raised whenever it is measured again.
    pub version: u32,
    /// The rows.
    #[serde(default, rename = "level")]
    pub levels: Vec<LevelError>,
}

/// Bias and spread of a level, of one quantity at one intensity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelError {
    /// Whether the dam has cracks that are computed.
    pub cracked: bool,
    /// Level of the dam.
    pub fidelity: DamFidelityScene,
    /// Number of the rung, from the coarsest elements.
    pub rung: usize,
    /// Crest, history or sliding.
    pub quantity: String,
    /// Largest peak acceleration of the ground of the cases, g.
    pub intensity: f64,
    /// Mean of the relative error.
    pub bias: f64,
    /// Its standard deviation.
    pub spread: f64,
    /// Number of cases.
    pub cases: usize,
}

impl LevelError {
    /// What a case must be expected to have: |bias| + 2 spread.
    pub fn largest(&self) -> f64 {
        self.bias.abs() + 2.0 * self.spread
    }
}

/// The table of this build.
pub static TABLE: LazyLock<ErrorTable> = LazyLock::new(|| {
    // A test reads it, so that no build has another one.
    toml::from_str(include_str!("table.toml")).unwrap_or_default()
});

/// The largest error in the table of a level, over all intensities; none if it was not measured.
pub fn largest(
    cracked: bool,
    fidelity: DamFidelityScene,
    rung: usize,
    quantity: &str,
) -> Option<&'static LevelError> {
    let rows = TABLE.levels.iter().filter(|row| {
        row.cracked == cracked && row.fidelity == fidelity && row.rung == rung && row.quantity == quantity
    });
    rows.max_by(|a, b| a.largest().total_cmp(&b.largest()))
}

/// The error of each quantity that the table lets expect of a scene as it is, and where that comes from.
pub fn expected(scene: &Scene) -> Vec<(&'static str, f64, String)> {
    let Some(dam) = &scene.dam else { return Vec::new() };
    let cracked = !dam.cracks.is_empty() && !dam.fidelity.is_intact();
    let sizes = Ladder::of(scene).sizes;
    let nearest = |a: &f64| (a / dam.element_size).ln().abs();
    let Some(rung) = (0..sizes.len()).min_by(|a, b| nearest(&sizes[*a]).total_cmp(&nearest(&sizes[*b])))
    else {
        return Vec::new();
    };
    // Without cracks the modes and the elements themselves have the same errors but for those of the modes.
    let fidelity = match (cracked, dam.fidelity) {
        (false, _) => DamFidelityScene::Intact,
        (true, level) if level.has_elements() => DamFidelityScene::Reduced,
        (true, other) => other,
    };
    let quantities: &[&str] = if cracked { &[CREST, HISTORY, SLIDING] } else { &[CREST, HISTORY] };
    let found = quantities.iter().filter_map(|quantity| {
        let row = largest(cracked, fidelity, rung, quantity)?;
        let origin = format!(
            "table {}, elements of {:.2} m: bias {:+.1} %, spread {:.1} % in {} cases, against the reference; `cofferdam run \
             --accuracy` measures it for this record",
            TABLE.version,
            sizes[rung],
            100.0 * row.bias,
            100.0 * row.spread,
            row.cases
        );
        Some((*quantity, row.largest(), origin))
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_this_build_can_be_read_and_has_the_finest_levels() {
        let table: ErrorTable = toml::from_str(include_str!("table.toml")).expect("a table");
        assert!(table.version > 0);
        for (cracked, fidelity, quantity) in [
            (false, DamFidelityScene::Intact, HISTORY),
            (true, DamFidelityScene::Reduced, CREST),
            (true, DamFidelityScene::Reduced, SLIDING),
        ] {
            let row = largest(cracked, fidelity, Ladder::RUNGS - 1, quantity).expect("a row");
            assert!(row.largest() > 0.0 && row.largest() < 0.1, "{row:?}");
        }
    }
}
