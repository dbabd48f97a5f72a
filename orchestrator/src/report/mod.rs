//! What a run says at its end.

mod manifest;
pub mod page;
mod response_spectrum;
mod summary;

pub(crate) use manifest::features;
pub use manifest::{Build, Manifest, ManifestError, Unit, WaterFace};
pub use response_spectrum::response_spectrum;
pub use summary::{Quantity, Summary};
