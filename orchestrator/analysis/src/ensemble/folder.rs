//! The folder of an ensemble.

use super::{EnsembleError, sample};
use std::fs::DirEntry;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Prefix of the name of a plan that is being written.
const DRAFT: &str = ".plan-";

/// Makes the folder, or finds in it what is left of the same plan. Parts that begin at the same time all find the plan whole.
pub fn take_folder(folder: &Path, text: &str) -> Result<(), EnsembleError> {
    let failed = |cause: std::io::Error| EnsembleError::File { path: folder.to_owned(), cause: cause.into() };
    let (plan, samples) = (folder.join("plan.toml"), folder.join("samples"));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let is_ours = |entry: std::io::Result<DirEntry>| {
        entry.is_ok_and(|entry| {
            let name = entry.file_name();
            name == "plan.toml" || name == "samples" || name.to_string_lossy().starts_with(DRAFT)
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
