use super::brief::Brief;
use crate::transport::ServiceKind;
use cofferdam_coupling::participant::Message;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The first line that the orchestrator writes to the standard input of a unit's process, as JSON.
///
/// The input then stays open. A line `end` says that the run is over; an input that closes without it means that the
/// orchestrator has died.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// [`PROTOCOL_VERSION`](crate::transport::PROTOCOL_VERSION) of the orchestrator.
    pub protocol: u32,
    /// Number of the run, part of the service's name.
    pub run: u64,
    /// Folder of the run's shared memory.
    pub folder: PathBuf,
    /// The service that the unit is to make: `service`, and its `prefix`.
    #[serde(flatten)]
    pub service: ServiceKind,
    /// Name of the unit, part of the service's name.
    pub unit: String,
    /// Threads that the unit may use.
    pub threads: usize,
    /// The scene with all defaults, as TOML.
    pub scene: String,
    /// For a unit that is not ours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brief: Option<Brief>,
}

/// The line that ends a run.
pub(super) const END: &str = "end";

/// A line that a unit's process writes to its standard output, as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Word {
    /// The unit has been made and its service exists.
    Ready {
        /// [`PROTOCOL_VERSION`](crate::transport::PROTOCOL_VERSION) of the unit.
        protocol: u32,
        /// A [`Description`](cofferdam_coupling::participant::Description); read after the versions were compared.
        description: serde_json::Value,
    },
    /// A message for the log.
    Message(Message),
    /// Why the unit cannot be made, or why the last call failed; names the unit.
    Failed {
        /// The reason.
        text: String,
    },
}
