//! An FMU on disk, unpacked: whatever its archive claims, nothing is written outside its folder, and no more than [`MOST`].

use cofferdam_coupling::temporary::TemporaryFolder;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Component, Path, PathBuf};
use zip::ZipArchive;

/// Most bytes of an unpacked FMU; those of this program have up to 100 MB.
const MOST: u64 = 2 << 30;
/// Most files of an FMU.
const MOST_FILES: usize = 20_000;
/// Parts of an FMU that no importer on this machine needs.
const LEFT_OUT: [&str; 2] = ["sources", "documentation"];
/// Folders of libraries that run on this machine, of FMI 3.0 and 2.0.
const PLATFORMS: [&str; 2] = ["x86_64-linux", "linux64"];
const LIBRARIES: &str = "binaries";

/// An FMU's files.
#[derive(Debug)]
pub struct Unpacked {
    folder: PathBuf,
    /// SHA-256 of the archive, or of the files of a folder, in hexadecimal digits.
    pub sha256: String,
    /// Removed when it is no longer used; none for an FMU that its user has unpacked.
    _own: Option<TemporaryFolder>,
}

/// Why a file cannot be used as an FMU.
#[derive(Debug, thiserror::Error)]
pub enum UnpackError {
    /// It cannot be read.
    #[error("{path}: {cause}", path = path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// It is no archive, or a damaged one.
    #[error("{path}: it is no FMU, that is, no zip archive that can be read: {cause}", path = path.display())]
    NotAnArchive {
        /// The file.
        path: PathBuf,
        /// What the archive's reader said.
        cause: zip::result::ZipError,
    },
    /// An entry that would be written elsewhere, or a link.
    #[error("{path}: its entry {entry:?} {why}; an honest FMU has none of these, nothing was used", path = path.display())]
    Entry {
        /// The file.
        path: PathBuf,
        /// Name of the entry.
        entry: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// Entries of one name, of which others may read another.
    #[error(
        "{path}: it has {told} entries, but {found} names: an entry is there twice; pack it again, nothing was used", path = path.display()
    )]
    Twice {
        /// The file.
        path: PathBuf,
        /// Number of entries.
        told: usize,
        /// Number of their names.
        found: usize,
    },
    /// It does not end.
    #[error(
        "{path}: it holds more than {most}; unpack it by hand if it is trustworthy, and give its folder", path = path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit that it passes.
        most: String,
    },
    /// There is no description in it.
    #[error("{path}: it is no FMU: there is no modelDescription.xml at its top", path = path.display())]
    NoDescription {
        /// The file.
        path: PathBuf,
    },
}

impl Unpacked {
    /// The FMU at `path`, an archive or the folder of an unpacked one.
    ///
    /// Of an archive only what this machine needs is unpacked, into a temporary folder that other users cannot enter.
    ///
    /// **Errors**: [`UnpackError`].
    pub fn open(path: &Path) -> Result<Self, UnpackError> {
        let unreadable = |cause| UnpackError::Unreadable { path: path.to_owned(), cause };
        let kind = std::fs::metadata(path).map_err(unreadable)?;
        let unpacked = if kind.is_dir() {
            let folder = path.canonicalize().map_err(unreadable)?;
            Self { sha256: of_folder(&folder).map_err(unreadable)?, folder, _own: None }
        } else if kind.is_file() {
            let own = TemporaryFolder::create("cofferdam-fmu-").map_err(unreadable)?;
            let sha256 = of_file(path).map_err(unreadable)?;
            unpack(path, own.path(), MOST)?;
            Self { folder: own.path().to_owned(), sha256, _own: Some(own) }
        } else {
            return Err(unreadable(std::io::Error::other("it is a device or a pipe, not a file")));
        };
        if !unpacked.description().is_file() {
            return Err(UnpackError::NoDescription { path: path.to_owned() });
        }
        Ok(unpacked)
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its modelDescription.xml.
    pub fn description(&self) -> PathBuf {
        self.folder.join("modelDescription.xml")
    }

    /// The platforms for which it has libraries, sorted, and the sources, if it has no library.
    pub fn platforms(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.join(LIBRARIES)).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// Unpacks the archive at `path` into `folder`, up to `most` bytes.
fn unpack(path: &Path, folder: &Path, most: u64) -> Result<(), UnpackError> {
    let unreadable = |cause| UnpackError::Unreadable { path: path.to_owned(), cause };
    let damaged = |cause| UnpackError::NotAnArchive { path: path.to_owned(), cause };
    let mut archive = ZipArchive::new(File::open(path).map_err(unreadable)?).map_err(damaged)?;
    let too_large = |most: String| UnpackError::TooLarge { path: path.to_owned(), most };
    if archive.len() > MOST_FILES {
        return Err(too_large(format!("{MOST_FILES} files")));
    }
    // The archive's reader keeps the last of those that have one name.
    if let Some(told) = told_entries(path, archive.comment().len()).filter(|told| *told != archive.len()) {
        return Err(UnpackError::Twice { path: path.to_owned(), told, found: archive.len() });
    }
    let mut left = most;
    let mut taken = BTreeSet::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(damaged)?;
        let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
        let refused = |why| UnpackError::Entry { path: path.to_owned(), entry: name.clone(), why };
        let Some(inside) = entry.name().ok().and_then(|name| inside(&name)) else {
            return Err(refused("would be written outside the FMU's folder"));
        };
        let linked = entry.unix_mode().is_some_and(|mode| mode & 0o170_000 == 0o120_000);
        if linked || entry.is_symlink() {
            return Err(refused("is a link"));
        }
        if inside.as_os_str().is_empty() {
            continue;
        }
        if entry.is_dir() {
            // A folder that is left out would only be empty.
            continue;
        }
        if !taken.insert(inside.clone()) {
            return Err(refused("is there twice"));
        }
        if is_left_out(&inside) {
            continue;
        }
        let target = folder.join(&inside);
        if let Some(parent) = target.parent() {
            std::fs::create_dir_all(parent).map_err(unreadable)?;
        }
        let mut file = File::create_new(&target).map_err(unreadable)?;
        // What the archive claims of an entry's size proves nothing.
        let copied = std::io::copy(&mut (&mut entry).take(left + 1), &mut file).map_err(unreadable)?;
        left = left.checked_sub(copied).ok_or_else(|| too_large(format!("{} MiB", most >> 20)))?;
        file.flush().map_err(unreadable)?;
    }
    // So that one knows for which platforms it is.
    for name in taken.iter().filter_map(|path| platform(path)) {
        std::fs::create_dir_all(folder.join(LIBRARIES).join(name)).map_err(unreadable)?;
    }
    Ok(())
}

/// The number of entries that the end of an archive tells, where it ends in a `comment` of this length; none if there are more
/// than it can tell.
fn told_entries(path: &Path, comment: usize) -> Option<usize> {
    let (mut file, mut end) = (File::open(path).ok()?, [0; 22]);
    file.seek(SeekFrom::End(-(end.len() as i64 + comment as i64))).ok()?;
    file.read_exact(&mut end).ok()?;
    let told = u16::from_le_bytes([end[10], end[11]]);
    (end.starts_with(b"PK\x05\x06") && told < u16::MAX).then_some(usize::from(told))
}

/// The path of an entry below the FMU's folder; none if it leads out of it. Some packers separate folders by backslashes.
fn inside(name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    if name.contains('\0') || name.as_bytes().get(1) == Some(&b':') {
        return None;
    }
    let mut inside = PathBuf::new();
    for component in Path::new(&name).components() {
        match component {
            Component::Normal(part) => inside.push(part),
            Component::CurDir => (),
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(inside)
}

/// The platform to whose libraries a file belongs.
fn platform(path: &Path) -> Option<&str> {
    let mut parts = path.iter().filter_map(std::ffi::OsStr::to_str);
    (parts.next() == Some(LIBRARIES)).then(|| parts.next())?
}

fn is_left_out(path: &Path) -> bool {
    let first = path.iter().next().and_then(std::ffi::OsStr::to_str).unwrap_or("");
    LEFT_OUT.contains(&first) || platform(path).is_some_and(|name| !PLATFORMS.contains(&name))
}

fn digits(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a file, or of a folder's files and their names, in hexadecimal digits.
pub fn sha256_of(path: &Path) -> std::io::Result<String> {
    if path.is_dir() { of_folder(path) } else { of_file(path) }
}

fn of_file(path: &Path) -> std::io::Result<String> {
    let mut hash = Sha256::new();
    add(&mut hash, path)?;
    Ok(digits(hash))
}

fn add(hash: &mut Sha256, path: &Path) -> std::io::Result<()> {
    let (mut file, mut part) = (File::open(path)?, vec![0; 1 << 16]);
    loop {
        match file.read(&mut part)? {
            0 => return Ok(()),
            length => hash.update(&part[..length]),
        }
    }
}

/// Of the names and contents of all files in it, in the order of their names.
fn of_folder(folder: &Path) -> std::io::Result<String> {
    let (mut folders, mut files) = (vec![folder.to_owned()], Vec::new());
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next)? {
            let entry = entry?;
            // Links are not followed: they may lead in circles.
            let kind = entry.file_type()?;
            if kind.is_dir() {
                folders.push(entry.path());
            } else if kind.is_file() {
                files.push(entry.path());
            }
            if files.len() > MOST_FILES {
                return Err(std::io::Error::other(format!("it holds more than {MOST_FILES} files")));
            }
        }
    }
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        hash.update(file.strip_prefix(folder).unwrap_or(&file).to_string_lossy().as_bytes());
        add(&mut hash, &file)?;
    }
    Ok(digits(hash))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;
    use tempfile::TempDir;
    use zip::write::SimpleFileOptions;
    use zip::{CompressionMethod, ZipWriter};

    type Result = std::result::Result<(), Box<dyn std::error::Error>>;

    fn archive(entries: &[(&str, &[u8])]) -> std::result::Result<Vec<u8>, Box<dyn std::error::Error>> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        for (name, bytes) in entries {
            archive.start_file(*name, options)?;
            archive.write_all(bytes)?;
        }
        Ok(archive.finish()?.into_inner())
    }

    /// Unpacks an archive with a limit of 1 MiB; the folder, and what was said.
    fn unpacked(bytes: &[u8]) -> std::result::Result<(TempDir, String), std::io::Error> {
        let place = tempfile::tempdir()?;
        let (file, folder) = (place.path().join("x.fmu"), place.path().join("folder"));
        std::fs::write(&file, bytes)?;
        std::fs::create_dir(&folder)?;
        let said = unpack(&file, &folder, 1 << 20).err().map(|error| error.to_string());
        Ok((place, said.unwrap_or_default()))
    }

    fn size(folder: &Path) -> u64 {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.filter_map(|entry| entry.metadata().ok()).map(|file| file.len()).sum()
    }

    #[test]
    fn a_bomb_is_refused_whatever_it_says_of_its_size() -> Result {
        let zeros = vec![0; 8 << 20];
        let honest = archive(&[("zeros", &zeros), ("more", &zeros)])?;
        assert!(honest.len() < 1 << 16, "{}", honest.len());
        let mut lying = honest.clone();
        // The size of an entry stands 24 bytes into its place in the directory, and 22 into its local header.
        for (mark, at) in [(b"PK\x01\x02", 24), (b"PK\x03\x04", 22)] {
            let entries = honest.windows(4).enumerate().filter(|(_, bytes)| bytes == mark);
            entries.for_each(|(start, _)| lying[start + at..start + at + 4].copy_from_slice(&[9, 0, 0, 0]));
        }
        assert!(lying != honest);
        for (bytes, most) in [(honest, (1 << 20) + 1), (lying, 1 << 20)] {
            let (place, said) = unpacked(&bytes)?;
            assert!(!said.is_empty());
            assert!(size(&place.path().join("folder")) <= most, "{said}");
        }
        Ok(())
    }

    #[test]
    fn many_small_entries_are_as_much_as_a_large_one() -> Result {
        let part = vec![7; 300 << 10];
        let entries: Vec<(String, &[u8])> = (0..8).map(|i| (format!("part {i}"), &part[..])).collect();
        let entries: Vec<(&str, &[u8])> = entries.iter().map(|(name, bytes)| (&**name, *bytes)).collect();
        assert_eq!(unpacked(&archive(&entries[..3])?)?.1, "");
        let (place, said) = unpacked(&archive(&entries)?)?;
        assert!(said.contains("it holds more than 1 MiB; unpack it by hand"), "{said}");
        assert!(size(&place.path().join("folder")) <= (1 << 20) + 1);
        Ok(())
    }

    #[test]
    fn names_stay_inside() {
        for name in ["../x", "a/../../x", "a/../x", "/x", "\\x", "a\\..\\x", "..", "x\0", "C:\\x"] {
            assert_eq!(inside(name), None, "{name:?}");
        }
        for (name, path) in
            [("a/b", "a/b"), ("a\\b\\c", "a/b/c"), ("./a", "a"), ("a//b/", "a/b"), ("...", "...")]
        {
            assert_eq!(inside(name), Some(path.into()), "{name:?}");
        }
    }

    #[test]
    fn only_what_this_machine_needs_is_unpacked() -> Result {
        let files =
            ["modelDescription.xml", "binaries/x86_64-linux/a.so", "binaries/win64/a.dll", "sources/a.c"];
        let (place, said) = unpacked(&archive(&files.map(|name| (name, &b"x"[..])))?)?;
        assert_eq!(said, "");
        let there = files.map(|name| place.path().join("folder").join(name).exists());
        assert_eq!(there, [true, true, false, false]);
        // So that the platforms can be listed.
        assert!(place.path().join("folder/binaries/win64").is_dir());
        Ok(())
    }
}
