//! The dam by modes between contacts: fewer unknowns, longer time steps.
//!
//! **Blocks** (Craig and Bampton 1968). A block moves by
//!
//! ```text
//! u = Ψ u_Γ + Φ q + R r
//! ```
//!
//! with the static shapes Ψ under the displacements u_Γ of the nodes on its cracks, its lowest modes Φ with these nodes
//! held, and what the static answers R to ground acceleration, weight and water add to both: the static
//! correction. On this basis the eigenvalue problem of the block's stiffness and mass matrices, the water's in the dam
//! included, is solved once more; the modes that come out stand alone but for the contacts:
//!
//! ```text
//! q̈ + 2ξω q̇ + ω² q = φᵀ (F + F_contact(u_Γ, u̇_Γ))
//! ```
//!
//! **Damping** of each mode is that of the matrices, at most critical; the water's part in mass damping is left to the
//! diagonal. **Slow modes only**: a mode faster than five times the highest excitation answers statically. It keeps its
//! stiffness and gets the mass, with critical damping at most, that brings it down to that frequency: contacts stay as
//! soft as the concrete makes them, and the time step follows from motion that matters.
//!
//! **Number of modes**: from a bound on what is left out, or given.
//!
//! **Valid** for small strains; free blocks may slide and turn far ([`Kinematics::Corotational`](crate::Kinematics)).
//! Stiffness of contacts, search along the crack, friction and dashpots are those of [`contact`](crate::contact).
//!
//! **Source**: R.R. Craig, M.C.C. Bampton, *Coupling of substructures for dynamic analyses*, AIAA Journal 6 (1968);
//! tested in `tests/reduction.rs`.

mod advance;
mod basis;
mod mode;
mod motion;
mod sides;
mod superposition;

pub(crate) use advance::ModalLoadPath;
pub use motion::ModalMotion;
pub use superposition::Superposition;
