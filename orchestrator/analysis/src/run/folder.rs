//! The folder of a run's results.

use super::RunError;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Checks that a folder is not there or empty.
pub fn check(folder: &Path) -> Result<(), RunError> {
    match std::fs::read_dir(folder).map(|mut entries| entries.next().is_some()) {
        Ok(true) => Err(RunError::OutputTaken { path: folder.to_owned() }),
        Ok(false) => Ok(()),
        Err(cause) if cause.kind() == ErrorKind::NotFound => Ok(()),
        Err(cause) => Err(RunError::Output { path: folder.to_owned(), cause }),
    }
}

/// Creates the output folder, or takes an empty one; creates the manifest in it.
pub fn claim(folder: PathBuf) -> Result<PathBuf, RunError> {
    let failed = |cause| RunError::Output { path: folder.clone(), cause };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    check(&folder)?;
    let manifest = folder.join("manifest.toml");
    match std::fs::File::create_new(&manifest) {
        Ok(_) => Ok(folder),
        // Another run was faster.
        Err(cause) if cause.kind() == ErrorKind::AlreadyExists => Err(RunError::OutputTaken { path: folder }),
        Err(cause) => Err(failed(cause)),
    }
}

/// The same with the folder `name`, or, where runs of the same second have taken it, `name-2`, `name-3`, …
pub fn claim_new(name: &str) -> Result<PathBuf, RunError> {
    let numbered = (2..).map(|number: u32| format!("{name}-{number}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    loop {
        match claim(names.next().unwrap_or_default().into()) {
            Err(RunError::OutputTaken { .. }) => (),
            claimed => return claimed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_the_same_second_have_folders_of_their_own() -> Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let name = place.path().join("runs/case").to_string_lossy().into_owned();
        for suffix in ["", "-2", "-3"] {
            let folder = claim_new(&name)?;
            assert_eq!(folder, PathBuf::from(format!("{name}{suffix}")));
            assert!(folder.join("manifest.toml").exists());
        }
        Ok(())
    }
}
