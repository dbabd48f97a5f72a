//! Couples co-simulation units in a staggered fixed-point iteration.
//!
//! Units are black boxes behind the trait [`participant::Participant`]: y = f(u) over a communication step, with a state that can
//! be saved and restored. They form a [`scheme::Graph`]: at each [`scheme::Interface`] the outputs of a first unit go forward to
//! the inputs of a second, whose outputs come back. Over a step the coupling solves x = G(x), with x the values that come back
//! and G one step of all units:
//!
//! ```text
//! second(first(x)) = x      residual r = G(x) − x      converged when a measure of r is below the tolerance
//! ```
//!
//! A [`scheme::Scheme`] repeats the step from restored states; an [`acceleration`] turns residuals into the next guess; measures
//! of [`convergence`] decide; a [`mapping`] carries fields between points that do not match. [`simulation::Simulation`] takes
//! step after step as [`stepping`] asks and reports every window to [`observer`]s. [`signal`]s from outside, such as a ground
//! acceleration, go to every unit with an input of their name. Nothing here knows what the units model.
//!
//! `examples/two_masses.rs` of the crate `cofferdam-log` couples two masses by a spring, each a unit of its own, and logs, replays
//! and compares the runs.

pub mod acceleration;
pub mod convergence;
pub mod difference;
pub mod mapping;
pub mod observer;
pub mod participant;
pub mod run_state;
pub mod scheme;
pub mod signal;
pub mod simulation;
pub mod stepping;
pub mod temporary;
