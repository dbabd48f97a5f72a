//! What a run says at its end.

mod manifest;
mod summary;

pub use manifest::{Build, Manifest, ManifestError, Unit};
pub use summary::{Quantity, Summary};
