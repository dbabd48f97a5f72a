//! Hydrodynamic pressure of compressible reservoir water on a dam, by boundary elements.
//!
//! ```text
//!   y ↑
//!   h │~~~~~~~~~~~ p = 0 ~~~~~~~~~~~~┐  water level
//!     │                             │
//!  far│        ∇²p = (s/c)² p       │ → n   wet face: ∂p/∂n = −ρ s v
//!  end│                             │
//!   0 └─────────────────────────────┘──→ x
//!    −L    bed: ∂p/∂n = −q s p       0 heel
//! ```
//!
//! **Equations**, in the Laplace domain (`e^{st}`, Re s > 0; n out of the water, into the dam;
//! p the excess over hydrostatic, positive in compression; v the velocity of the face along n):
//!
//! - water `∇²p = (s/c)² p`, compressible, inviscid, small motions;
//! - free surface `p = 0`, by an image source ([`kernel::FreeSurface`]): gravity waves are neglected;
//! - bed `∂p/∂n = −q s p`, `q = (1 − α)/((1 + α)c)`, flat, with the wave reflection coefficient α;
//! - wet face `∂p/∂n = −ρ s v`, a polygon from the heel up to the water level;
//! - far end `∂p/∂n = −T p`: outgoing waves of a channel of constant depth, modal and exact.
//!
//! **Space.** Direct collocation with discontinuous linear elements gives the symbol K(s),
//! interface pressure for a unit interface velocity ([`BoundarySystem`], [`frequency_response()`]).
//! The interface points are independent of the elements: velocity, linear along panels, is
//! projected onto the elements; pressure is evaluated at the points by the representation formula.
//!
//! **Time.** Convolution quadrature with the two-stage Radau IIA method turns K(s) into weights,
//! `p_n = Σ_j W_{n−j} v_j` at the ends of the communication steps, v linear within a step. The sum
//! is evaluated in blocks, its history shared by all saved states ([`Reservoir`]). Elements should
//! not be much longer than 2 cH: shorter waves would be excited that the mesh cannot carry.
//!
//! **Without memory.** Incompressible water, `∇²p = 0`, is one solve of the same system, at s = 0,
//! Westergaard's parabola a formula: `p = −A a` ([`added_mass()`]), for communication steps of any length.
//!
//! **Assumptions.** Plane section, linear water, horizontal ground motion (the flat bed then does
//! not move along its normal), constant depth upstream of the far end.

mod added_mass;
pub mod analytical;
mod boundary;
mod condition;
mod convolution;
mod error;
mod fidelity;
mod frequency_response;
pub mod kernel;
mod operator;
mod parameters;
mod quadrature;
mod radiation;
mod reservoir;
mod system;

pub use added_mass::added_mass;
pub use boundary::{BoundaryMesh, Element};
pub use condition::BoundaryCondition;
pub use error::ReservoirError;
pub use fidelity::Fidelity;
pub use frequency_response::frequency_response;
pub use num_complex::Complex64;
pub use parameters::ReservoirParameters;
pub use reservoir::{Reservoir, ReservoirState};
pub use system::{BoundarySystem, Water};
