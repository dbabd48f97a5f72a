//! Meshes of dams in files of Gmsh.
//!
//! `msh` reads the file: points, cells, named curves. `dam_mesh` finds the sides of the dam and its cracks among the curves.
//! What the parts mean together, the dam checks itself.

mod dam_mesh;
mod error;
mod msh;

pub use dam_mesh::DamMesh;
pub use error::MeshFileError;
pub use msh::MeshFile;
