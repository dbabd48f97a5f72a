//! FMUs as units ([`import`], FMI 2.0 and 3.0), units as FMUs ([`export`], FMI 3.0), and folders from which to make a unit of your
//! own ([`template`]).
//!
//! ```
//! use cofferdam_fmi::export::contract;
//! use cofferdam_reservoir::{Reservoir, ReservoirParameters};
//!
//! // The contract of the reservoir as FMI XML; its parameters are unbounded here.
//! let xml = contract::<Reservoir>(&ReservoirParameters::default(), |_, _| [None; 2])?;
//! assert!(xml.contains("fmiVersion=\"3.0\"") && xml.contains("interface_pressure"));
//! # Ok::<(), cofferdam_fmi::export::FmuError>(())
//! ```

pub mod export;
pub mod import;
pub mod template;
