//! The log of a run of a dam: its scene and its ground motion.

use crate::ground::component_of;
use crate::units::GROUND_ACCELERATION;
use cofferdam_log::{Head, Log, LogReadError};
use cofferdam_motion::GroundMotion;
use cofferdam_scene::Scene;

/// The scene in a log, with all defaults.
///
/// **Errors**: [`LogReadError::Scene`]: it is not one of this version.
pub fn scene_of(log: &Log) -> Result<Scene, LogReadError> {
    let Head { scene_text, version, commit, .. } = log.head();
    toml::from_str(scene_text).map_err(|error| LogReadError::Scene {
        path: log.path().to_owned(),
        message: error.message().to_owned(),
        version: version.clone(),
        commit: commit.clone(),
    })
}

/// The ground motion in a log, as the run had it; at rest where the log has none.
pub fn ground_motion_of(log: &Log) -> GroundMotion {
    let Some(signal) = log.head().signal(GROUND_ACCELERATION, 0) else {
        return GroundMotion::of_samples("none", 1.0, vec![0.0]);
    };
    let motion = GroundMotion::of_samples(&signal.source, signal.interval, signal.samples.clone());
    // Logs of earlier versions do not tell whether the motion is held, which it is unless it comes from a record.
    let scene: toml::Table = log.head().scene_text.parse().unwrap_or_default();
    let record = scene.get("ground_motion").and_then(|motion| motion.get("record"));
    let motion = if signal.held || record.is_none() { motion.held() } else { motion };
    let vertical = log.head().signal(GROUND_ACCELERATION, 1).map(component_of);
    motion.with_vertical(vertical).with_aftershocks(signal.parts.clone())
}
