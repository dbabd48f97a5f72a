//! Errors of the commands for logs.

use cofferdam_log::{Log, LogReadError, RecoveryError, UnknownQuantity};
use std::error::Error;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Reason why a command for logs has no result.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The log cannot be read, or not to its end.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// A damaged log cannot be saved.
    #[error(transparent)]
    Recovery(#[from] RecoveryError),
    /// The log has no unit of this name.
    #[error("{}: there is no unit `{unit}`; its units are {known}", path.display())]
    Unit {
        /// The log.
        path: PathBuf,
        /// The given name.
        unit: String,
        /// The units that there are.
        known: String,
    },
    /// The log has no such step.
    #[error("{}: there is no step {step}; the log holds steps 0 to {last}", path.display())]
    Step {
        /// The log.
        path: PathBuf,
        /// The step.
        step: u64,
        /// The last step.
        last: u64,
    },
    /// The step has no such attempt or iteration.
    #[error("{}: step {step} has no {what}; it has {known}", path.display())]
    Iteration {
        /// The log.
        path: PathBuf,
        /// The step.
        step: u64,
        /// The requested item.
        what: String,
        /// The known items.
        known: String,
    },
    /// There are no contacts to show.
    #[error("{}: there are no contacts to show: {why}", path.display())]
    NoContacts {
        /// The log.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// The dam cannot be put where the run had it.
    #[error("{}: the dam cannot be restored: {why}", path.display())]
    Dam {
        /// The log.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// The log has no such variable.
    #[error("{}: {cause}", path.display())]
    Variable {
        /// The log.
        path: PathBuf,
        /// Similar items.
        cause: UnknownQuantity,
    },
    /// No step ends in the requested interval.
    #[error("{}: no step ends from {from} s{}; the run goes to {end} s", path.display(), up_to(*until))]
    Span {
        /// The log.
        path: PathBuf,
        /// Beginning, s.
        from: f64,
        /// End, s.
        until: f64,
        /// Time reached, s.
        end: f64,
    },
    /// This log does not contain the requested data.
    #[error("{}: {cause}", path.display())]
    Asked {
        /// The log.
        path: PathBuf,
        /// The cause and the remedy.
        cause: String,
    },
    /// A run cannot be made again from its log.
    #[error("{}: {cause}", path.display())]
    Again {
        /// The log.
        path: PathBuf,
        /// The cause.
        cause: Box<dyn Error + Send + Sync>,
    },
    /// There is such a file or folder already.
    #[error("{}: it exists already, and nothing is overwritten; choose another --output", path.display())]
    Exists {
        /// The file or folder.
        path: PathBuf,
    },
    /// A result cannot be written.
    #[error("{}: {cause}; choose another --output or free some space", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: Box<dyn Error + Send + Sync>,
    },
}

fn up_to(until: f64) -> String {
    if until.is_finite() { format!(" to {until} s") } else { " on".to_owned() }
}

impl Failure {
    /// 1 if a log cannot be read or results cannot be written, 2 if the requested item does not exist, 4 if a unit fails.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Log(_) | Self::Recovery(_) | Self::Exists { .. } | Self::Write { .. } => 1,
            Self::Again { .. } | Self::Dam { .. } => 4,
            Self::Unit { .. }
            | Self::Asked { .. }
            | Self::NoContacts { .. }
            | Self::Step { .. }
            | Self::Iteration { .. }
            | Self::Variable { .. }
            | Self::Span { .. } => 2,
        }
    }

    /// That the dam of `log` cannot be put where it was.
    pub fn dam(log: &Log, why: String) -> Self {
        Self::Dam { path: log.path().to_owned(), why }
    }

    /// That `path` cannot be written.
    pub fn write(path: &Path, cause: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Write { path: path.to_owned(), cause: cause.into() }
    }
}

/// Writes a new file.
///
/// **Errors**: it exists, or cannot be written.
pub fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    match file.and_then(|mut file| file.write_all(text.as_bytes())) {
        Err(cause) if cause.kind() == ErrorKind::AlreadyExists => {
            Err(Failure::Exists { path: path.to_owned() })
        }
        written => written.map_err(|cause| Failure::write(path, cause)),
    }
}
