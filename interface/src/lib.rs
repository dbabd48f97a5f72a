//! The contract between the co-simulation units, in Rust.
//!
//! ```
//! use cofferdam_unit::{
//!     CallError, Capabilities, CoSimulation, Fingerprint, Variable, open, seal, variables::reservoir as variables,
//! };
//!
//! /// Water as a mass per area (kg/m²) at each of some points: `p = −m a`, without memory.
//! struct Water {
//!     mass: Vec<f64>,
//!     /// Acceleration (m/s²) and pressure (Pa) at each point: all that later results depend on.
//!     state: [Vec<f64>; 2],
//! }
//!
//! impl CoSimulation for Water {
//!     type State = [Vec<f64>; 2];
//!     type Error = CallError;
//!
//!     fn name(&self) -> &'static str { "water" }
//!     fn variables(&self) -> &'static [Variable] {
//!         &[variables::INTERFACE_ACCELERATION, variables::INTERFACE_PRESSURE]
//!     }
//!     fn size(&self, _: &Variable) -> usize { self.mass.len() }
//!     fn fingerprint(&self) -> Fingerprint { Fingerprint::of("water", &self.mass).expect("numbers") }
//!     fn capabilities(&self) -> Capabilities {
//!         Capabilities { variable_communication_step: true, directional_derivative: false, saved_state: true }
//!     }
//!     fn initialise(&mut self, _start_time: f64) -> Result<(), CallError> { Ok(()) }
//!     fn set(&mut self, reference: u32, values: &[f64]) -> Result<(), CallError> {
//!         let variable = self.variable(reference)?;
//!         if *variable != variables::INTERFACE_ACCELERATION {
//!             return Err(CallError::NotSettable { unit: self.name(), variable: variable.name });
//!         }
//!         self.check_length(variable, values.len())?;
//!         self.state[0] = values.to_vec();
//!         Ok(())
//!     }
//!     fn step(&mut self, _time: f64, _communication_step: f64) -> Result<(), CallError> {
//!         self.state[1] = self.mass.iter().zip(&self.state[0]).map(|(m, a)| -m * a).collect();
//!         Ok(())
//!     }
//!     fn get(&self, reference: u32, values: &mut [f64]) -> Result<(), CallError> {
//!         let pressure = *self.variable(reference)? == variables::INTERFACE_PRESSURE;
//!         values.copy_from_slice(&self.state[usize::from(pressure)]);
//!         Ok(())
//!     }
//!     fn save_state(&self) -> Self::State { self.state.clone() }
//!     fn restore_state(&mut self, state: &Self::State) -> Result<(), CallError> {
//!         self.state = state.clone();
//!         Ok(())
//!     }
//!     fn serialise_state(&self, state: &Self::State) -> Result<Vec<u8>, CallError> {
//!         Ok(seal(self.fingerprint(), state)?)
//!     }
//!     fn deserialise_state(&self, bytes: &[u8]) -> Result<Self::State, CallError> {
//!         Ok(open(self.fingerprint(), bytes)?)
//!     }
//!     fn directional_derivative(
//!         &self, unknown: u32, known: u32, _: &[f64], _: &mut [f64],
//!     ) -> Result<(), CallError> {
//!         Err(CallError::Derivative { unit: self.name(), unknown, known })
//!     }
//! }
//!
//! let mut water = Water { mass: vec![8.75e4, 0.0], state: [vec![0.0; 2], vec![0.0; 2]] };
//! water.initialise(0.0)?;
//! let start = water.save_state();
//! let mut pressure = [0.0; 2];
//! // An iterative coupling repeats a step from the state at its start.
//! for acceleration in [1.0, 2.0] {
//!     water.restore_state(&start)?;
//!     water.set(variables::INTERFACE_ACCELERATION.value_reference, &[acceleration; 2])?;
//!     water.step(0.0, 0.01)?;
//!     water.get(variables::INTERFACE_PRESSURE.value_reference, &mut pressure)?;
//!     assert_eq!(pressure, [-8.75e4 * acceleration, 0.0]);
//! }
//! # Ok::<(), CallError>(())
//! ```
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
#[cfg(feature = "export")]
pub mod export;
mod messages;
pub mod number;
mod packable;
mod polyline;
mod role;
mod sampled;
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
pub use sampled::sampled;
pub use serialised_state::{Fingerprint, StateError, open, relabel, seal};
pub use units::BaseUnits;
pub use variable::{Causality, DataType, Shape, StructuralParameter, Variability, Variable};
pub use wet_face::{Panel, WetFace, WetFaceError};
