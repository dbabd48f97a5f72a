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
    of_level(cracked, fidelity, rung, quantity).max_by(|a, b| a.largest().total_cmp(&b.largest()))
}

/// The rows of a level, one for each intensity.
fn of_level(
    cracked: bool,
    fidelity: DamFidelityScene,
    rung: usize,
    quantity: &str,
) -> impl Iterator<Item = &'static LevelError> {
    TABLE.levels.iter().filter(move |row| {
        row.cracked == cracked && row.fidelity == fidelity && row.rung == rung && row.quantity == quantity
    })
}

/// Cases that are enough to state an error.
const ENOUGH: usize = 4;
/// Ratio of peak accelerations, and of element sizes, up to which a case is near a scene.
const NEAR: f64 = 1.5;

/// What the table says about the numerical error of one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Crest, history or sliding.
    pub quantity: &'static str,
    /// Mean and standard deviation of the relative error; `None` with too few cases near the scene.
    pub error: Option<[f64; 2]>,
    /// Number of cases near the scene.
    pub cases: usize,
    /// Element size of the nearest level, m.
    pub size: f64,
}

/// The numerical error of each quantity that the table lets expect of a scene as it is, whose ground has this `peak` acceleration (g),
/// from the cases near it.
pub fn expected(scene: &Scene, peak: f64) -> Vec<Expected> {
    let Some(dam) = &scene.dam else { return Vec::new() };
    let cracked = !dam.cracks.is_empty() && !dam.fidelity.is_intact();
    let sizes = Ladder::of(scene).sizes;
    let away = |size: &f64| (size / dam.element_size).ln().abs();
    let Some(rung) = (0..sizes.len()).min_by(|a, b| away(&sizes[*a]).total_cmp(&away(&sizes[*b]))) else {
        return Vec::new();
    };
    // Without cracks the modes and the elements themselves have the same errors but for those of the modes.
    let fidelity = match (cracked, dam.fidelity) {
        (false, _) => DamFidelityScene::Intact,
        (true, level) if level.has_elements() => DamFidelityScene::Reduced,
        (true, other) => other,
    };
    let size = sizes[rung];
    let is_near = |row: &&LevelError| {
        away(&size) <= NEAR.ln() && peak > 0.0 && (row.intensity / peak).ln().abs() <= NEAR.ln()
    };
    let quantities: &[&str] = if cracked { &[CREST, HISTORY, SLIDING] } else { &[CREST, HISTORY] };
    let of = |quantity: &&'static str| {
        let rows = of_level(cracked, fidelity, rung, quantity).filter(is_near);
        let (cases, error) = pooled(rows);
        Expected { quantity, error: error.filter(|_| cases >= ENOUGH), cases, size }
    };
    quantities.iter().map(of).collect()
}

/// Number, mean and standard deviation of the cases of several rows: `(N − 1) s² = Σ (n − 1) sᵢ² + Σ n (bᵢ − b)²`.
fn pooled<'a>(rows: impl Iterator<Item = &'a LevelError>) -> (usize, Option<[f64; 2]>) {
    let rows: Vec<&LevelError> = rows.collect();
    let cases: usize = rows.iter().map(|row| row.cases).sum();
    if cases < 2 {
        return (cases, None);
    }
    let mean = rows.iter().map(|row| row.cases as f64 * row.bias).sum::<f64>() / cases as f64;
    let squares = rows.iter().map(|row| {
        (row.cases as f64 - 1.0) * row.spread.powi(2) + row.cases as f64 * (row.bias - mean).powi(2)
    });
    (cases, Some([mean, (squares.sum::<f64>() / (cases - 1) as f64).sqrt()]))
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

    #[test]
    fn pooled_rows_are_those_of_all_their_cases() {
        // Errors 0.1, 0.3 and 0.2, 0.4, 0.6.
        let row = |bias: f64, spread: f64, cases: usize| LevelError {
            cracked: true,
            fidelity: DamFidelityScene::Reduced,
            rung: 0,
            quantity: CREST.to_owned(),
            intensity: 0.5,
            bias,
            spread,
            cases,
        };
        let rows = [row(0.2, 0.02f64.sqrt(), 2), row(0.4, 0.2, 3)];
        let (cases, error) = pooled(rows.iter());
        let [mean, deviation] = error.expect("five cases");
        assert!(cases == 5 && (mean - 0.32).abs() < 1e-15 && (deviation - 0.037f64.sqrt()).abs() < 1e-15);
        assert_eq!(pooled(rows[..0].iter()), (0, None));
    }
}
