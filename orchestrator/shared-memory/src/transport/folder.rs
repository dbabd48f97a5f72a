use super::{SHARED_MEMORY, TransportError, random, shared_memory_error};
use std::fs::{DirEntry, File, Metadata};
use std::io::{Error, ErrorKind, Result};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The folder in `/dev/shm` that holds everything of one run: `cofferdam-<user id>-<run, 16 hexadecimal digits>`.
///
/// Only its user may enter it, so that no other user can read, change or take anything that belongs to the run; the number of
/// the run is random, so that nobody can take its name beforehand. Every process of the run holds a shared lock on its
/// file `lock`. Who leaves it last removes it; what processes that were killed left is removed when the next run of the
/// user creates its folder.
///
/// The memory of iceoryx2's usual services, for units that are not ours, lies beside it in segments whose names begin with
/// the folder's name and `-`. They are removed with it.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    run: u64,
    lock: File,
}

const LOCK: &str = "lock";
/// How often a folder is made again that another run removes.
const ATTEMPTS: usize = 100;
/// Age from which a folder without a lock is not one that is just being made.
const OLD: Duration = Duration::from_secs(60);
/// Time that the system may take to end a process that was killed.
const DYING: Duration = Duration::from_millis(250);

impl Folder {
    /// Creates the folder of a new run.
    ///
    /// **Errors**: no shared memory.
    pub fn create() -> std::result::Result<Self, TransportError> {
        Self::try_to_create(Path::new(SHARED_MEMORY)).map_err(|e| shared_memory_error("making a folder", &e))
    }

    /// Joins the `run` whose folder was made by another process.
    ///
    /// **Errors**: it does not exist; others may enter it.
    pub fn join(path: &Path, run: u64) -> std::result::Result<Self, TransportError> {
        let joined = || {
            if !is_private(&std::fs::symlink_metadata(path)?) {
                return Err(Error::new(
                    ErrorKind::PermissionDenied,
                    "others may enter the folder of the run",
                ));
            }
            let lock = File::options().append(true).open(path.join(LOCK))?;
            lock.lock_shared()?;
            Ok(Self { path: path.to_owned(), run, lock })
        };
        joined().map_err(|e| shared_memory_error("joining the run", &e))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of the run.
    pub fn run(&self) -> u64 {
        self.run
    }

    /// Waits until no other process of the run is left, so that dropping this removes it; gives up after a while. To be called
    /// when the orchestrator has died: the system closes its pipes, by which a unit notices, before or after its lock.
    pub fn outlive(&self) {
        let began = Instant::now();
        while self.lock.try_lock().is_err() && began.elapsed() < DYING {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// A prefix for the names of the run's segments, which nobody can foresee.
    pub(super) fn new_prefix(&self) -> String {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        format!("{name}-{:016x}.", random())
    }

    /// Closes the segments that there are with this prefix to other users.
    pub(super) fn close_segments(&self, prefix: &str) -> Result<()> {
        for segment in beginning(&self.path.with_file_name(prefix)) {
            // What another user may have put there is never followed.
            let no_follow = rustix::fs::OFlags::NOFOLLOW.bits().cast_signed();
            let file = File::options().read(true).custom_flags(no_follow).open(segment)?;
            file.set_permissions(PermissionsExt::from_mode(0o600))?;
        }
        Ok(())
    }

    fn try_to_create(parent: &Path) -> Result<Self> {
        let mine = format!("cofferdam-{}-", rustix::process::geteuid().as_raw());
        let run = |run: &str| parent.join(format!("{mine}{run}"));
        for entry in std::fs::read_dir(parent)?.flatten() {
            let name = entry.file_name();
            let of_mine = name.to_str().and_then(|name| name.strip_prefix(&mine));
            match of_mine.map(|rest| rest.split_once('-')) {
                Some(None) => remove_if_unused(&entry.path()),
                // A segment whose unit made it after the run's folder had been removed.
                Some(Some((of_run, _))) if !run(of_run).exists() => remove_segment(&entry.path()),
                _ => (),
            }
        }
        let mut attempts = (0..ATTEMPTS).map(|_| Self::make(parent, &mine));
        // Another run may have found a lock before it was held, and removed all.
        let lost = |made: &Result<Self>| made.as_ref().is_err_and(|e| e.kind() == ErrorKind::NotFound);
        attempts
            .find(|made| !lost(made))
            .unwrap_or_else(|| Err(Error::other("other runs remove every folder")))
    }

    fn make(parent: &Path, mine: &str) -> Result<Self> {
        let run = random();
        let path = parent.join(format!("{mine}{run:016x}"));
        std::fs::DirBuilder::new().mode(0o700).create(&path)?;
        let lock = File::create_new(path.join(LOCK))?;
        lock.lock_shared()?;
        // Removed before it was locked, it is not found.
        std::fs::symlink_metadata(path.join(LOCK))?;
        Ok(Self { path, run, lock })
    }
}

impl Drop for Folder {
    /// Removes it if no other process uses it.
    fn drop(&mut self) {
        if self.lock.try_lock().is_ok() {
            remove(&self.path);
        }
    }
}

/// Whether it is a folder that only this user may enter.
fn is_private(metadata: &Metadata) -> bool {
    metadata.is_dir() && is_mine(metadata) && metadata.mode() & 0o077 == 0
}

fn is_mine(metadata: &Metadata) -> bool {
    metadata.uid() == rustix::process::geteuid().as_raw()
}

/// What is in the folder of `path` and has a name that begins with its name.
fn beginning(path: &Path) -> impl Iterator<Item = PathBuf> {
    let begin = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let beside = path.parent().and_then(|parent| std::fs::read_dir(parent).ok()).into_iter().flatten();
    let name = move |entry: &DirEntry| entry.file_name().to_string_lossy().starts_with(&begin);
    beside.flatten().filter(name).map(|entry| entry.path())
}

/// Removes what belongs to a run. What cannot be removed does no harm; the next run tries again.
fn remove(folder: &Path) {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    beginning(&folder.with_file_name(format!("{name}-"))).for_each(|segment| remove_segment(&segment));
    let _ = std::fs::remove_dir_all(folder);
}

/// Removes a segment, unless it is another user's.
fn remove_segment(path: &Path) {
    if std::fs::symlink_metadata(path).is_ok_and(|m| m.is_file() && is_mine(&m)) {
        let _ = std::fs::remove_file(path);
    }
}

/// Removes the folder of a run whose processes have all ended. What cannot be removed does no harm.
fn remove_if_unused(folder: &Path) {
    let Ok(metadata) = std::fs::symlink_metadata(folder) else { return };
    if !is_private(&metadata) {
        return;
    }
    let unused = match File::options().append(true).open(folder.join(LOCK)) {
        // Held until the folder is removed.
        Ok(lock) if lock.try_lock().is_ok() => Some(lock),
        Ok(_) => return,
        Err(_) => None,
    };
    let old = || metadata.modified().is_ok_and(|then| then.elapsed().is_ok_and(|age| age > OLD));
    if unused.is_some() || old() {
        remove(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_private_and_lasts_as_long_as_one_process_uses_it() {
        let parent = tempfile::tempdir().expect("a folder");
        let first = Folder::try_to_create(parent.path()).expect("a folder");
        assert!(is_private(&std::fs::metadata(first.path()).expect("it exists")));
        let joined = Folder::join(first.path(), first.run()).expect("it is there");
        // The next run leaves a folder in use alone.
        let next = Folder::try_to_create(parent.path()).expect("a folder");
        let path = first.path().to_owned();
        drop(first);
        assert!(path.exists(), "the other process uses it");
        drop(joined);
        assert!(!path.exists() && next.path().exists());
    }

    /// Each creation looks for folders that nobody locks, and finds those of the others before they are locked.
    #[test]
    fn runs_that_begin_at_the_same_time_all_have_their_folders() {
        let parent = tempfile::tempdir().expect("a folder");
        let begin = || {
            for _ in 0..300 {
                let folder = Folder::try_to_create(parent.path()).expect("a folder");
                assert!(folder.path().join(LOCK).exists());
            }
        };
        std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(begin))));
        assert_eq!(std::fs::read_dir(parent.path()).expect("it exists").count(), 0);
    }

    #[test]
    fn who_outlives_the_others_removes_the_folder() {
        let parent = tempfile::tempdir().expect("a folder");
        let dying = Folder::try_to_create(parent.path()).expect("a folder");
        let path = dying.path().to_owned();
        let units: Vec<Folder> =
            (0..2).map(|_| Folder::join(&path, dying.run()).expect("it is there")).collect();
        std::thread::scope(|scope| {
            for unit in units {
                scope.spawn(move || {
                    unit.outlive();
                    drop(unit);
                });
            }
            std::thread::sleep(DYING / 5);
            dying.lock.unlock().expect("unlocked, as by the end of the process");
        });
        assert!(!path.exists());
    }

    #[test]
    fn what_was_left_is_removed_by_the_next_run() {
        let parent = tempfile::tempdir().expect("a folder");
        let killed = Folder::try_to_create(parent.path()).expect("a folder");
        std::fs::write(killed.path().join("segment"), "x").expect("written");
        let path = killed.path().to_owned();
        killed.lock.unlock().expect("unlocked, as by the end of the process");
        let made = |name: &str| {
            let path = parent.path().join(path.with_file_name(name));
            std::fs::DirBuilder::new().mode(0o700).create(&path).expect("made");
            path
        };
        let mine = format!("cofferdam-{}", rustix::process::geteuid().as_raw());
        let (just_made, old) = (made(&format!("{mine}-1")), made(&format!("{mine}-2")));
        let then = std::time::SystemTime::now() - 2 * OLD;
        File::open(&old).and_then(|folder| folder.set_modified(then)).expect("changed");
        let _next = Folder::try_to_create(parent.path()).expect("a folder");
        assert!(!path.exists(), "its processes have ended");
        assert!(just_made.exists() && !old.exists());
    }

    #[test]
    fn the_segments_of_a_run_are_removed_with_its_folder() {
        let parent = tempfile::tempdir().expect("a folder");
        let segment = |folder: &Folder| {
            let prefix = folder.new_prefix();
            let path = parent.path().join(format!("{prefix}data"));
            std::fs::write(&path, "x").expect("written");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o666)).expect("opened");
            folder.close_segments(&prefix).expect("closed");
            assert_eq!(std::fs::metadata(&path).expect("it exists").mode() & 0o777, 0o600);
            path
        };
        let (first, killed) = (Folder::try_to_create(parent.path()), Folder::try_to_create(parent.path()));
        let (first, killed) = (first.expect("a folder"), killed.expect("a folder"));
        let (of_first, of_killed) = (segment(&first), segment(&killed));
        killed.lock.unlock().expect("unlocked, as by the end of the process");
        let next = Folder::try_to_create(parent.path()).expect("a folder");
        assert!(of_first.exists() && !of_killed.exists(), "the first run continues");
        drop(first);
        assert!(!of_first.exists());
        // A unit that nobody waited for makes one after its run.
        std::fs::write(&of_first, "x").expect("written");
        drop((Folder::try_to_create(parent.path()).expect("a folder"), next));
        assert!(!of_first.exists());
    }

    #[test]
    fn a_folder_that_others_may_enter_is_not_joined() {
        let parent = tempfile::tempdir().expect("a folder");
        let folder = Folder::try_to_create(parent.path()).expect("a folder");
        let mut open = std::fs::metadata(folder.path()).expect("it exists").permissions();
        open.set_mode(0o755);
        std::fs::set_permissions(folder.path(), open).expect("changed");
        let refused = Folder::join(folder.path(), folder.run()).expect_err("it is refused").to_string();
        assert!(refused.contains("others may enter"), "{refused}");
        assert!(Folder::join(&parent.path().join("none"), 1).is_err());
    }
}
