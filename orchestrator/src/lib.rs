//! Couples two co-simulation units and reports how well they agreed.
//!
//! The orchestrator repeats each communication step from restored states until the exchanged values agree to a
//! tolerance. It logs every exchange. It uses units only through [`participant::Participant`] and does not depend on
//! a solver; the binary `cofferdam` supplies the solvers.
//!
//! Data flows one way: [`scene`] → [`participant`] → [`scheme`] (with [`acceleration`], checked by [`convergence`];
//! through a [`mapping`] where the points do not match) → [`simulation`] → [`observer`]s ([`log`], histories,
//! progress) → [`report`]. [`replay`] reads a [`log`] and repeats its requests. [`fmu`] packs units as FMUs.

pub mod acceleration;
mod background;
pub mod cache;
pub mod convergence;
pub mod difference;
pub mod fmu;
pub mod ground_motion;
pub mod log;
pub mod mapping;
pub mod mesh_file;
pub mod observer;
pub mod participant;
pub mod registry;
pub mod replay;
pub mod report;
mod results_file;
pub mod run_state;
pub mod scene;
pub mod scheme;
pub mod simulation;
pub mod statistics;
pub mod stepping;
mod text_file;
pub mod transport;
pub mod vtk;
