//! Why a command for logs has no result.

use orchestrator::log::LogReadError;
use std::path::PathBuf;

/// Why a command for logs has no result.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The log cannot be read, or not to its end.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// The log has no unit of this name.
    #[error("{}: there is no unit `{unit}`; its units are {known}", path.display())]
    Unit {
        /// The log.
        path: PathBuf,
        /// The name that was given.
        unit: String,
        /// The units that there are.
        known: String,
    },
}

impl Failure {
    /// 1 if a log cannot be read or results cannot be written, 2 if what is asked for does not exist.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Log(_) => 1,
            Self::Unit { .. } => 2,
        }
    }
}
