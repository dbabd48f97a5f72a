//! Other records, scaled to the peak acceleration of the scene.

use super::setting::Choice;
use crate::study::StudyError;
use cofferdam_motion::{Component, Excerpt, GroundMotion};
use cofferdam_scene::LoadedScene;
use std::path::{Path, PathBuf};
use toml::Value;

/// The option that names a record.
const OPTION: &str = "--record";

/// Reads records from where the command runs, each `FILE` with one column of accelerations, or `FILE,VERTICAL` where the scene has a
/// vertical component. Both components get the factor that gives the horizontal one the peak acceleration of the scene's. A run
/// covers the whole record and the scene's time without ground motion.
///
/// **Errors**: [`StudyError::Option`], [`StudyError::Record`].
pub fn read(given: &[PathBuf], loaded: &LoadedScene) -> Result<Vec<Choice>, StudyError> {
    given.iter().map(|given| of(given, loaded)).collect()
}

fn of(given: &Path, loaded: &LoadedScene) -> Result<Choice, StudyError> {
    let refused = |remedy: &str| StudyError::Option {
        option: OPTION,
        value: given.display().to_string(),
        remedy: remedy.to_owned(),
    };
    let Some(own) = &loaded.scene.ground_motion.record else {
        return Err(refused(
            "the ground of the scene moves in a ramp, which has no other record; leave the option out",
        ));
    };
    if !loaded.scene.ground_motion.sequence.is_empty() {
        return Err(refused(
            "the scene has a sequence of shocks, which belongs to its own record; leave the option out, or give a scene without one",
        ));
    }
    let text = given.to_string_lossy();
    let (horizontal, vertical) = match (loaded.scene.ground_motion.vertical.is_some(), text.rsplit_once(','))
    {
        (false, _) => (given.to_owned(), None),
        (true, Some((horizontal, vertical))) => (PathBuf::from(horizontal), Some(PathBuf::from(vertical))),
        (true, None) => {
            return Err(refused(
                "the scene has a vertical component, which is that of its own record; give FILE,VERTICAL, or run a scene without one",
            ));
        }
    };
    let component = |path: &Path| {
        let component = Component::from_record(&Excerpt::whole(path));
        component.map_err(|cause| StudyError::Record { option: OPTION, cause: Box::new(cause) })
    };
    let motion = GroundMotion::from(component(&horizontal)?);
    if motion.largest() == 0.0 {
        return Err(refused("its acceleration is 0 throughout; give a record of an earthquake"));
    }
    let factor = loaded.ground_motion.horizontal().largest() / motion.largest();
    let with_vertical = match &vertical {
        Some(path) => motion.with_vertical(Some(component(path)?)),
        None => motion,
    };
    let time = &loaded.scene.time;
    let end = with_vertical.rest_from().unwrap_or(with_vertical.duration());
    let duration = end + time.longest_quiet.unwrap_or(time.quiet);
    let file = |path: &Path| {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        format!("file={}", Value::from(&*path.to_string_lossy()))
    };
    let keys = format!("{}, scale={factor:e}, polarity={}", file(&horizontal), own.polarity);
    let mut sets = vec![format!("ground_motion.record={{{keys}}}"), format!("time.duration={duration:e}")];
    sets.extend(vertical.iter().map(|path| format!("ground_motion.vertical={{{}}}", file(path))));
    let name =
        horizontal.file_stem().map_or_else(|| text.into_owned(), |stem| stem.to_string_lossy().into_owned());
    Ok(Choice { name, sets })
}
