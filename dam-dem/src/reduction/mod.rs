//! Reduced models: modes between contacts, with fewer unknowns and longer time steps.
//!
//! **Blocks** (Craig and Bampton 1968). The displacement of a block is
//!
//! ```text
//! u = Ψ u_Γ + Φ q + R r
//! ```
//!
//! with the static shapes Ψ for unit displacements u_Γ of the nodes on its cracks, its lowest modes Φ with
//! these nodes held, and the part R of the static responses to ground acceleration, weight and water that Ψ
//! and Φ do not contain (static correction). In this basis the eigenvalue problem of the block's stiffness
//! and mass matrices is solved again. With added mass, which couples the blocks, it is solved for the whole
//! dam. The resulting modes are coupled by contacts only:
//!
//! ```text
//! q̈ + 2ξω q̇ + ω² q = φᵀ (F + F_contact(u_Γ, u̇_Γ))
//! ```
//!
//! **Damping** of each mode is that of the damping matrix, at most critical. If added mass couples the modes,
//! mass damping also acts between modes, except for fast modes.
//!
//! **Fast modes**: a mode faster than five times the highest excitation frequency responds statically. It
//! keeps its stiffness and gets a larger mass, so that its frequency is reduced to this limit, with at most
//! critical damping. In this way contacts keep the flexibility of the concrete behind them, and fast modes do
//! not limit the time step.
//!
//! **Number of modes**: given, or determined by an estimate of the truncation error.
//!
//! **Valid** for small strains; free blocks may slide and rotate by large amounts
//! ([`Kinematics::Corotational`](crate::Kinematics)). Stiffness of contacts, search along the crack, friction
//! and dashpots are those of [`contact`](crate::contact).
//!
//! **Source**: R.R. Craig, M.C.C. Bampton, *Coupling of substructures for dynamic analyses*, AIAA Journal 6 (1968);
//! tested in `tests/reduction.rs`.

mod advance;
mod basis;
mod flutter;
mod mode;
mod motion;
mod product;
mod release;
mod sides;
mod superposition;

pub(crate) use advance::ModalLoadPath;
pub(crate) use flutter::Sliding;
pub(crate) use mode::HIGHEST_REPRESENTED;
pub use motion::ModalMotion;
pub use superposition::Superposition;
