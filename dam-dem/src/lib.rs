//! A concrete gravity dam, cut by horizontal cracks into deformable blocks, in time.
//!
//! ```text
//!        y ↑        crest
//!          ┌────────┐
//!  water   │ block 1│         u: displacement relative to the ground
//!  level ▽ │        │         n: unit normal of the wet face, into the dam
//!  ~~~~~~~~│→ n     │
//!          ╞════════╡  crack  contacts: nodes of either side against the other's segments
//!          │ block 0 \
//!          │          \
//!  ────────┴───────────┴──→ x downstream
//!        heel         toe     base fixed to the ground, which moves with a_g
//! ```
//!
//! **Equations**, per metre of dam, in the frame of the ground (exact for a base that moves as one):
//!
//! ```text
//! M ü + α M u̇ + F_int(u, u̇) = F_weight + B (p_hydrostatic + p) − M a_g
//! ```
//!
//! - *Elements*: constant-strain triangles, four to a quadrilateral cell, lumped masses, plane
//!   stress or strain, small-strain or corotational ([`element`]).
//! - *Contacts*: springs and dashpots without tension, Coulomb friction ([`contact`]).
//! - *Damping*: of mass, of stiffness, Rayleigh's `α M + β K`, or local; β in elements and contacts ([`Damping`]).
//! - *Fidelity*: all of this, or modes of blocks between contacts, rigid blocks, modes of the intact dam
//!   ([`Fidelity`], [`reduction`]).
//! - *Time*: central differences, explicit, as many time steps in a communication step as stability
//!   asks for ([`integrator`], [`CriticalTimeStep`]). Pressure and a_g are linear over the step.
//! - *Water without memory* may be part of the mass matrix ([`AddedMass`]): `M + X` in the place of M above but
//!   in `α M`; p then is what acts beside it.
//! - *Rest*: weight and hydrostatic pressure are in equilibrium before time 0
//!   ([`integrator::DynamicRelaxation`]). Displacement, sliding, rotation and energy count from there.
//! - *Energy*: every kind of work and energy is counted on its own ([`energy`]).
//!
//! **Conventions.** SI units; pressure and contact stress positive in compression; rotations
//! counter-clockwise; sliding positive when the upper side moves downstream. Cracks and blocks
//! are numbered from the base up.
//!
//! **Assumptions.** Linear elastic, uncracked concrete between given cracks; no water in the cracks;
//! pressure acts on the wet face's unloaded geometry; rigid ground without interaction. Residual
//! sliding depends on the damping model more than on anything else: name it with every result.
//!
//! [`Dam`] is the co-simulation unit. The layers beneath know nothing of coupling: [`Mesh`],
//! [`Structure`], [`integrator::CentralDifference`] also build bars and sliding blocks.

mod added_mass;
pub mod analytical;
mod base;
mod block;
pub mod contact;
mod dam;
mod damping;
pub mod element;
pub mod energy;
mod error;
mod fidelity;
pub mod integrator;
pub mod loads;
mod material;
mod mesh;
pub mod modal;
mod model;
mod parameters;
pub mod reduction;
mod state;
mod stress;
mod structure;
mod system_matrices;
mod time_step;

pub use added_mass::AddedMass;
pub use block::{Block, best_fit_rotation};
pub use dam::{Dam, InterfaceCompliance};
pub use damping::{Damping, DampingCoefficients, DampingFrequencies, RayleighCoefficients, StiffnessDamping};
pub use error::DamError;
pub use fidelity::Fidelity;
pub use material::{Material, Plane};
pub use mesh::Mesh;
pub use parameters::{CrackParameters, DamParameters, Kinematics, Section};
pub use state::{DamMotion, DamState};
pub use structure::{Motion, Structure};
pub use system_matrices::SystemMatrices;
pub use time_step::CriticalTimeStep;
