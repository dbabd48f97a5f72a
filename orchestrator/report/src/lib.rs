//! Results of a run: the [`Summary`], the [`Manifest`], and the HTML [`page`]s of a run, of two and of an ensemble.
//!
//! A summary is a list of [`Quantity`]s, each with its unit, time and place.
//!
//! ```
//! use cofferdam_report::{Quantity, Subject, has_both_directions};
//!
//! let peak = |value| Quantity {
//!     name: "peak crest displacement".to_owned(),
//!     subject: Subject::Crest,
//!     value,
//!     unit: "mm".into(),
//!     ..Quantity::default()
//! };
//! let runs = [peak(31.0), peak(-28.0)];
//! // One run peaks downstream and one upstream: between the two there is no peak, so magnitudes are compared.
//! assert!(has_both_directions(&runs[0].name, runs.iter().map(|run| run.value)));
//! ```

mod accuracy;
mod ensemble;
mod envelopes;
mod manifest;
pub mod page;
mod quantity;
mod range;
mod resultant;
mod rounding;
pub mod section;
mod spectra;
pub mod stability;
mod summary;
pub mod text;

pub use accuracy::{Accuracy, PlanRow};
pub use cofferdam_assembly::build_info::Build;
pub use ensemble::{EnsembleManifest, EnsembleRecord, EnsembleVertical, VariedKey};
pub use envelopes::Envelopes;
pub use manifest::{Manifest, ManifestError, Unit, WaterFace};
pub use quantity::{Quantity, Subject, has_both_directions};
pub use range::{
    Combined, FactorKind, FailedRun, LeftOut, RangeError, RangeFactor, RangeQuantity, RangeRecord, Setting,
    Swing, VarianceShare,
};
pub use rounding::{known_digits, percent};
pub use spectra::{RunSpectra, SPECTRAL_DAMPING, periods};
pub use summary::Summary;
