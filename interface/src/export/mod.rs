//! Units as FMUs: the C functions of FMI 2.0 and 3.0 for Co-Simulation, for any [`Packable`](crate::Packable) unit.
//!
//! ```text
//! importer ─→ fmi2, fmi3 (C functions) ─→ Instances ─→ Instance (modes, saved states) ─→ CoSimulation
//!          ←─ Log (messages) ←──────────────────────────────┘
//! ```
//!
//! A library that exports one unit is one line: `cofferdam_unit::export_fmi!(Unit);`.
//!
//! **Handles.** The handles of instances and saved states are numbers. They are looked up and never dereferenced, so a
//! null, freed or foreign handle is an error and not a crash. No handle is used twice while the library is loaded.
//! **Panics** do not reach the importer; after one, the instance refuses every call except to be freed.

mod access;
mod contents;
mod error;
pub mod fmi2;
pub mod fmi3;
mod functions;
mod instance;
mod instances;
mod log;
mod pointers;
mod record;
mod types;

pub use contents::{Contents, ContentsError, FILE, PREPARED};
pub use error::ExportError;
pub use instance::{ELEMENTS, element};
pub use log::LOG_CATEGORIES;
pub use record::Record;

/// Text in every library of a unit, followed by the unit's name and a zero byte; it identifies the library.
pub const MARKER: &str = "cofferdam unit: ";

/// The bytes that identify the library of the unit `name`.
pub const fn marker<const LENGTH: usize>(name: &str) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let (first, _) = bytes.split_at_mut(MARKER.len());
    first.copy_from_slice(MARKER.as_bytes());
    let (_, second) = bytes.split_at_mut(MARKER.len());
    let (second, _) = second.split_at_mut(name.len());
    second.copy_from_slice(name.as_bytes());
    bytes
}
