use cofferdam_unit::export::ContentsError;
use std::path::PathBuf;

/// Why an FMU cannot be packed.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// The unit's library was not found beside the program.
    #[error(
        "the library {file} is not in {folders}; build it together with the program by \
         `cargo build --release` (of this library alone, in a clone whose program is built: add `-p cofferdam-reservoir-fmu -p cofferdam-dam-fmu -p cofferdam-coupled-fmu`) and run \
         target/release/cofferdam, or give its path with --library"
    )]
    NoLibrary {
        /// Name of the file.
        file: String,
        /// Folders looked in.
        folders: String,
    },
    /// The path of the program is unknown.
    #[error(
        "the path of the program, beside which the library lies, cannot be found: {0}; give the path of the library with --library"
    )]
    Program(std::io::Error),
    /// The library cannot be read.
    #[error("{}: {cause}; give the path of a readable file with --library", path.display())]
    UnreadableLibrary {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The file is not a shared library.
    #[error(
        "{} is not a shared library for {platform}, the platform of this program; give the path of one with --library, \
         or leave out --library to use the library built with the program",
        path.display()
    )]
    NotALibrary {
        /// The file.
        path: PathBuf,
        /// Platform, as FMI names it.
        platform: &'static str,
    },
    /// The library is that of another unit.
    #[error(
        "{} is not the library of the unit `{unit}`; leave out --library to use the library built with the program",
        path.display()
    )]
    OtherLibrary {
        /// The file.
        path: PathBuf,
        /// The unit that is packed.
        unit: String,
    },
    /// The target is not a regular file.
    #[error("{} is not a regular file and is not overwritten; choose another --output", path.display())]
    NotAFile {
        /// The target.
        path: PathBuf,
    },
    /// The target exists.
    #[error("{} exists; choose another --output, or overwrite it with --force", path.display())]
    Exists {
        /// The target.
        path: PathBuf,
    },
    /// The target is a folder.
    #[error("{} is not a file name; give --output the name of the FMU to be written", path.display())]
    TargetIsFolder {
        /// The target.
        path: PathBuf,
    },
    /// The target's folder does not exist.
    #[error("the folder {} does not exist; make it first, or choose another --output", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// The FMU cannot be written.
    #[error("{}: {cause}; choose another --output", path.display())]
    Write {
        /// The target.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The archive cannot be made.
    #[error("the archive cannot be made: {0}")]
    Archive(std::io::Error),
    /// Start values that fit no input of the unit.
    #[error(
        "`{name}` cannot start with {found} values: the unit's input of that name has {expected} (0: there is none)"
    )]
    Start {
        /// Name in the contents.
        name: String,
        /// Number of values of the input of that name; 0 if there is none.
        expected: usize,
        /// Number of values in the contents.
        found: usize,
    },
    /// The unit's contents cannot be written.
    #[error(transparent)]
    Contents(#[from] ContentsError),
    /// The XML cannot be written.
    #[error("the FMU's description cannot be written as XML: {0}")]
    Xml(std::io::Error),
}
