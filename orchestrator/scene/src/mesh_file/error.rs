use cofferdam_unit::number::plain;
use std::path::PathBuf;

/// A file of a mesh that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The file cannot be read.
    #[error("{}: {cause}; a mesh is a text file of Gmsh (`Mesh.Binary = 0`), named relative to the scene's folder", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// Another file than the one that was run.
    #[error(
        "{}: the file's SHA-256 is {found}, not `sha256`: it is another mesh than the one that was run; find that one, or give this one's \
         `sha256`", path.display()
    )]
    Another {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
    },
    /// A format that is not read.
    #[error(
        "{}: {found}; MSH 4.1 and 2.2 in ASCII are read: save it with `Mesh.MshFileVersion = 4.1` and `Mesh.Binary = 0`", path.display()
    )]
    Format {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
    },
    /// A line that is not what it should be.
    #[error("{}:{line}: `{text}` is not {expected}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What stands there.
        text: String,
        /// What should.
        expected: &'static str,
    },
    /// The file ends too early, or lacks a part.
    #[error("{}: it ends without {missing}; save it again, whole", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// What is missing.
        missing: &'static str,
    },
    /// An element that the dam does not have.
    #[error("{}:{line}: element {element} is of Gmsh's type {kind}, {what}", path.display())]
    Element {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// Its tag.
        element: u64,
        /// Its type.
        kind: u64,
        /// What that is, and the remedy.
        what: &'static str,
    },
    /// A node beside the plane.
    #[error("{}:{line}: node {node} has z = {z}; the section lies in the plane z = 0: shift or rotate it there", path.display())]
    OutOfPlane {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// Its tag.
        node: u64,
        /// Its z, m.
        z: f64,
    },
    /// Two nodes of one tag.
    #[error("{}:{line}: node {node} is given twice; save the mesh again", path.display())]
    TwoNodes {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// Their tag.
        node: u64,
    },
    /// An element with a node that is not there.
    #[error("{}:{line}: there is no node {node}; save the mesh again, whole", path.display())]
    NoNode {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The tag.
        node: u64,
    },
    /// A curve that is needed and not there.
    #[error(
        "{}: it has no physical curve \"{name}\", but {found}; name the curves of {what} so: Physical Curve(\"{name}\") = {{…}};",
        path.display()
    )]
    NoCurve {
        /// The file.
        path: PathBuf,
        /// Its name.
        name: String,
        /// What it would be.
        what: &'static str,
        /// The curves that are there.
        found: String,
    },
    /// A curve that nothing asks for.
    #[error(
        "{}: the physical curve \"{name}\" is neither a side (\"upstream\", \"downstream\", \"base\", \"crest\") nor the `name` of a \
         crack of the scene, {cracks}; add a [[dam.cracks]] of that name, or leave the physical curve out", path.display()
    )]
    UnknownCurve {
        /// The file.
        path: PathBuf,
        /// Its name.
        name: String,
        /// The names of the cracks.
        cracks: String,
    },
    /// A curve that forks, closes or has gaps.
    #[error("{}: the physical curve \"{name}\" {how} at ({}, {}); {remedy}", path.display(), plain(point[0]), plain(point[1]))]
    Curve {
        /// The file.
        path: PathBuf,
        /// Its name.
        name: String,
        /// What it does.
        how: &'static str,
        /// Where.
        point: [f64; 2],
        /// What to do.
        remedy: &'static str,
    },
    /// A crack that no curve can belong to.
    #[error("{}: crack {index} of the scene has no `name`; give it that of its physical curve", path.display())]
    NamelessCrack {
        /// The file.
        path: PathBuf,
        /// Its index.
        index: usize,
    },
}
