//! States as bytes have any length, an exchange has a fixed one: they go through a file in the folder of the run, which is memory
//! and private. Who reads it removes it.

use crate::transport::Folder;
use cofferdam_coupling::participant::ParticipantError;
use std::io::Result;
use std::path::{Path, PathBuf};

/// The file of `unit`.
fn path(folder: &Folder, unit: &str) -> PathBuf {
    folder.path().join(format!("{unit}.state"))
}

/// Writes the state of `unit`.
///
/// **Errors**: [`ParticipantError::StateFile`].
pub fn put(folder: &Folder, unit: &str, state: &[u8]) -> std::result::Result<(), ParticipantError> {
    let path = path(folder, unit);
    std::fs::write(&path, state).map_err(|cause| {
        // Half a state would only take the space.
        discard(folder, unit);
        failed(unit, "written", &path, cause)
    })
}

/// Reads the state of `unit` and removes it.
///
/// **Errors**: [`ParticipantError::StateFile`].
pub fn take(folder: &Folder, unit: &str) -> std::result::Result<Vec<u8>, ParticipantError> {
    let path = path(folder, unit);
    let read = || -> Result<Vec<u8>> {
        let state = std::fs::read(&path)?;
        std::fs::remove_file(&path)?;
        Ok(state)
    };
    read().map_err(|cause| failed(unit, "read", &path, cause))
}

/// Removes the state that `unit` did not read, if it is there.
pub fn discard(folder: &Folder, unit: &str) {
    // What cannot be removed goes with the folder.
    let _ = std::fs::remove_file(path(folder, unit));
}

fn failed(unit: &str, doing: &'static str, path: &Path, cause: std::io::Error) -> ParticipantError {
    ParticipantError::StateFile { participant: unit.to_owned(), doing, path: path.to_owned(), cause }
}
