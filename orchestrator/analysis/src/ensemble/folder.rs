//! The folder of an ensemble.

use super::plan::HIGHEST_LEVEL;
use super::{EnsembleError, sample};
use serde::{Deserialize, Serialize};
use std::fs::DirEntry;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Prefix of the name of a plan that is being written.
const DRAFT: &str = ".plan-";

/// Name of the file with the levels that were added to the plan.
const ADDED: &str = "added.toml";

/// Levels that were added to a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Added {
    /// Levels, g, or factors on the records if the plan has no levels; ascending.
    levels: Vec<f64>,
}

/// The levels that were added to the plan of a folder before.
///
/// **Errors**: [`EnsembleError::Added`].
pub fn added(folder: &Path) -> Result<Vec<f64>, EnsembleError> {
    let path = folder.join(ADDED);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(EnsembleError::Added { path, cause: error.to_string() }),
    };
    let wrong = |cause: String| EnsembleError::Added { path: path.clone(), cause };
    let Added { levels } = toml::from_str(&text).map_err(|error| wrong(error.message().to_owned()))?;
    match levels.iter().find(|level| !(**level > 0.0 && **level <= HIGHEST_LEVEL)) {
        Some(level) => Err(wrong(format!("`levels` has {level}; levels lie between 0 and {HIGHEST_LEVEL}"))),
        None => Ok(levels),
    }
}

/// Keeps the levels that are added to the plan of a folder.
pub fn keep_added(folder: &Path, levels: &[f64]) -> Result<(), EnsembleError> {
    let path = folder.join(ADDED);
    let text = toml::to_string(&Added { levels: levels.to_vec() });
    let text = text.map_err(|cause| EnsembleError::Format(cause.into()))?;
    let failed = |cause: std::io::Error| EnsembleError::File { path: path.clone(), cause: cause.into() };
    let mut draft = sample::beside(folder, DRAFT).map_err(failed)?;
    draft.write_all(text.as_bytes()).map_err(failed)?;
    draft.persist(&path).map(drop).map_err(|error| failed(error.error))
}

/// Makes the folder, or finds in it what is left of the same plan. Parts that begin at the same time all find the plan whole.
pub fn take_folder(folder: &Path, text: &str) -> Result<(), EnsembleError> {
    let failed = |cause: std::io::Error| EnsembleError::File { path: folder.to_owned(), cause: cause.into() };
    let (plan, samples) = (folder.join("plan.toml"), folder.join("samples"));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let is_ours = |entry: std::io::Result<DirEntry>| {
        entry.is_ok_and(|entry| {
            let name = entry.file_name();
            name == "plan.toml"
                || name == "samples"
                || name == ADDED
                || name.to_string_lossy().starts_with(DRAFT)
        })
    };
    if !plan.exists() && !std::fs::read_dir(folder).map_err(failed)?.all(is_ours) {
        return Err(EnsembleError::OutputTaken { path: folder.to_owned() });
    }
    if !plan.exists() {
        let mut draft = sample::beside(folder, DRAFT).map_err(failed)?;
        draft.write_all(text.as_bytes()).map_err(failed)?;
        // Another part may have been faster.
        draft.persist_noclobber(&plan).map(drop).or_else(|error| match error.error.kind() {
            ErrorKind::AlreadyExists => Ok(()),
            _ => Err(failed(error.error)),
        })?;
    }
    if std::fs::read_to_string(&plan).ok().as_deref() != Some(text) {
        return Err(EnsembleError::OutputTaken { path: folder.to_owned() });
    }
    std::fs::create_dir_all(samples).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_levels_come_back_and_wrong_ones_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(added(folder.path()).expect("none yet").is_empty());
        keep_added(folder.path(), &[0.26, 0.42]).expect("a file");
        assert_eq!(added(folder.path()).expect("levels"), [0.26, 0.42]);
        for (text, wanted) in [
            ("levels = [0.2, -1.0]", "`levels` has -1"),
            ("levels = [26.0]", "`levels` has 26"),
            ("level = [0.2]", "unknown field `level`"),
        ] {
            std::fs::write(folder.path().join(ADDED), text).expect("a file");
            let error = added(folder.path()).expect_err(text).to_string();
            assert!(error.contains(wanted) && error.contains("remove the file"), "{error}");
        }
    }

    #[test]
    fn parts_that_begin_at_once_share_a_folder_and_others_find_it_taken() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("out");
        let taken = std::thread::scope(|scope| {
            let parts: Vec<_> = (0..8).map(|_| scope.spawn(|| take_folder(&folder, "a plan"))).collect();
            parts.into_iter().map(|part| part.join().expect("no panic")).collect::<Vec<_>>()
        });
        assert!(taken.iter().all(Result::is_ok), "{taken:?}");
        assert_eq!(std::fs::read_to_string(folder.join("plan.toml")).ok().as_deref(), Some("a plan"));
        assert!(matches!(take_folder(&folder, "another"), Err(EnsembleError::OutputTaken { .. })));
        std::fs::write(place.path().join("x"), "mine").expect("a file");
        assert!(matches!(take_folder(place.path(), "a plan"), Err(EnsembleError::OutputTaken { .. })));
    }
}
