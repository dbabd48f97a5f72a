use super::FmuError;
use cofferdam_unit::export::MARKER;
use std::path::{Path, PathBuf};

/// This platform, as FMI 3.0 names it.
const PLATFORM: &str = "x86_64-linux";

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// 2.0: every variable is a scalar.
    Fmi2,
    /// 3.0.
    Fmi3,
}

impl Version {
    /// Its number.
    pub fn number(self) -> &'static str {
        match self {
            Self::Fmi2 => "2.0",
            Self::Fmi3 => "3.0",
        }
    }
}

/// The shared library of a unit, for Linux on x86-64.
pub struct Library {
    bytes: Vec<u8>,
}

impl Library {
    /// Reads the library of the unit `name`: the one at `given`, or the one that was built together with this program.
    ///
    /// **Errors**: there is none, it is not a library of this platform, or it is the library of another unit.
    pub fn find(name: &str, given: Option<&Path>) -> Result<Self, FmuError> {
        let path = match given {
            Some(path) => path.to_owned(),
            None => built_with(&std::env::current_exe().map_err(FmuError::Program)?, name)?,
        };
        match std::fs::read(&path) {
            Ok(bytes) => Self::of(bytes, name, path),
            Err(cause) => Err(FmuError::UnreadableLibrary { path, cause }),
        }
    }

    fn of(bytes: Vec<u8>, name: &str, path: PathBuf) -> Result<Self, FmuError> {
        if !is_library(&bytes) {
            return Err(FmuError::NotALibrary { path, platform: PLATFORM });
        }
        let marker = format!("{MARKER}{name}\0");
        if !bytes.windows(marker.len()).any(|window| window == marker.as_bytes()) {
            return Err(FmuError::OtherLibrary { path, unit: name.to_owned() });
        }
        Ok(Self { bytes })
    }

    /// The file's content.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Its path in an FMU whose model identifier is `name`; the same library serves both versions.
    pub fn entry(&self, name: &str, version: Version) -> String {
        let platform = match version {
            Version::Fmi2 => "linux64",
            Version::Fmi3 => PLATFORM,
        };
        format!("binaries/{platform}/{name}.so")
    }
}

/// The library of the unit `name` that was built together with `program`.
fn built_with(program: &Path, name: &str) -> Result<PathBuf, FmuError> {
    let file = format!("lib{name}_fmu.so");
    // cargo rebuilds the one in `deps` together with the program; the one beside the program may be older.
    let folders = [program.with_file_name("deps"), program.with_file_name("")];
    match folders.iter().map(|folder| folder.join(&file)).find(|path| path.is_file()) {
        Some(path) => Ok(path),
        None => {
            let folders = folders.map(|folder| folder.display().to_string()).join(" or ");
            Err(FmuError::NoLibrary { file, folders })
        }
    }
}

/// Whether a file begins as a shared library of this platform: ELF of 64 bits, a shared object (`e_type` 3), for x86-64
/// (`e_machine` 62).
fn is_library(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x7fELF\x02") && bytes.get(16..20) == Some(&[3, 0, 62, 0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that begins like a library of this platform.
    fn blob(kind: u8, tail: &str) -> Vec<u8> {
        let own = std::fs::read(std::env::current_exe().expect("a test has a path")).expect("readable");
        let mut bytes = own[..20].to_vec();
        bytes[16] = kind;
        bytes.extend(tail.bytes());
        bytes
    }

    fn refused(bytes: Vec<u8>) -> String {
        Library::of(bytes, "dam", "x.so".into()).err().map_or_else(String::new, |error| error.to_string())
    }

    #[test]
    fn only_the_units_own_library_is_taken() {
        assert!(Library::of(blob(3, "..cofferdam unit: dam\0.."), "dam", "x.so".into()).is_ok());
        assert!(refused(b"PK".to_vec()).contains("not a shared library for"));
        // A program, not a library (`e_type` 2).
        assert!(refused(blob(2, "cofferdam unit: dam\0")).contains("not a shared library for"));
        let other = refused(blob(3, "cofferdam unit: reservoir\0"));
        assert!(other.contains("is not the library of the unit `dam`"), "{other}");
    }

    #[test]
    fn the_library_lies_beside_the_program() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let program = folder.path().join("cofferdam");
        let error = built_with(&program, "dam").err().map_or_else(String::new, |e| e.to_string());
        for word in ["libdam_fmu.so", &*folder.path().to_string_lossy(), "deps", "--library"] {
            assert!(error.contains(word), "`{word}` in {error}");
        }
        let (beside, deps) = (folder.path().join("libdam_fmu.so"), folder.path().join("deps/libdam_fmu.so"));
        std::fs::write(&beside, "")?;
        assert_eq!(built_with(&program, "dam").ok(), Some(beside));
        std::fs::create_dir(folder.path().join("deps"))?;
        std::fs::write(&deps, "")?;
        assert_eq!(built_with(&program, "dam").ok(), Some(deps));
        Ok(())
    }
}
