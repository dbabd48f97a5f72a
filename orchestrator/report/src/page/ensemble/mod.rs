//! The report of an ensemble: what `cofferdam ensemble` has left in its folder, on one page.
//!
//! Data flow as for a run: [`EnsembleFolder`] (its files) → [`EnsembleData`] (what is shown) → [`html`].

mod data;
mod document;
mod folder;
mod grid;

pub use data::EnsembleData;
pub use document::html;
pub use folder::{EnsembleFolder, Table};
pub use grid::{Cell, Grid};
