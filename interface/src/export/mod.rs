//! Units as FMUs: the C functions of FMI 3.0 for Co-Simulation, for any [`Packable`](crate::Packable) unit.
//!
//! ```text
//! importer ─→ fmi3 (C functions) ─→ Instances ─→ Instance (modes, saved states) ─→ CoSimulation
//!          ←─ Log (messages) ←──────────────────────────────┘
//! ```
//!
//! A library that exports one unit is one line: `interface::export_fmi3!(Unit);`.
//!
//! **Handles.** Instances and saved states are numbers, none used twice while the library is loaded, that are looked
//! up and never dereferenced: a null, freed or foreign handle is an error, not a crash. **Panics** end at the border;
//! the instance refuses every later call but being freed.

mod contents;
mod error;
pub mod fmi3;
mod functions;
mod instance;
mod instances;
mod log;

pub use contents::{Contents, ContentsError, FILE};
pub use error::ExportError;

/// What every library of a unit holds, before the unit's name and a zero: so it is known for what it is.
pub const MARKER: &str = "cofferdam unit: ";

/// The bytes by which the library of the unit `name` is known.
pub const fn marker<const LENGTH: usize>(name: &str) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let (first, _) = bytes.split_at_mut(MARKER.len());
    first.copy_from_slice(MARKER.as_bytes());
    let (_, second) = bytes.split_at_mut(MARKER.len());
    let (second, _) = second.split_at_mut(name.len());
    second.copy_from_slice(name.as_bytes());
    bytes
}
