//! The numerics of a run from the requested accuracy: a pilot of low-fidelity runs, then the cheapest level whose error is expected
//! to be small enough.
//!
//! Levels form a ladder: five lengths of elements, the dam by modes where nothing slides and by reduced blocks where it may, the
//! recursion, and the communication step. Errors are meant against the *reference*: every element and contact, the finest elements of
//! the ladder, half the communication step, Radau IIA and a tolerance of 1e-8.

use cofferdam_assembly::AssemblyError;
mod asked;
mod choice;
mod ladder;
pub mod pilot;
mod promise;
pub mod table;

pub use asked::Asked;
pub use choice::apart;
pub use ladder::Ladder;
pub use promise::{Promise, Verdict, announce};

use crate::context::Context;
use asked::UNNAMED;
use choice::{Decision, Pilot, moving, still};
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_report::Accuracy;
use cofferdam_scene::{DamFidelityScene, DampingModel, LoadedScene, Scene, SceneError, Warning};
use miette::Diagnostic;
use pilot::LEAST_SLIDING;
use promise::{CANNOT, KEPT, NOT_KEPT};
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

/// The largest displacements of the crest.
pub const CREST: &str = "crest";
/// The history of the crest.
pub const HISTORY: &str = "history";
/// Sliding at the end.
pub const SLIDING: &str = "sliding";

/// Share of the strictest accuracy that the communication step may use up, and how often it is halved for that. Its error is that of
/// linear inputs at the highest frequency of the record, (ωH)²/12.
const OF_STEP: f64 = 0.25;
const MOST_HALVINGS: i32 = 3;
/// Share of the record's Fourier energy below its highest frequency.
const ENERGY: f64 = 0.99;
/// Changes of the shaking.
pub const MORE_OR_LESS: f64 = 0.01;

/// Reason why no accuracy can be promised.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum AccuracyError {
    /// The scene, with a level's keys.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A unit.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A run of the pilot.
    #[error("the pilot failed: {what}: {cause}; run without an accuracy, and look at its log")]
    Run {
        /// Which run.
        what: String,
        /// What was wrong.
        cause: Box<SimulationError>,
    },
    /// A scene for which there is no ladder.
    #[error("no accuracy can be requested here: {why}")]
    Unfit {
        /// Reason and remedy.
        why: String,
    },
}

/// Reason why a scene has no ladder of levels.
fn unfit(scene: &Scene) -> Option<&'static str> {
    let Some(dam) = &scene.dam else {
        return Some("the dam is prescribed and has no error of its own; leave --accuracy out");
    };
    let foreign = dam.fidelity.is_foreign() || scene.has_foreign_water();
    match dam {
        _ if foreign => Some("a unit belongs to another program with its own numerics; leave --accuracy out"),
        _ if dam.mesh.is_some() => Some(
            "the mesh is that of a file and cannot be refined; take the section and `dam.element_size`, or leave --accuracy out",
        ),
        _ if dam.fidelity == DamFidelityScene::RigidBlocks => {
            Some("blocks that do not deform are another model; choose \"dem\" or \"reduced\"")
        }
        _ if scene.ground_motion.record.is_none() => {
            Some("the ground moves by a ramp; give a record, or leave --accuracy out")
        }
        _ if scene.time.adaptive.is_some() => {
            Some("communication steps are adaptive; leave out [time.adaptive] or --accuracy")
        }
        _ => None,
    }
}

/// The communication step that the record needs, s: the scene's, or a shorter one where that is too long.
fn communication_step(loaded: &LoadedScene) -> f64 {
    let better = loaded.warnings.iter().filter_map(|warning| match &warning.warning {
        Warning::CoarseStep { better, .. } | Warning::ClippedSamples { better, .. } => Some(*better),
        _ => None,
    });
    better.fold(loaded.scene.time.communication_step, f64::min)
}

/// Runs the pilot of a scene that was read from `path` with `settings`, and chooses.
///
/// **Errors**: a scene without a ladder; units that cannot be made; a run of the pilot that fails.
pub fn promise(
    path: &Path,
    settings: &[String],
    loaded: &LoadedScene,
    asked: &Asked,
    context: &Context<'_>,
) -> Result<Promise, AccuracyError> {
    if let Some(why) = unfit(&loaded.scene) {
        return Err(AccuracyError::Unfit { why: why.to_owned() });
    }
    let began = Instant::now();
    let Some(dam) = &loaded.scene.dam else {
        return Err(AccuracyError::Unfit { why: "there is no dam".to_owned() });
    };
    let cracked = !dam.cracks.is_empty() && !dam.fidelity.is_intact();
    let fidelity = match cracked {
        false => DamFidelityScene::Intact,
        // Reduced blocks have no local damping.
        true if dam.damping.model == DampingModel::Local => DamFidelityScene::Dem,
        true => DamFidelityScene::Reduced,
    };
    let step = communication_step(loaded);
    let mut base = settings.to_vec();
    base.push(format!("time.communication_step={step}"));
    let ladder = Ladder::of(&loaded.scene);
    let mut pilot = Pilot { scene: path, base, ladder, loaded, fidelity, runs: 0, context };
    let outcomes = pilot.run(&[pilot.shaken(1, 1.0), pilot.shaken(0, 1.0)])?;
    let moves = cracked && outcomes.iter().any(|outcome| outcome.moved > LEAST_SLIDING);
    let mut wanted = asked.0.clone();
    let unnamed = wanted.remove(UNNAMED).is_some();
    if !cracked {
        wanted.remove(SLIDING);
    }
    if moves && unnamed {
        wanted.remove(HISTORY);
    }
    let strictest = wanted.values().copied().fold(1.0, f64::min);
    let highest = loaded.ground_motion.components().map(|component| component.frequency_below_which(ENERGY));
    let highest = TAU * highest.fold(0.0, f64::max);
    let of_step = |halvings: i32| (highest * step * 0.5_f64.powi(halvings)).powi(2) / 12.0;
    let enough = |halvings: &i32| of_step(*halvings) <= OF_STEP * strictest;
    let halvings = (0..MOST_HALVINGS).find(enough).unwrap_or(MOST_HALVINGS);
    let of_step = of_step(halvings);
    let decided = if moves {
        moving(&mut pilot, &wanted, of_step)?
    } else {
        still(&pilot, &wanted, &outcomes, of_step)
    };
    let Decision { rung, fidelity, expected, sensitivity, left_by_reference, band } = decided;
    let worst = wanted.iter().map(|(quantity, asked)| {
        let (error, change) = (expected.get(quantity), sensitivity.get(quantity));
        match (error, change) {
            (_, Some(change)) if moves && change > asked => CANNOT,
            (Some(error), _) if error <= asked => KEPT,
            _ => NOT_KEPT,
        }
    });
    let rank = |verdict: &&str| [KEPT, NOT_KEPT, CANNOT].iter().position(|own| own == verdict);
    let verdict = worst.max_by_key(rank).unwrap_or(KEPT);
    let mut chosen = pilot.ladder.settings(&loaded.scene, rung, fidelity);
    let own = step * 0.5_f64.powi(halvings);
    chosen.push(format!("time.communication_step={own}"));
    let record = Accuracy {
        verdict: verdict.to_owned(),
        asked: wanted,
        expected,
        sensitivity,
        left_by_reference,
        chosen,
        pilot_runs: pilot.runs,
        pilot_time: began.elapsed().as_secs_f64(),
        band,
        table_version: table::TABLE.version,
    };
    Ok(Promise { record, plan: Vec::new() })
}
