//! The dam's tests, in one program: each file is a module, `cargo test --release -p dam_dem energy::` runs one.

mod added_mass;
mod allocations;
mod cantilever;
mod compliance;
mod contact;
mod convergence;
mod damping;
mod damping_memory;
mod elements;
mod energy;
mod extremes;
mod frames;
mod joint_laws;
mod linear_reference;
mod newmark_1965;
mod outputs;
mod parameters;
mod reduction;
mod rigid_blocks;
mod state;
mod static_start;
mod support;
mod threads;
mod time_step;
mod vibration;
mod waves;
