use interface::export::ContentsError;
use std::path::PathBuf;

/// An FMU that cannot be packed.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// The unit's library is not where the program is.
    #[error(
        "the library {file} is not in {folders}; build it together with the program by \
         `cargo build --release` and run target/release/cofferdam, or name it by --library"
    )]
    NoLibrary {
        /// Name of the file.
        file: String,
        /// Folders looked in.
        folders: String,
    },
    /// The program does not know where it is.
    #[error(
        "the program's own file cannot be found, so neither can the library beside it: {0}; name it by --library"
    )]
    Program(std::io::Error),
    /// The library cannot be read.
    #[error("{}: {cause}; name a file that can be read by --library", path.display())]
    UnreadableLibrary {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The file is something else.
    #[error(
        "{} is no shared library of {platform}, the platform of this program; name one by --library, or let \
         the program find its own",
        path.display()
    )]
    NotALibrary {
        /// The file.
        path: PathBuf,
        /// Platform, as FMI names it.
        platform: String,
    },
    /// The library is another one.
    #[error(
        "{} is not the library of the unit `{unit}`; without --library the program finds its own",
        path.display()
    )]
    OtherLibrary {
        /// The file.
        path: PathBuf,
        /// The unit that is packed.
        unit: String,
    },
    /// The target is something that must not be replaced.
    #[error("{} is no regular file and is not overwritten; choose another --output", path.display())]
    NotAFile {
        /// The target.
        path: PathBuf,
    },
    /// The target exists.
    #[error("{} exists; choose another --output, or overwrite it by --force", path.display())]
    Exists {
        /// The target.
        path: PathBuf,
    },
    /// The target is a folder.
    #[error("{} is no name of a file; give --output the name of the FMU to be written", path.display())]
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
        /// What the system said.
        cause: std::io::Error,
    },
    /// A start value that no input of the unit can take.
    #[error("`{name}` cannot start with {found} values: the unit has an input of that name with {expected}")]
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
