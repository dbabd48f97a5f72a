//! Request and response over shared memory (iceoryx2), which appears only here.
//!
//! A unit is the one server of the service `cofferdam/<run>/<unit>`, the orchestrator its one
//! client. Request and answer are `[f64]` slices behind the same [`Header`]; the service carries
//! protocol version and layout hash as attributes. Files of iceoryx2 lie in a folder of the user's
//! own, so that users do not meet. What a killed process leaves behind is removed by the next one
//! that opens or closes a node there, and whatever escapes that by the next one that is alone.

mod client;
mod header;
mod server;
mod wait;

pub use client::Client;
pub use header::{Command, Header, PROTOCOL_VERSION, Status};
pub use server::Server;
pub use wait::shorten_naps;

use header::HeaderField;
use iceoryx2::config::Config;
use iceoryx2::prelude::{
    AttributeSpecifier, FileName, LogLevel, NodeBuilder, SemanticString, SignalHandlingMode, ipc_threadsafe,
    set_log_level,
};
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use std::fmt::Debug;
use std::fs::File;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

/// What goes wrong on the way between two processes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// Shared memory cannot be had.
    #[error(
        "shared memory cannot be had: {why} ({cause} while {doing}); mend that, or go on without by --transport in-process"
    )]
    SharedMemory {
        /// What is wrong with the machine, as far as can be seen.
        why: String,
        /// What was being done.
        doing: &'static str,
        /// What iceoryx2 said.
        cause: String,
    },
    /// Something of this user's name in shared memory belongs to somebody else.
    #[error(
        "{} is not a folder that only this user can write into; ask its owner or root to remove it, or go on \
         without shared memory by --transport in-process", path.display()
    )]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The other side speaks another version of the protocol.
    #[error(
        "{unit} speaks version {found} of the exchange protocol, this program version {expected}; run both from the same build"
    )]
    Protocol {
        /// Name of the unit.
        unit: String,
        /// This program's version.
        expected: u32,
        /// The unit's.
        found: u32,
    },
    /// The other side lays out requests and answers otherwise.
    #[error(
        "{unit} lays out requests and answers as {found}, by its description they are {expected}; run both from the same build"
    )]
    Layout {
        /// Name of the unit.
        unit: String,
        /// Hash that follows from the unit's description.
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
        /// What was sent.
        sent: String,
        /// What came back.
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
    /// The other side is not connected.
    #[error("{unit} is not connected; it must serve `{service}` before it says that it is ready")]
    NotConnected {
        /// Name of the unit.
        unit: String,
        /// Name of the service.
        service: String,
    },
}

type Ipc = ipc_threadsafe::Service;
type Node = iceoryx2::node::Node<Ipc>;

const ATTRIBUTE_PROTOCOL: &str = "protocol";
const ATTRIBUTE_LAYOUT: &str = "layout";
const SHARED_MEMORY: &str = "/dev/shm";
/// Space that must be free there, bytes: several times what a run of thousands of interface points takes.
const LEAST_SPACE: u64 = 4 << 20;
/// How long to wait for another process that is just tidying up after a dead one.
const TIDYING: Duration = Duration::from_millis(100);

/// Name of a unit's service.
pub fn service_name(run: u64, unit: &str) -> String {
    format!("cofferdam/{run:016x}/{unit}")
}

/// Checks that shared memory can be had, before any work is done; removes what dead processes left behind.
///
/// **Errors**: [`TransportError::SharedMemory`], [`TransportError::Folder`].
pub fn probe(run: u64) -> Result<(), TransportError> {
    const VALUES: usize = 4096;
    // Memory that is promised and then not there ends a process by a signal.
    if rustix::fs::statvfs(SHARED_MEMORY).is_ok_and(|s| s.f_bavail * s.f_frsize < LEAST_SPACE) {
        return Err(shared_memory_error(
            "looking for space",
            &format_args!("{} KiB are needed", LEAST_SPACE / 1024),
        ));
    }
    let server = Server::create(run, "probe", "none", VALUES)?;
    let mut client = Client::open(run, "probe", "none", VALUES)?;
    client.reserve(VALUES)?;
    drop((client, server));
    node()?.blocking_cleanup_dead_nodes(TIDYING);
    Ok(())
}

/// Removes what dead processes of this user left behind.
pub fn tidy() {
    if let Ok(node) = node() {
        node.blocking_cleanup_dead_nodes(TIDYING);
    }
}

/// A run's number, which no other run has.
pub fn new_run() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    // Keys of hash maps are the system's random numbers.
    std::hash::RandomState::new().build_hasher().finish()
}

/// What everything of this user is called that lies in shared memory.
fn prefix() -> String {
    format!("cofferdam-{}", rustix::process::getuid().as_raw())
}

/// The user's own folder for iceoryx2's files, which nobody else may write into. It lies where the memory does, and
/// goes with it.
fn folder() -> Result<PathBuf, TransportError> {
    let path = Path::new(SHARED_MEMORY).join(prefix());
    let failed = |e: std::io::Error| shared_memory_error("making a folder", &e);
    match std::fs::DirBuilder::new().mode(0o700).create(&path) {
        Ok(()) => {}
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
            let metadata = std::fs::symlink_metadata(&path).map_err(failed)?;
            let mine = metadata.uid() == rustix::process::getuid().as_raw();
            if !(metadata.is_dir() && mine && metadata.mode() & 0o022 == 0) {
                return Err(TransportError::Folder { path });
            }
        }
        Err(e) => return Err(failed(e)),
    }
    hold(&path).map_err(failed)?;
    Ok(path)
}

/// Says that this process uses `folder`, as long as it lives; if no other does, removes whatever is left there.
fn hold(folder: &Path) -> std::io::Result<()> {
    static LOCK: OnceLock<File> = OnceLock::new();
    if LOCK.get().is_some() {
        return Ok(());
    }
    let lock = File::options().create(true).append(true).open(folder.join("lock"))?;
    if lock.try_lock().is_ok() {
        sweep(folder);
        lock.unlock()?;
    }
    lock.lock_shared()?;
    // Another thread may have been first; one lock is enough.
    let _ = LOCK.set(lock);
    Ok(())
}

/// Removes everything of this user from shared memory but the lock; nobody may be using it.
fn sweep(folder: &Path) {
    let segments = format!("{}_", prefix());
    // What cannot be removed will not be missed: names are not used twice.
    for entry in std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&segments) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let _ = std::fs::remove_dir_all(entry.path());
    }
}

fn node() -> Result<Node, TransportError> {
    // Its messages would come beside ours, which name the remedy.
    set_log_level(LogLevel::Fatal);
    let folder = folder()?;
    let mut config = Config::default();
    let failed = |e: &dyn Debug| shared_memory_error("preparing", &e);
    let path = iceoryx2::prelude::Path::new(folder.as_os_str().as_encoded_bytes()).map_err(|e| failed(&e))?;
    config.global.set_root_path(&path);
    config.global.prefix = FileName::new(format!("{}_", prefix()).as_bytes()).map_err(|e| failed(&e))?;
    let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create::<Ipc>().map_err(|e| shared_memory_error("making a node", &e))
}

/// An error of iceoryx2 or the system, with what seems wrong with the machine's shared memory.
fn shared_memory_error(doing: &'static str, cause: &dyn Debug) -> TransportError {
    let path = Path::new(SHARED_MEMORY);
    let why = match (std::fs::read_dir(path), try_writing(path), rustix::fs::statvfs(path)) {
        (Err(e), _, _) => format!("{SHARED_MEMORY}: {e}"),
        (_, Err(e), _) => format!("{SHARED_MEMORY} cannot be written to: {e}"),
        (_, _, Err(e)) => format!("{SHARED_MEMORY}: {e}"),
        (Ok(mut entries), _, Ok(space)) => {
            let me = rustix::process::getuid().as_raw();
            let strange = entries.find_map(|entry| {
                let entry = entry.ok()?;
                let mine = entry.file_name().to_string_lossy().starts_with(&prefix());
                let owner = entry.metadata().ok().filter(|_| mine)?.uid();
                (owner != me).then(|| format!("{} belongs to user {owner}", entry.path().display()))
            });
            let free = || format!("{SHARED_MEMORY} has {} KiB free", space.f_bavail * space.f_frsize / 1024);
            strange.unwrap_or_else(free)
        }
    };
    TransportError::SharedMemory { why, doing, cause: format!("{cause:?}") }
}

/// Makes a file in `folder` and removes it.
fn try_writing(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!("{}-{:016x}", prefix(), new_run()));
    File::create_new(&path)?;
    // It is there, so it could be written.
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
