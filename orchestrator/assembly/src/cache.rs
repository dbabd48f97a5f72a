//! What takes long to prepare, kept on disk for the next run.

use crate::build_info::{SOLVERS, features};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Most bytes that a cache holds; what was not read for longest goes first.
const LARGEST: u64 = 2_000_000_000;
/// What is prepared in less time is not kept.
const WORTHWHILE: Duration = Duration::from_millis(50);
/// Version of the layout: what stands in the folder, and how its files are named.
const VERSION: u32 = 1;
/// How the names of entries end, and those of entries that are being written.
const ENDING: &str = "prepared";
const UNFINISHED: &str = ".unfinished";

/// A folder of prepared operators. Each entry is a file named by the hash of what it was made from and by, the sources of the
/// solvers and the features of the processor included. Entries are written beside and renamed, so that a reader sees whole ones only; they carry digests of their
/// own, by which whoever reads one knows damage. A cache that cannot be read or written is an empty one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
}

/// What a cache holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Content {
    /// Number of entries.
    pub entries: usize,
    /// Their size, bytes.
    pub bytes: u64,
}

impl Cache {
    /// The most bytes that it holds.
    pub const LARGEST: u64 = LARGEST;

    /// The cache in this folder, which is made when it is first written to.
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The user's: `cofferdam` in `$XDG_CACHE_HOME` or `$HOME/.cache`; none without either.
    pub fn of_user() -> Option<Self> {
        let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let caches = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
        Some(Self::at(caches.join("cofferdam")))
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether there is an entry of `key`.
    pub fn holds(&self, key: &str) -> bool {
        self.folder.join(file_name(key)).exists()
    }

    /// What `read` makes of the entry of `key`. Where there is none, or `read` refuses it, `make` makes it again, and it is kept if
    /// that took long. Who wants an entry that another process is making waits for it.
    ///
    /// **Errors**: those of `make`, and of `read` for what was just made. No error of the file system is one.
    pub fn prepared<T, E>(
        &self,
        key: &str,
        read: impl Fn(&[u8]) -> Result<T, E>,
        make: impl FnOnce() -> Result<Vec<u8>, E>,
    ) -> Result<T, E> {
        let path = self.folder.join(file_name(key));
        let found = || std::fs::read(&path).ok().and_then(|bytes| read(&bytes).ok());
        // Whoever makes the same holds the lock meanwhile.
        let lock = match found() {
            Some(kept) => return Ok(used(&path, kept)),
            None => Lock::wait(path.with_extension("lock"), &self.folder),
        };
        if let Some(kept) = found() {
            return Ok(used(&path, kept));
        }
        let began = Instant::now();
        let bytes = make()?;
        if began.elapsed() >= WORTHWHILE {
            // If it cannot be kept, the next run prepares again.
            let _ = self.keep(&path, &bytes);
        }
        drop(lock);
        read(&bytes)
    }

    /// What the cache holds.
    ///
    /// **Errors**: those of the file system; a folder that is not there holds nothing.
    pub fn content(&self) -> io::Result<Content> {
        let entries = self.entries()?;
        Ok(Content { entries: entries.len(), bytes: entries.iter().map(|entry| entry.bytes).sum() })
    }

    /// Removes all entries; returns what was removed. Other files in the folder stay.
    ///
    /// **Errors**: those of the file system.
    pub fn clear(&self) -> io::Result<Content> {
        let mut removed = Content::default();
        for Entry { path, bytes, .. } in self.entries()? {
            match std::fs::remove_file(path) {
                // Another process was quicker.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                done => done?,
            }
            removed = Content { entries: removed.entries + 1, bytes: removed.bytes + bytes };
        }
        Ok(removed)
    }

    fn keep(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let size = bytes.len() as u64;
        if size > LARGEST {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder)?;
        let mut entries = self.entries()?;
        entries.sort_by_key(|entry| entry.used);
        let mut held: u64 = entries.iter().map(|entry| entry.bytes).sum();
        for Entry { path, bytes, .. } in entries {
            if held + size <= LARGEST {
                break;
            }
            // Another process may have removed it.
            let _ = std::fs::remove_file(path);
            held -= bytes;
        }
        let mut file = tempfile::Builder::new().suffix(UNFINISHED).tempfile_in(&self.folder)?;
        file.write_all(bytes)?;
        file.persist(path)?;
        Ok(())
    }

    /// The entries, and what a killed process left of them.
    fn entries(&self) -> io::Result<Vec<Entry>> {
        let folder = match std::fs::read_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            folder => folder?,
        };
        let mut entries = Vec::new();
        for path in folder.map(|entry| Ok::<_, io::Error>(entry?.path())) {
            let path = path?;
            let own =
                path.extension().is_some_and(|end| [ENDING, &UNFINISHED[1..]].iter().any(|own| end == *own));
            // Another process may have removed it meanwhile.
            if let Some(metadata) = std::fs::metadata(&path).ok().filter(|_| own) {
                entries.push(Entry { path, bytes: metadata.len(), used: metadata.modified()? });
            }
        }
        Ok(entries)
    }
}

/// A file of the cache.
struct Entry {
    path: PathBuf,
    bytes: u64,
    /// When it was last used.
    used: SystemTime,
}

/// Marks an entry as used now, and returns what was read of it.
fn used<T>(path: &Path, kept: T) -> T {
    // One that cannot be marked is only thrown away sooner.
    let _ = File::options().append(true).open(path).and_then(|file| file.set_modified(SystemTime::now()));
    kept
}

/// The lock of who makes an entry.
struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Waits for the lock; none where files cannot be made or locked.
    fn wait(path: PathBuf, folder: &Path) -> Option<Self> {
        std::fs::create_dir_all(folder).ok()?;
        let file = File::options().create(true).append(true).open(&path).ok()?;
        file.lock().ok()?;
        Some(Self { path, _file: file })
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Who waits for the removed file takes its lock all the same, and finds the entry.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The file of an entry: the hash of the layout, of what has a say in the bits (sources of the solvers, features of the
/// processor) and of its key. So machines that share a folder do not share entries that they would make otherwise.
fn file_name(key: &str) -> String {
    let mut hasher = Sha256::new().chain_update(VERSION.to_le_bytes());
    for part in [SOLVERS, &features(), key] {
        hasher = hasher.chain_update(part).chain_update([0]);
    }
    let hash = hasher.finalize();
    let digits: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{digits}.{ENDING}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slowly(bytes: &[u8]) -> Result<Vec<u8>, String> {
        std::thread::sleep(WORTHWHILE);
        Ok(bytes.to_vec())
    }

    /// Reads entries that begin with 7.
    fn read(bytes: &[u8]) -> Result<Vec<u8>, String> {
        if bytes.first() == Some(&7) { Ok(bytes.to_vec()) } else { Err("damaged".to_owned()) }
    }

    fn never() -> Result<Vec<u8>, String> {
        Err("it is made again".to_owned())
    }

    #[test]
    fn what_took_long_is_made_once() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let cache = Cache::at(folder.path().join("new"));
        assert_eq!(cache.content()?, Content::default());
        assert_eq!(cache.prepared("quick", read, || Ok(vec![7])), Ok(vec![7]));
        assert_eq!(cache.prepared("quick", read, never), Err("it is made again".to_owned()));
        assert_eq!(cache.prepared("a", read, || slowly(&[7, 1])), Ok(vec![7, 1]));
        assert_eq!(cache.prepared("a", read, never), Ok(vec![7, 1]));
        assert_eq!(cache.prepared("b", read, || slowly(&[7, 2, 3])), Ok(vec![7, 2, 3]));
        assert_eq!(cache.content()?, Content { entries: 2, bytes: 5 });
        std::fs::write(cache.folder().join("notes.txt"), "not an entry")?;
        assert_eq!(cache.clear()?, Content { entries: 2, bytes: 5 });
        assert_eq!(std::fs::read_dir(cache.folder())?.count(), 1, "no lock is left, and notes.txt stays");
        Ok(())
    }

    #[test]
    fn damage_and_errors_are_made_anew() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let cache = Cache::at(folder.path());
        cache.prepared("a", read, || slowly(&[7]))?;
        std::fs::write(folder.path().join(file_name("a")), [8])?;
        assert_eq!(cache.prepared("a", read, || slowly(&[7, 7])), Ok(vec![7, 7]));
        assert_eq!(cache.prepared("a", read, never), Ok(vec![7, 7]));
        assert_eq!(cache.prepared("b", read, never), Err("it is made again".to_owned()));
        assert_eq!(cache.prepared("b", read, || slowly(&[7])), Ok(vec![7]));
        // A folder that cannot be made.
        let nowhere = Cache::at("/dev/null/cache");
        for _ in 0..2 {
            assert_eq!(nowhere.prepared("a", read, || slowly(&[7])), Ok(vec![7]));
        }
        assert_eq!(nowhere.prepared("a", read, never), Err("it is made again".to_owned()));
        Ok(())
    }

    #[test]
    fn who_wants_the_same_at_once_waits() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let cache = Cache::at(folder.path());
        let made = std::sync::atomic::AtomicUsize::new(0);
        let make = || {
            made.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            slowly(&[7])
        };
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| assert_eq!(cache.prepared("a", read, make), Ok(vec![7])));
            }
        });
        assert_eq!(made.into_inner(), 1);
        Ok(())
    }

    #[test]
    fn what_was_not_used_for_longest_goes_first() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let cache = Cache::at(folder.path());
        let sparse = |name: &str, age: u64| -> io::Result<()> {
            let file = File::create(folder.path().join(file_name(name)))?;
            file.set_len(LARGEST / 2 - 10)?;
            file.set_modified(SystemTime::now() - Duration::from_secs(age))
        };
        sparse("old", 100)?;
        sparse("older", 200)?;
        cache.prepared("new", read, || slowly(&[7; 30]))?;
        let is_there = |name: &str| folder.path().join(file_name(name)).exists();
        assert_eq!(["new", "old", "older"].map(is_there), [true, true, false]);
        assert!(cache.content()?.bytes <= LARGEST);
        Ok(())
    }
}
