//! From a scene to units, interfaces and observers: [`read_scene`], then [`Assembly`].
//!
//! ```
//! use cofferdam_assembly::simulation::simulation_of;
//! use cofferdam_assembly::{Assembly, read_scene};
//! use cofferdam_coupling::observer::Status;
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//!
//! let loaded = read_scene(Path::new("../../scenes/rigid-dam-ramp"), &["time.duration=0.1".to_owned()])?;
//! let graph = Assembly::of(&loaded.scene).graph()?; // both units, in this process
//! let mut simulation = simulation_of(&loaded.scene, &loaded.ground_motion, graph)?;
//! let (ending, failure) = simulation.run(&mut [], &AtomicBool::new(false));
//! assert!(failure.is_none() && ending.status == Status::Completed && ending.time == 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod assembly;
pub mod build_info;
pub mod cache;
pub mod ground;
pub mod interface_work;
pub mod log;
pub mod observer;
pub mod packing;
pub mod participant;
pub mod simulation;
pub mod units;
pub mod vtk;

pub use assembly::{
    Assembly, AssemblyError, Equilibrium, Home, JointStability, Making, UpliftEffect, Verdict, WaterMass,
    read_scene,
};
pub use cofferdam_dam::stability::{Authority, DCR, DcrCriterion, LoadCombination, Status, Zone};
pub use cofferdam_dam::uplift::UpliftRule;
pub use cofferdam_dam::{Flutter, LimitEquilibrium, LimitingPart, Mesh, NaturalModes, PartKind, Quality};
pub use cofferdam_reservoir::paper::{FarEndCondition, ShortWindows};
