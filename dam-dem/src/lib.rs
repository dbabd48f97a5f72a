//! Motion over time of a concrete gravity dam that cracks divide into deformable blocks.
//!
//! ```
//! use cofferdam_dam::{Dam, DamError, DamParameters, Material};
//!
//! // Koyna Dam, the default section, without its crack.
//! let material = Material { young_modulus: 31.027e9, poisson_ratio: 0.15, density: 2643.0, ..Default::default() };
//! let dam = Dam::new(DamParameters { material, cracks: Vec::new(), ..Default::default() })?;
//!
//! // Chopra and Chakrabarti (1973): ω₁ = 18.86 rad/s.
//! let first = dam.natural_frequencies(1)?[0];
//! assert!((first / 18.86 - 1.0).abs() < 0.035);
//! # Ok::<(), DamError>(())
//! ```
//!
//! ```text
//!        y ↑        crest
//!          ┌────────┐
//!  water   │ block 1│         u: displacement relative to the ground
//!  level ▽ │        │         n: unit normal of the wet face, into the dam
//!  ~~~~~~~~│→ n     │
//!          ╞════════╡  crack  contacts: points of either side against the other's segments
//!          │ block 0 \
//!          │          \
//!  ────────┴───────────┴──→ x downstream
//!        heel         toe     base fixed to the ground, which moves with a_g
//! ```
//!
//! **Equations**, per metre of dam, relative to the ground (exact if all points of the base move alike):
//!
//! ```text
//! M ü + α M u̇ + F_int(u, u̇) = F_weight + F_static + F_uplift + B (p_hydrostatic + p) − M a_g
//! ```
//!
//! - *Elements*: constant-strain triangles, four to a quadrilateral cell, lumped masses, plane
//!   stress or strain, small-strain or corotational ([`element`]).
//! - *Blocks* follow from the cracks, which run in any direction, along the base too ([`Mesh`]).
//! - *Contacts*: springs and dashpots without tension, with Coulomb friction, along the cracks and, at full
//!   fidelity, wherever blocks meet ([`contact`]).
//! - *Damping*: proportional to mass, to stiffness, or to both (Rayleigh, `α M + β K`), or local; β acts in
//!   elements and contacts ([`Damping`]).
//! - *Fidelity*: the full model, or modes of blocks between contacts, rigid blocks, or modes of the intact dam
//!   ([`Fidelity`], [`reduction`]).
//! - *Time*: explicit central differences; stability determines the number of time steps in a communication step
//!   ([`integrator`], [`CriticalTimeStep`]). Pressure and a_g vary linearly over the communication step.
//! - *Added mass* of water without memory may be part of the mass matrix ([`AddedMass`]): `M + X` replaces M above,
//!   except in `α M`; p is then the pressure in addition to that of the added mass.
//! - *State of rest*: weight and hydrostatic pressure are in equilibrium before time 0
//!   ([`integrator::SparseNewton`], [`integrator::DynamicRelaxation`]). Displacement, sliding, rotation and
//!   energy are relative to this state.
//! - *Energy*: every kind of work and energy is computed separately ([`energy`]).
//! - *Uplift*: the water in cracks presses their sides apart; where they are open, by a rule ([`uplift`]). Contacts carry the
//!   effective stress.
//! - *Stability* by the gravity method, without motion ([`stability`]).
//!
//! **Conventions.** SI units; pressure and contact stress are positive in compression, rotations positive
//! counter-clockwise; sliding is positive when the upper side moves downstream. Cracks are numbered from the base up, by their
//! mean elevations.
//!
//! **Assumptions.** The concrete between the given cracks is linear elastic and does not crack. Pressure acts on the unloaded
//! geometry of wet faces and cracks. The ground is rigid and does
//! not interact. Residual sliding depends mostly on the damping model: state the model with every result.
//!
//! [`Dam`] is the co-simulation unit. The layers below it do not depend on the coupling: [`Mesh`],
//! [`Structure`] and [`integrator::CentralDifference`] can also model bars and sliding blocks.

mod above;
mod added_mass;
pub mod analytical;
mod base;
mod block;
pub mod contact;
mod dam;
mod damping;
pub mod element;
pub mod energy;
mod envelope;
mod error;
mod fidelity;
mod flutter;
pub mod integrator;
mod kinematics;
mod lanes;
mod limit_equilibrium;
mod limiting_part;
mod load_basis;
pub mod loads;
mod material;
mod mesh;
pub mod modal;
mod modal_field;
mod model;
mod natural_modes;
mod parameters;
mod real;
mod recovery;
pub mod reduction;
mod release;
mod section;
pub mod stability;
mod state;
mod stress;
mod structure;
mod system_matrices;
mod time_step;
pub mod uplift;
mod wet;

pub use added_mass::AddedMass;
pub use block::{Block, best_fit_rotation};
pub use dam::{Dam, InterfaceCompliance, JointAtRest};
pub use damping::{
    Damping, DampingCoefficients, DampingFrequencies, DampingModel, RayleighCoefficients, StiffnessDamping,
};
pub use error::{DamError, Problem};
pub use fidelity::{Fidelity, FidelityLevel};
pub use flutter::Flutter;
pub use kinematics::Kinematics;
pub use limit_equilibrium::LimitEquilibrium;
pub use limiting_part::{LimitingPart, PartKind};
pub use material::{Material, Materials, Plane};
pub use mesh::{Feature, Geometry, GeometryError, GivenMesh, GivenMeshError, Mesh, Quality, Seam};
pub use natural_modes::NaturalModes;
pub use parameters::{CrackLine, CrackParameters, DamParameters, ZoneParameters};
pub use recovery::StressRecovery;
pub use section::Section;
pub use state::{DamMotion, DamState};
pub use structure::{Motion, Structure};
pub use system_matrices::SystemMatrices;
pub use time_step::CriticalTimeStep;
