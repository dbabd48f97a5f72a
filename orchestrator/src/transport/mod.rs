//! Request and response over shared memory by iceoryx2, which is used only here.
//!
//! A unit is the one server of the service `cofferdam/<run>/<unit>`, the orchestrator its one client. Request and
//! answer are `[f64]` slices behind the same [`Header`]; the service carries protocol version and layout hash as
//! attributes. The files of iceoryx2 lie in a folder of the user, so that users do not disturb each other. What a
//! killed process leaves there is removed by the next process that opens or closes a node; anything that remains is
//! removed by the next process that is alone.

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
    /// The folder of this user in shared memory belongs to another user.
    #[error(
        "{} is not a folder that only this user can write into; ask its owner or root to remove it, or use \
         --transport in-process", path.display()
    )]
    Folder {
        /// The folder.
        path: PathBuf,
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

type Ipc = ipc_threadsafe::Service;
type Node = iceoryx2::node::Node<Ipc>;

const ATTRIBUTE_PROTOCOL: &str = "protocol";
const ATTRIBUTE_LAYOUT: &str = "layout";
const SHARED_MEMORY: &str = "/dev/shm";
/// Space that must be free there, bytes: several times the need of a run with thousands of interface points.
const LEAST_SPACE: u64 = 4 << 20;
/// Time to wait for another process that is removing the files of a dead one.
const TIDYING: Duration = Duration::from_millis(100);

/// Name of a unit's service.
pub fn service_name(run: u64, unit: &str) -> String {
    format!("cofferdam/{run:016x}/{unit}")
}

/// Checks that shared memory is available; removes the files of dead processes.
///
/// **Errors**: [`TransportError::SharedMemory`], [`TransportError::Folder`].
pub fn probe(run: u64) -> Result<(), TransportError> {
    const VALUES: usize = 4096;
    // If memory is granted but missing on use, a signal ends the process.
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

/// Removes the files of dead processes of this user.
pub fn tidy() {
    if let Ok(node) = node() {
        node.blocking_cleanup_dead_nodes(TIDYING);
    }
}

/// A random number for a run.
pub fn new_run() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    // The keys of hash maps are random numbers of the system.
    std::hash::RandomState::new().build_hasher().finish()
}

/// Prefix of the names of this user's files in shared memory.
fn prefix() -> String {
    format!("cofferdam-{}", rustix::process::getuid().as_raw())
}

/// The user's folder for the files of iceoryx2, which no other user may write into. It lies in the same file system
/// as the memory and is lost with it.
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

/// Marks `folder` as used by this process until it ends; if no other process uses it, removes what is left there.
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
    // Another thread may have set it first; one lock is enough.
    let _ = LOCK.set(lock);
    Ok(())
}

/// Removes all files of this user from shared memory except the lock; no process may use them.
fn sweep(folder: &Path) {
    let segments = format!("{}_", prefix());
    // What cannot be removed does no harm: names are not used twice.
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
    // Its messages would repeat ours, which name the remedy.
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

/// An error of iceoryx2 or the system, with the probable reason.
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

/// Creates a file in `folder` and removes it.
fn try_writing(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!("{}-{:016x}", prefix(), new_run()));
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
