//! Folders for temporary files, which the next run removes if this one is killed.

use std::collections::hash_map::RandomState;
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, Hasher};
use std::io::{ErrorKind, Result};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A folder below `TMPDIR` that only its user may enter. It is removed when it is dropped.
///
/// The process holds a lock on a file in it for as long as it lives. Folders whose lock is free belonged to a process that was
/// killed: creating the next folder of the same prefix removes them.
#[derive(Debug)]
pub struct TemporaryFolder {
    root: PathBuf,
    files: PathBuf,
    /// Released when the process ends, however it ends.
    _lock: File,
}

const LOCK: &str = "lock";
/// Name of the lock until it is held: a folder is never seen with a lock that is free by accident.
const UNLOCKED: &str = "unlocked";
const FILES: &str = "files";
/// Age from which a folder without a lock is one of a process that was killed while it made it.
const OLD: Duration = Duration::from_secs(24 * 3600);
/// Time after which no more folders are removed; those that are left wait for the next time.
const PATIENCE: Duration = Duration::from_secs(1);

impl TemporaryFolder {
    /// Creates a folder whose name begins with `prefix`, and removes those that killed processes of this user have left.
    ///
    /// **Errors**: the folder cannot be created.
    pub fn create(prefix: &str) -> Result<Self> {
        Self::create_in(&std::env::temp_dir(), prefix)
    }

    /// Where the files go.
    pub fn path(&self) -> &Path {
        &self.files
    }

    fn create_in(parent: &Path, prefix: &str) -> Result<Self> {
        let root = loop {
            let root = parent.join(format!("{prefix}{:016x}", RandomState::new().build_hasher().finish()));
            match std::fs::DirBuilder::new().mode(0o700).create(&root) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => (),
                made => break made.map(|()| root)?,
            }
        };
        let unlocked = root.join(UNLOCKED);
        let made = || -> Result<Self> {
            let lock = File::create_new(&unlocked)?;
            // A file system without locks: nobody else can take it either, and so the folder stays.
            let _ = lock.lock();
            std::fs::rename(&unlocked, root.join(LOCK))?;
            let files = root.join(FILES);
            std::fs::create_dir(&files)?;
            Ok(Self { root: root.clone(), files, _lock: lock })
        };
        let folder = made().inspect_err(|_| remove(&root))?;
        remove_unused(parent, prefix, std::fs::symlink_metadata(&root)?.uid());
        Ok(folder)
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        remove(&self.root);
    }
}

/// Removes a folder, its lock last. What cannot be removed does no harm: the next run tries again.
fn remove(root: &Path) {
    let _ = std::fs::remove_dir_all(root.join(FILES));
    let _ = std::fs::remove_dir_all(root);
}

/// Removes the folders in `parent` that processes of the user `mine` have left.
fn remove_unused(parent: &Path, prefix: &str, mine: u32) {
    let began = Instant::now();
    let entries = std::fs::read_dir(parent).into_iter().flatten().flatten();
    for entry in entries.take_while(|_| began.elapsed() < PATIENCE) {
        if entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix)) {
            remove_if_unused(&entry.path(), mine);
        }
    }
}

fn remove_if_unused(root: &Path, mine: u32) {
    // A link is none of ours, wherever it leads; nor is what others may enter.
    let Ok(metadata) = std::fs::symlink_metadata(root) else { return };
    if !metadata.is_dir() || metadata.uid() != mine || metadata.mode() & 0o077 != 0 {
        return;
    }
    let lock = root.join(LOCK);
    let unused = match std::fs::symlink_metadata(&lock) {
        Ok(metadata) if metadata.is_file() => match File::options().append(true).open(&lock) {
            // Held until the folder is removed, so that no two processes remove it.
            Ok(lock) => match lock.try_lock() {
                Ok(()) => Some(lock),
                Err(TryLockError::WouldBlock | TryLockError::Error(_)) => return,
            },
            Err(_) => return,
        },
        _ => None,
    };
    let old = || metadata.modified().is_ok_and(|then| then.elapsed().is_ok_and(|age| age > OLD));
    if unused.is_some() || old() {
        remove(root);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    const PREFIX: &str = "cofferdam-test-";

    /// A place of this test alone, removed by the caller.
    fn place(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("temporary-{name}-{}", std::process::id()));
        std::fs::create_dir(&path).expect("a folder");
        path
    }

    /// What a killed process leaves: the folder, and a lock that nobody holds.
    fn killed(parent: &Path) -> PathBuf {
        let folder = TemporaryFolder::create_in(parent, PREFIX).expect("a folder");
        std::fs::write(folder.path().join("library.so"), "x").expect("written");
        let root = folder.root.clone();
        folder._lock.unlock().expect("unlocked, as by the end of the process");
        std::mem::forget(folder);
        root
    }

    #[test]
    fn folder_is_private_and_removed_when_dropped() {
        let parent = place("dropped");
        let folder = TemporaryFolder::create_in(&parent, PREFIX).expect("a folder");
        let mode = std::fs::metadata(&folder.root).expect("it exists").mode() & 0o777;
        assert_eq!(mode, 0o700);
        std::fs::write(folder.path().join(LOCK), "a file of that name is no lock").expect("written");
        drop(folder);
        assert_eq!(std::fs::read_dir(&parent).expect("it exists").count(), 0);
        std::fs::remove_dir(parent).expect("removed");
    }

    #[test]
    fn next_folder_removes_those_of_killed_processes_and_no_other() {
        let parent = place("killed");
        let live = TemporaryFolder::create_in(&parent, PREFIX).expect("a folder");
        let dead = killed(&parent);
        let made = |name: &str| {
            let path = parent.join(format!("{PREFIX}{name}"));
            std::fs::DirBuilder::new().mode(0o700).create(&path).expect("made");
            path
        };
        let (just_made, old) = (made("1"), made("2"));
        let then = std::time::SystemTime::now() - 2 * OLD;
        File::open(&old).and_then(|folder| folder.set_modified(then)).expect("changed");
        // A link to a folder that looks like one of a killed process.
        let elsewhere = place("elsewhere");
        std::fs::write(elsewhere.join(LOCK), "").expect("written");
        std::fs::create_dir(elsewhere.join(FILES)).expect("made");
        symlink(&elsewhere, parent.join(format!("{PREFIX}link"))).expect("a link");
        // A link inside one is removed, not what it leads to.
        symlink(&elsewhere, dead.join(FILES).join("resources")).expect("a link");
        let other = parent.join("cofferdam-other-1");
        std::fs::create_dir(&other).expect("made");
        let next = TemporaryFolder::create_in(&parent, PREFIX).expect("a folder");
        assert!(!dead.exists() && !old.exists(), "their processes have ended");
        assert!(live.path().is_dir() && next.path().is_dir() && just_made.is_dir() && other.is_dir());
        assert!(elsewhere.join(LOCK).exists() && elsewhere.join(FILES).is_dir());
        assert!(std::fs::symlink_metadata(parent.join(format!("{PREFIX}link"))).is_ok());
        drop((live, next));
        for folder in [parent, elsewhere] {
            std::fs::remove_dir_all(folder).expect("removed");
        }
    }

    /// A folder that others may enter, or write to, may hold anything.
    #[test]
    fn folder_that_others_may_enter_stays() {
        use std::os::unix::fs::PermissionsExt;
        let parent = place("open");
        let dead = killed(&parent);
        std::fs::set_permissions(&dead, PermissionsExt::from_mode(0o755)).expect("changed");
        drop(TemporaryFolder::create_in(&parent, PREFIX).expect("a folder"));
        assert!(dead.is_dir());
        std::fs::remove_dir_all(parent).expect("removed");
    }

    #[test]
    fn processes_that_begin_at_the_same_time_keep_their_folders() {
        let parent = place("concurrent");
        let begin = || {
            for _ in 0..100 {
                let folder = TemporaryFolder::create_in(&parent, PREFIX).expect("a folder");
                std::fs::write(folder.path().join("file"), "x").expect("the folder is there");
                assert!(folder.root.join(LOCK).exists());
                killed(&parent);
            }
        };
        std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(begin))));
        drop(TemporaryFolder::create_in(&parent, PREFIX).expect("a folder"));
        assert_eq!(std::fs::read_dir(&parent).expect("it exists").count(), 0);
        std::fs::remove_dir(parent).expect("removed");
    }
}
