use super::decode::Mismatch;
use super::entry::LoggedDamage;
use crate::results_file::remedy;
use cofferdam_coupling::observer::ObserverError;
use std::path::{Path, PathBuf};

/// A log that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be made.
    #[error("{}: {cause}; choose another --output", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: std::io::Error,
    },
    /// Writing failed.
    #[error("{}: {cause}; {}", path.display(), remedy(cause))]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the writer or the system.
        cause: std::io::Error,
    },
    /// The preamble and the run differ in the number of steps that are iterated together.
    #[error(
        "the log's preamble has windows of {preamble} steps, the run has windows of {run}; give both the same number"
    )]
    Window {
        /// Number in the preamble.
        preamble: usize,
        /// Number in the run.
        run: usize,
    },
    /// A variable has the name of another field of its message.
    #[error(
        "{unit}: the variable `{variable}` cannot be logged, because its message has a field of that name already; rename it"
    )]
    Name {
        /// Name of the unit.
        unit: String,
        /// Name of the variable, or of the norm of an array.
        variable: String,
    },
    /// The writing thread ended without an error.
    #[error("{}: the thread that writes the log ended", path.display())]
    Stopped {
        /// The file.
        path: PathBuf,
    },
}

impl LogError {
    pub(super) fn of_writer(path: &Path, error: mcap::McapError) -> Self {
        let cause = match error {
            mcap::McapError::Io(cause) => cause,
            error => std::io::Error::other(error),
        };
        Self::Write { path: path.to_owned(), cause }
    }
}

impl From<LogError> for ObserverError {
    fn from(error: LogError) -> Self {
        Self::Other(Box::new(error))
    }
}

/// Why a log cannot be read, or not to its end. Entries before the given place are valid.
#[derive(Debug, thiserror::Error)]
pub enum LogReadError {
    /// The file cannot be opened.
    #[error("{}: {cause}; give the log.mcap of a run, or the run's folder", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: std::io::Error,
    },
    /// The system cannot read further.
    #[error("{}: byte {position}: {cause}; copy the log to another disk", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Where, bytes from the beginning.
        position: u64,
        /// The error of the system.
        cause: std::io::Error,
    },
    /// The file is a pipe or a device, which has no length and cannot be read twice.
    #[error("{}: is no regular file; copy it to one", path.display())]
    Irregular {
        /// The path.
        path: PathBuf,
    },
    /// The file is empty.
    #[error("{}: the file is empty; its run ended before it wrote anything, run it again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file does not begin like MCAP.
    #[error(
        "{}: byte 0: this is no MCAP file; give the log.mcap of a run, or the run's folder", path.display()
    )]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// The file is MCAP, but no run wrote it.
    #[error(
        "{}: byte {position}: this MCAP file (written by `{library}`) has no `{topic}` before its first exchange; \
         only the logs of `cofferdam run` can be read", path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Where this was found, bytes from the beginning.
        position: u64,
        /// The program that wrote it, as the file says.
        library: String,
        /// Topic that is missing.
        topic: &'static str,
    },
    /// The file ends before the data of the run are complete.
    #[error(
        "{}: byte {position}: the log is cut short before it says what was run; nothing can be read from it, \
         run the scene again", path.display()
    )]
    Headless {
        /// The file.
        path: PathBuf,
        /// Where it is cut off, bytes from the beginning.
        position: u64,
    },
    /// This version cannot read the scene in the log.
    #[error(
        "{}: the scene in the log is not one of this version: {message}; read it with cofferdam {version} \
         (commit {commit}), which wrote it", path.display()
    )]
    Scene {
        /// The file.
        path: PathBuf,
        /// The error of the parser.
        message: String,
        /// Version that wrote the log.
        version: String,
        /// Commit that wrote the log.
        commit: String,
    },
    /// Its run logged no exchanges.
    #[error(
        "{}: the log holds no exchanges, because it was run with log.exchanges = \"none\"; run the scene again with \"every\" or \
         \"accepted\"", path.display()
    )]
    NoExchanges {
        /// The file.
        path: PathBuf,
    },
    /// Bytes were changed after they were written.
    #[error(
        "{}: byte {position}: the log is damaged here: {cause}; fetch it again from where it was written, or save the rest by \
         `cofferdam log recover`", path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where, bytes from the beginning.
        position: u64,
        /// What is wrong.
        cause: String,
    },
    /// Bytes outside the messages were changed.
    #[error(
        "{}: byte {position}: the index of the log is damaged: {cause}; all messages are whole, `cofferdam log recover` writes \
         a new index", path.display()
    )]
    Index {
        /// The file.
        path: PathBuf,
        /// Where, bytes from the beginning.
        position: u64,
        /// What is wrong.
        cause: String,
    },
    /// The log was recovered from a damaged one.
    #[error(
        "{}: the log was recovered from a damaged one, and exchanges are missing here: {damage}; give the log from before \
         the damage, if there is one", path.display()
    )]
    Missing {
        /// The file.
        path: PathBuf,
        /// What is missing.
        damage: LoggedDamage,
    },
    /// The messages of a topic do not have the expected type.
    #[error(
        "{}: byte {position}: topic `{topic}`: {mismatch}; read the log with the version that wrote it", path.display()
    )]
    Topic {
        /// The file.
        path: PathBuf,
        /// Where, bytes from the beginning.
        position: u64,
        /// The topic.
        topic: String,
        /// What is wrong.
        mismatch: Mismatch,
    },
}
