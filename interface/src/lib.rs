//! The contract between the co-simulation units, in Rust.
//!
//! Two units are coupled: the *reservoir* (water) and the *dam* (concrete). Each
//! implements [`CoSimulation`]. [`variables`] lists what they exchange, one item per variable;
//! the XML in `modelDescription/`, for importers, is generated from it.
//!
//! ```text
//!            y ↑            crest
//!   water level ┌───────┬──┐
//!   ~~~~~~~~~~~~│       │  │        x downstream, y up, origin at the heel
//!   water, x<0  │→ n    │  │        n: unit normal out of the water, into the dam
//!               │       dam \
//!   ────────────┴────────────┴──→ x
//!             heel          toe
//! ```
//!
//! **Conventions.** SI units, everything per metre of dam. Pressure is the excess over
//! hydrostatic, positive in compression; its traction on the dam is `p n`. Acceleration
//! is total (relative + ground) along `n`, so the water obeys `∂p/∂n = −ρ a_n`.
//!
//! **One communication step** from t to t + H: inputs are set *for t + H*, the unit keeps
//! the accepted inputs at t, and its outputs are those at t + H. Pressure and ground
//! acceleration vary linearly over the step. `interface_acceleration` is the mean over the step,
//! (v(t+H) − v(t))/H, and is constant within it, so that velocity is linear and the exchanged impulse exact.
//! Where a value at t + H is needed, it is [`EndAcceleration`].

mod co_simulation;
mod digest;
mod end_value;
pub mod export;
mod messages;
pub mod number;
mod packable;
mod polyline;
mod role;
mod serialised_state;
mod units;
mod variable;
pub mod variables;
mod wet_face;

pub use co_simulation::{CallError, Capabilities, CoSimulation, Stage, at_places, get_all_at};
pub use digest::sha256;
pub use end_value::EndAcceleration;
pub use messages::{Level, Messages};
pub use packable::Packable;
pub use polyline::mean_elevation;
pub use role::Role;
pub use serialised_state::{Fingerprint, StateError, open, relabel, seal};
pub use units::BaseUnits;
pub use variable::{Causality, Shape, StructuralParameter, Variability, Variable};
pub use wet_face::{Panel, WetFace, WetFaceError};
