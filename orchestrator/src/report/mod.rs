//! What a run says at its end.

mod accuracy;
mod ensemble;
mod envelopes;
mod manifest;
pub mod page;
mod spectra;
mod summary;

pub use accuracy::{Accuracy, PlanRow};
pub use ensemble::{EnsembleManifest, EnsembleRecord, VariedKey};
pub use envelopes::Envelopes;
pub(crate) use manifest::features;
pub use manifest::{Build, Manifest, ManifestError, Unit, WaterFace};
pub use spectra::{RunSpectra, SPECTRAL_DAMPING, periods};
pub use summary::{Quantity, Summary};
