//! Units as FMUs: the C functions of FMI 3.0 for Co-Simulation, for any [`Packable`](crate::Packable) unit.
//!
//! ```text
//! importer ─→ fmi3 (C functions) ─→ Instances ─→ Instance (modes, saved states) ─→ CoSimulation
//!          ←─ Log (messages) ←──────────────────────────────┘
//! ```
//!
//! A library that exports one unit is one line: `interface::export_fmi3!(Unit);`.
//!
//! **Handles.** Instances and saved states are numbers that are never used twice, looked up and never
//! dereferenced: a null, freed or foreign handle is an error, not a crash. **Panics** end at the border;
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
