//! From a scene to units, interfaces and observers: [`read_scene`], then [`Assembly`].

mod assembly;
pub mod build_info;
pub mod cache;
pub mod interface_work;
pub mod log;
pub mod observer;
pub mod packing;
pub mod participant;
pub mod simulation;
pub mod units;
pub mod vtk;

pub use assembly::{Assembly, AssemblyError, Equilibrium, Home, Making, UpliftEffect, WaterMass, read_scene};
pub use cofferdam_dam::{Flutter, LimitEquilibrium, LimitingPart, Mesh, NaturalModes, PartKind, Quality};
pub use cofferdam_reservoir::paper::{FarEndCondition, ShortWindows};
