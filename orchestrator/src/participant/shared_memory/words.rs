use crate::participant::Message;
use serde::{Deserialize, Serialize};

/// What the orchestrator writes to the standard input of a unit's process first: one line of JSON.
///
/// The input then stays open. A line `end` says that the run is over; an input that ends without it
/// says that the orchestrator has died.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// [`PROTOCOL_VERSION`](crate::transport::PROTOCOL_VERSION) of the orchestrator.
    pub protocol: u32,
    /// Number of the run, which is in the service's name.
    pub run: u64,
    /// Name of the unit, which is in the service's name.
    pub unit: String,
    /// Threads that the unit may use.
    pub threads: usize,
    /// The scene with all defaults, as TOML.
    pub scene: String,
}

/// The line that ends a run.
pub(super) const END: &str = "end";

/// What a unit's process says on its standard output: one line of JSON each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Word {
    /// The unit is made and its service is there.
    Ready {
        /// [`PROTOCOL_VERSION`](crate::transport::PROTOCOL_VERSION) of the unit.
        protocol: u32,
        /// A [`Description`](crate::participant::Description); read once the versions agree.
        description: serde_json::Value,
    },
    /// Something to be logged.
    Message(Message),
    /// Why the unit cannot be made, or why the last call failed; names the unit.
    Failed {
        /// The reason.
        text: String,
    },
}
