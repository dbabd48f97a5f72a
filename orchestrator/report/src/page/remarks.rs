//! Warnings and notes of a run.

use super::folder::RunFolder;
use cofferdam_log::LogReadError;
use cofferdam_unit::Level;

/// Warnings and notes: of the result, of the scene, and of the units.
///
/// **Errors**: the log cannot be read.
pub fn of(run: &RunFolder) -> Result<(Vec<String>, Vec<String>), LogReadError> {
    let (mut warnings, mut notes) = (Vec::<String>::new(), Vec::new());
    for note in &run.summary.notes {
        match note.strip_prefix("WARNING: ") {
            Some(warning) => warnings.push(warning.to_owned()),
            None => notes.push(note.clone()),
        }
    }
    let of_scene = run.loaded.warnings.iter().map(ToString::to_string);
    let said = run.log.messages()?.into_iter().filter(|message| message.level >= Level::Warning);
    let of_units = said
        .map(|message| format!("{} at t = {:.4} s: {}", message.unit, message.time, message.text.trim_end()));
    for warning in of_scene.chain(of_units) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    Ok((warnings, notes))
}
