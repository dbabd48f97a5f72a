//! Hydrodynamic pressure of compressible reservoir water on a dam, by boundary elements.
//!
//! ```
//! use cofferdam_reservoir::{Fidelity, ReservoirError, ReservoirParameters, added_mass, analytical::westergaard_1933};
//!
//! // Incompressible water, 100 m deep, before a vertical face that moves into it with 1 m/s².
//! let water = ReservoirParameters { fidelity: Fidelity::Incompressible, ..Default::default() };
//! let pressure: Vec<f64> = added_mass(&water)?.row_iter().map(|row| row.sum()).collect();
//!
//! // Westergaard's series, at the heel: 74 kPa.
//! let exact = water.density * westergaard_1933::series_pressure(water.wet_face.depth(), 0.0);
//! assert!((pressure[0] / exact - 1.0).abs() < 0.01);
//! # Ok::<(), ReservoirError>(())
//! ```
//!
//! ```text
//!   y ↑
//!   h │~~~~~ p = 0 or ∂p/∂n = −(s²/g) p ~~~~~┐  water level
//!     │                                      │
//!  far│           ∇²p = (s/c)² p             │ → n   wet face: ∂p/∂n = −ρ s v
//!  end│                                      │
//!     └──────────────╲                       │
//!                     ╲______________________│──→ x
//!    −L     bed: ∂p/∂n = −ρ s v − q s p       0 heel
//! ```
//!
//! **Equations**, in the Laplace domain (`e^{st}`, Re s ≥ 0, s = iω a real frequency; n out of the water, into the
//! dam; p the excess over hydrostatic, positive in compression; v the velocity of face or ground along n):
//!
//! - water `∇²p = (s/c)² p`, compressible, inviscid, small motions;
//! - free surface `p = 0`, by an image source ([`kernel::FreeSurface`]), or with gravity waves `∂p/∂n = −(s²/g) p`, meshed;
//! - bed `∂p/∂n = −ρ s v − q s p`, `q = (1 − α)/((1 + α)c)`, a polygon from the heel upstream, level from its last corner
//!   on, with the wave reflection coefficient α;
//! - wet face `∂p/∂n = −ρ s v`, a polygon from the heel up to the water level;
//! - far end `∂p/∂n = −T (p − p₁)`: outgoing waves of a channel of constant depth, modal and exact; p₁ the channel's own
//!   plane wave under vertical motion of the ground.
//!
//! **Space.** Direct collocation with discontinuous linear or constant elements ([`BoundaryMesh`] of an [`Outline`])
//! gives the symbol K(s), interface pressure for a unit interface velocity and a unit velocity of the ground
//! ([`BoundarySystem`], [`frequency_response()`]), and the pressure inside ([`field_response()`]).
//! The interface points are independent of the elements: the velocity, linear along panels, is
//! projected onto the elements, and their pressure back onto the points, so that the power is the same for both.
//!
//! **Time.** Convolution quadrature with the two-stage Radau IIA method turns K(s) into weights,
//! `p_n = Σ_j W_{n−j} v_j` at the ends of the communication steps, v linear within a step. The sum
//! is evaluated in blocks; all saved states share its history ([`Reservoir`]). Elements should
//! not be much longer than 2 cH: otherwise waves are excited that the mesh cannot represent.
//!
//! **Whole records.** A motion that is known beforehand needs no time steps: [`pressure_of_record`] takes a damped Fourier
//! transform of the whole record.
//!
//! **Finite elements**, for comparison with the boundary elements: the near field in quadratic triangles, a Sommerfeld
//! end, Newmark's method ([`FiniteElements`]). For pictures of a run the same elements, with the channel's recursion upstream, give the
//! pressure inside the water in time ([`PressureField`]).
//!
//! **Without memory.** `p = −A a` ([`added_mass()`], [`ground_added_mass()`]), for communication steps of any length.
//! Incompressible water, `∇²p = 0`, needs one solve of the same system, at s = 0; Westergaard's parabola is a formula.
//!
//! **Assumptions.** Plane section, linear water, ground that moves as one, constant depth upstream of the far end.

mod added_mass;
pub mod analytical;
mod boundary;
mod channel_motion;
mod condition;
mod convolution;
mod cut_off;
mod element_order;
mod error;
mod fidelity;
mod field_response;
mod finite_elements;
mod frequency_response;
pub mod kernel;
mod method;
mod operator;
mod outline;
pub mod paper;
mod parameters;
mod projection;
mod quadrature;
mod radiation;
mod rational;
mod reservoir;
mod system;
mod time_domain;
mod water;
mod whole_record;

pub use added_mass::{added_mass, ground_added_mass};
pub use boundary::{BoundaryMesh, Element};
pub use condition::BoundaryCondition;
pub use element_order::ElementOrder;
pub use error::ReservoirError;
pub use fidelity::{Fidelity, Profile};
pub use field_response::field_response;
pub use finite_elements::{FarEnd, FiniteElements, Prepared, PressureField};
pub use frequency_response::{frequency_response, usual_frequencies};
pub use method::Method;
pub use num_complex::Complex64;
pub use outline::{Outline, Piece};
pub use parameters::ReservoirParameters;
pub use reservoir::{Reservoir, ReservoirState};
pub use system::{BoundarySystem, boundary_system};
pub use water::Water;
pub use whole_record::pressure_of_record;
