//! The bytes of a file, read at any place, and the frames of its records.

use super::LogReadError;
use std::fs::{File, TryLockError};
use std::io::Error;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A regular file; counts what is read of it.
#[derive(Debug)]
pub struct Source {
    path: PathBuf,
    file: File,
    size: u64,
    running: bool,
    read: Arc<AtomicU64>,
}

/// Opcode and length of a record.
pub const FRAME: u64 = 9;
/// Longest record and chunk, bytes; a longer one has a damaged length.
pub const LONGEST: u64 = 1 << 28;
/// Bytes of a record that are read with its frame: those of a chunk before the name of its compression.
const FIRST: usize = 28;

/// A record that fits into the file.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Place of its opcode, bytes from the beginning of the file.
    pub place: u64,
    /// Its opcode.
    pub opcode: u8,
    /// Length of its content.
    pub length: u64,
    /// The first bytes of its content.
    pub first: [u8; FIRST],
}

impl Frame {
    /// Place of its content.
    pub fn content(&self) -> u64 {
        self.place + FRAME
    }

    /// Place behind it.
    pub fn end(&self) -> u64 {
        self.content() + self.length
    }

    /// Its opcode and length, as in the file.
    pub fn bytes(&self) -> [u8; FRAME as usize] {
        let mut bytes = [self.opcode; FRAME as usize];
        bytes[1..].copy_from_slice(&self.length.to_le_bytes());
        bytes
    }
}

/// The whole number of 4 bytes at `place`; 0 where there are fewer.
pub fn u32_at(bytes: &[u8], place: usize) -> u32 {
    bytes.get(place..place + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes)
}

/// The whole number of 8 bytes at `place`; 0 where there are fewer.
pub fn u64_at(bytes: &[u8], place: usize) -> u64 {
    bytes.get(place..place + 8).and_then(|b| b.try_into().ok()).map_or(0, u64::from_le_bytes)
}

impl Source {
    /// Opens the file `path`; `read` counts the bytes read of it.
    pub fn open(path: &Path, read: Arc<AtomicU64>) -> Result<Self, LogReadError> {
        let failed = |cause| LogReadError::Open { path: path.to_owned(), cause };
        // Checked before opening, because opening a pipe waits for a writer.
        let metadata = std::fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            return Err(LogReadError::Irregular { path: path.to_owned() });
        }
        let file = File::open(path).map_err(failed)?;
        // Before the size: a writer that ends in between leaves a file that is longer, not one that seems to be cut.
        let running = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
        // Without locks, as on some network file systems, nobody is seen to write.
        drop(file.unlock());
        let size = file.metadata().map_err(failed)?.len();
        Ok(Self { path: path.to_owned(), file, size, running, read })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Length of the file when it was opened, bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Whether it was being written when it was opened.
    pub fn running(&self) -> bool {
        self.running
    }

    /// Reads `buffer` from `place` on.
    pub fn read(&self, place: u64, buffer: &mut [u8]) -> Result<(), LogReadError> {
        self.read.fetch_add(buffer.len() as u64, Ordering::Relaxed);
        self.file.read_exact_at(buffer, place).map_err(|cause| self.unreadable(place, cause))
    }

    /// `length` bytes from `place` on, or up to the end of the file.
    pub fn bytes(&self, place: u64, length: u64) -> Result<Vec<u8>, LogReadError> {
        let mut bytes = vec![0; length.min(self.size.saturating_sub(place)) as usize];
        self.read(place, &mut bytes)?;
        Ok(bytes)
    }

    /// The frame of the record at `place`; none if there is none, or the file ends inside it.
    pub fn frame(&self, place: u64) -> Result<Option<Frame>, LogReadError> {
        let remaining = self.size.saturating_sub(place);
        if remaining < FRAME {
            return Ok(None);
        }
        let mut bytes = [0; FRAME as usize + FIRST];
        let there = remaining.min(bytes.len() as u64) as usize;
        self.read(place, &mut bytes[..there])?;
        let (opcode, length) = (bytes[0], u64_at(&bytes, 1));
        // A chunk that was not finished has no length; a crash may leave zeros.
        if opcode == 0 || length > remaining - FRAME {
            return Ok(None);
        }
        let mut first = [0; FIRST];
        first.copy_from_slice(&bytes[FRAME as usize..]);
        Ok(Some(Frame { place, opcode, length, first }))
    }

    fn unreadable(&self, position: u64, cause: Error) -> LogReadError {
        LogReadError::Read { path: self.path.clone(), position, cause }
    }

    /// The damage at `position`.
    pub fn damaged(&self, position: u64, cause: impl Into<String>) -> LogReadError {
        LogReadError::Damaged { path: self.path.clone(), position, cause: cause.into() }
    }
}
