//! Request and response over shared memory by iceoryx2, which is used only here.
//!
//! A unit is the one server of the service `cofferdam/<run>/<unit>`, the orchestrator its one client. Request and
//! answer are `[f64]` slices behind the same [`Header`]; the service carries protocol version and layout hash as
//! attributes. Everything that belongs to a run lies in one [`Folder`], which only its user may enter, but for the memory of units
//! that are not ours, which lies beside it ([`ServiceKind`]).

mod client;
mod folder;
mod header;
mod server;
mod service;
mod wait;

pub use client::Client;
pub use folder::Folder;
pub use header::{Command, Header, PROTOCOL_VERSION, Status};
pub use server::Server;
pub use service::ServiceKind;
pub use wait::shorten_naps;

use cofferdam_coupling::participant::ParticipantError;
use header::HeaderField;
use iceoryx2::config::Config;
use iceoryx2::node::Node;
use iceoryx2::prelude::{
    AttributeSpecifier, FileName, LogLevel, NodeBuilder, SemanticString, SignalHandlingMode, set_log_level,
};
use iceoryx2::service::Service;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use service::{PrivateFiles, Usual};
use std::fmt::Debug;
use std::fs::File;
use std::path::Path;

impl From<TransportError> for ParticipantError {
    fn from(error: TransportError) -> Self {
        Self::Communication(Box::new(error))
    }
}

/// Why two processes cannot communicate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// Shared memory is not available.
    #[error(
        "shared memory is not available: {why} ({cause} while {doing}); correct this, or use --transport in-process"
    )]
    SharedMemory {
        /// The probable reason.
        why: String,
        /// The operation that failed.
        doing: &'static str,
        /// The error of iceoryx2.
        cause: String,
    },
    /// The other process uses another version of the protocol.
    #[error(
        "{unit} speaks version {found} of the exchange protocol, this program version {expected}; run both from the same build"
    )]
    Protocol {
        /// Name of the unit.
        unit: String,
        /// This program's version.
        expected: u32,
        /// The unit's version.
        found: u32,
    },
    /// The other process lays out requests and answers differently.
    #[error(
        "{unit} lays out requests and answers as {found}, but its description gives {expected}; run both from the same build"
    )]
    Layout {
        /// Name of the unit.
        unit: String,
        /// Hash computed from the unit's description.
        expected: String,
        /// Hash that its service carries.
        found: String,
    },
    /// An answer's header does not repeat the request's.
    #[error(
        "{unit} answered with {field} {found} where {sent} was asked for; a unit must echo the header of each request"
    )]
    Echo {
        /// Name of the unit.
        unit: String,
        /// Field of the header.
        field: HeaderField,
        /// The value sent.
        sent: String,
        /// The value in the answer.
        found: String,
    },
    /// An answer has another length than it should.
    #[error("{unit} answered with {found} values, {expected} were expected from its description")]
    Length {
        /// Name of the unit.
        unit: String,
        /// Number of values expected.
        expected: usize,
        /// Number of values that came.
        found: usize,
    },
    /// The other process is not connected.
    #[error("{unit} is not connected; it must serve `{service}` before it says that it is ready")]
    NotConnected {
        /// Name of the unit.
        unit: String,
        /// Name of the service.
        service: String,
    },
}

const ATTRIBUTE_PROTOCOL: &str = "protocol";
const ATTRIBUTE_LAYOUT: &str = "layout";
const SHARED_MEMORY: &str = "/dev/shm";
/// Space that must be free there, bytes: several times the need of a run with thousands of interface points.
const LEAST_SPACE: u64 = 4 << 20;

/// Name of a unit's service.
pub fn service_name(run: u64, unit: &str) -> String {
    format!("cofferdam/{run:016x}/{unit}")
}

/// Checks that shared memory is available.
///
/// **Errors**: [`TransportError::SharedMemory`].
pub fn probe() -> Result<(), TransportError> {
    const VALUES: usize = 4096;
    // If memory is granted but missing on use, a signal ends the process.
    if rustix::fs::statvfs(SHARED_MEMORY).is_ok_and(|s| s.f_bavail * s.f_frsize < LEAST_SPACE) {
        return Err(shared_memory_error(
            "looking for space",
            &format_args!("{} KiB are needed", LEAST_SPACE / 1024),
        ));
    }
    let folder = Folder::create()?;
    let kind = ServiceKind::PrivateFiles;
    let server = Server::create(&folder, &kind, "probe", "none", VALUES)?;
    let mut client = Client::open(&folder, &kind, "probe", "none", VALUES)?;
    client.reserve(VALUES)?;
    drop((client, server));
    Ok(())
}

/// A random number.
fn random() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    // The keys of hash maps are random numbers of the system.
    std::hash::RandomState::new().build_hasher().finish()
}

/// Makes the names of the usual services of the run of `folder`, for units that are not ours.
///
/// iceoryx2 leaves one segment of these services, its counter of nodes, writable for all users. It is made here, before any
/// unit starts, and closed to others at once.
///
/// **Errors**: no shared memory.
pub fn usual_services(folder: &Folder) -> Result<ServiceKind, TransportError> {
    let prefix = folder.new_prefix();
    let kind = ServiceKind::Ipc { prefix: prefix.clone() };
    node::<Usual>(folder, &kind)?;
    folder.close_segments(&prefix).map_err(|e| shared_memory_error("closing the counter of nodes", &e))?;
    Ok(kind)
}

fn node<S: Service>(folder: &Folder, kind: &ServiceKind) -> Result<Node<S>, TransportError> {
    // Its messages would repeat ours, which name the remedy.
    set_log_level(LogLevel::Fatal);
    let mut config = Config::default();
    let path = iceoryx2::prelude::Path::new(folder.path().as_os_str().as_encoded_bytes())
        .map_err(|e| shared_memory_error("preparing", &e))?;
    config.global.set_root_path(&path);
    if let ServiceKind::Ipc { prefix } = kind {
        config.global.prefix =
            FileName::new(prefix.as_bytes()).map_err(|e| shared_memory_error("preparing", &e))?;
    }
    let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create().map_err(|e| shared_memory_error("making a node", &e))
}

/// An error of iceoryx2 or the system, with the probable reason.
fn shared_memory_error(doing: &'static str, cause: &dyn Debug) -> TransportError {
    let path = Path::new(SHARED_MEMORY);
    let why = match (std::fs::read_dir(path), try_writing(path), rustix::fs::statvfs(path)) {
        (Err(e), _, _) => format!("{SHARED_MEMORY}: {e}"),
        (_, Err(e), _) => format!("{SHARED_MEMORY} cannot be written to: {e}"),
        (_, _, Err(e)) => format!("{SHARED_MEMORY}: {e}"),
        (_, _, Ok(space)) => {
            let limit = rustix::process::getrlimit(rustix::process::Resource::Fsize).current;
            let limit =
                limit.map(|bytes| format!(", and files are limited to {} KiB (`ulimit -f`)", bytes / 1024));
            let free = space.f_bavail * space.f_frsize / 1024;
            format!("{SHARED_MEMORY} has {free} KiB free{}", limit.unwrap_or_default())
        }
    };
    TransportError::SharedMemory { why, doing, cause: format!("{cause:?}") }
}

/// Creates a file in `folder` and removes it.
fn try_writing(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!("cofferdam-{:016x}", random()));
    File::create_new(&path)?;
    // It was created; removing it may fail.
    let _ = std::fs::remove_file(path);
    Ok(())
}

fn attributes(layout: &str) -> Result<AttributeSpecifier, TransportError> {
    let failed = |e: &dyn Debug| shared_memory_error("describing the service", &e);
    let version = PROTOCOL_VERSION.to_string();
    [(ATTRIBUTE_PROTOCOL, version.as_str()), (ATTRIBUTE_LAYOUT, layout)].into_iter().try_fold(
        AttributeSpecifier::new(),
        |attributes, (key, value)| {
            let key = AttributeKey::try_from(key).map_err(|e| failed(&e))?;
            let value = AttributeValue::try_from(value).map_err(|e| failed(&e))?;
            attributes.define(&key, &value).map_err(|e| failed(&e))
        },
    )
}
