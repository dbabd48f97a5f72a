//! What a run says at its end.

mod accuracy;
mod ensemble;
mod envelopes;
mod manifest;
pub mod page;
mod quantity;
pub mod section;
mod spectra;
mod summary;
pub mod text;

pub use accuracy::{Accuracy, PlanRow};
pub use cofferdam_assembly::build_info::Build;
pub use ensemble::{EnsembleManifest, EnsembleRecord, VariedKey};
pub use envelopes::Envelopes;
pub use manifest::{Manifest, ManifestError, Unit, WaterFace};
pub use quantity::{Quantity, Subject, has_both_directions};
pub use spectra::{RunSpectra, SPECTRAL_DAMPING, periods};
pub use summary::Summary;
