//! From a scene to units, interfaces and observers.

pub mod build_info;
pub mod cache;
pub mod interface_work;
pub mod log;
pub mod observer;
pub mod packing;
pub mod participant;
pub mod registry;
pub mod simulation;
pub mod units;
pub mod vtk;
