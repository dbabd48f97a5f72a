//! FMUs as units, units as FMUs, and folders from which to make a unit.

pub mod export;
pub mod import;
pub mod template;
