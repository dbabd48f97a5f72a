//! Text files that a user names.

use std::io::{Error, Result};
use std::path::Path;

/// Longest text, bytes; the records and scenes that it is about have some 100 kB.
const LONGEST: u64 = 256 << 20;

/// Reads a file as [`std::fs::read_to_string`], but neither devices and pipes, which may never end, nor what is too long.
pub fn read(path: &Path) -> Result<String> {
    let kind = std::fs::metadata(path)?;
    if !kind.is_file() && !kind.is_dir() {
        return Err(Error::other("it is a device or a pipe, not a file"));
    }
    if kind.len() > LONGEST {
        return Err(Error::other(format!("it has {} MB, more than {}", kind.len() >> 20, LONGEST >> 20)));
    }
    std::fs::read_to_string(path)
}
