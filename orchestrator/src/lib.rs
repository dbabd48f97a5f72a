//! Couples two co-simulation units and tells the truth about how it went.
//!
//! The orchestrator repeats each communication step, states restored, until what the units
//! exchange agrees to a tolerance, and logs every exchange. It sees units only through
//! [`participant::Participant`] and knows no solver; the binary `cofferdam` brings those.
//!
//! Data flows one way: [`scene`] → [`participant`] → [`scheme`] (with [`acceleration`],
//! judged by [`convergence`]; by a [`mapping`] where points do not match) → [`simulation`] →
//! [`observer`]s ([`log`], histories, progress) → [`report`]. A [`log`] that was written is read
//! again by [`replay`]. Units leave as FMUs by [`fmu`].

pub mod acceleration;
pub mod convergence;
pub mod difference;
pub mod fmu;
pub mod ground_motion;
pub mod log;
pub mod mapping;
mod number;
pub mod observer;
pub mod participant;
pub mod registry;
pub mod replay;
pub mod report;
pub mod scene;
pub mod scheme;
pub mod simulation;
pub mod stepping;
pub mod transport;
pub mod vtk;
