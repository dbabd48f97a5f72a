//! Files of results that are written during a run.

use cofferdam_coupling::observer::ObserverError;
use std::fs::File;
use std::io::{Error, ErrorKind, Result, Seek, SeekFrom, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A new file; with every flush it makes sure that its name still leads to it. What is written to a file that was removed or
/// replaced is lost without an error of the system.
#[derive(Debug)]
pub struct ResultsFile {
    /// The names that may lead to it.
    paths: Vec<PathBuf>,
    file: File,
    /// Device and number of the file.
    identity: (u64, u64),
}

impl ResultsFile {
    /// Creates the file `path`, or empties it.
    ///
    /// **Errors**: those of the system.
    pub fn create(path: &Path) -> Result<Self> {
        let file = File::create(path)?;
        let metadata = file.metadata()?;
        Ok(Self { paths: vec![path.to_owned()], file, identity: (metadata.dev(), metadata.ino()) })
    }

    /// The same file, which may be renamed to `path`.
    pub fn or(mut self, path: &Path) -> Self {
        self.paths.push(path.to_owned());
        self
    }

    /// Locks the file as long as it is open, so that its readers can see that it is being written. Some file systems have no
    /// locks; then they cannot.
    pub fn hold(&self) {
        drop(self.file.try_lock());
    }
}

impl Write for ResultsFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.file.write(bytes)
    }

    /// **Errors**: the file is no longer there.
    fn flush(&mut self) -> Result<()> {
        let leads_to_it =
            |path: &PathBuf| std::fs::metadata(path).is_ok_and(|now| (now.dev(), now.ino()) == self.identity);
        if self.paths.iter().any(leads_to_it) {
            Ok(())
        } else {
            Err(Error::new(ErrorKind::NotFound, "it was removed or replaced during the run"))
        }
    }
}

impl Seek for ResultsFile {
    fn seek(&mut self, position: SeekFrom) -> Result<u64> {
        self.file.seek(position)
    }
}

/// The error that results cannot be written to `path`, with the remedy.
pub fn write_error(path: PathBuf, cause: Error) -> ObserverError {
    ObserverError::Write { remedy: remedy(&cause), path, cause }
}

/// What to do about an error in writing results.
pub fn remedy(cause: &Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "run again, and leave the results alone until the run has ended",
        ErrorKind::FileTooLarge => "raise the limit of file sizes (`ulimit -f`) and run again",
        ErrorKind::WouldBlock => "allow more threads (`ulimit -u`)",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "choose another --output",
        _ => "free some space or choose another --output",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_removed_or_replaced_is_noticed() -> Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("x");
        let mut file = ResultsFile::create(&path)?;
        file.write_all(b"a")?;
        file.flush()?;
        std::fs::remove_file(&path)?;
        let removed = file.flush().expect_err("it is not there");
        assert!(
            removed.to_string().contains("removed") && remedy(&removed).contains("leave the results alone")
        );
        std::fs::write(&path, "b")?;
        assert!(file.flush().is_err(), "another file has its name");
        Ok(())
    }
}
