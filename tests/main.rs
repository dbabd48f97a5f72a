//! Tests that need more than one crate, in one program: each file is a module, `cargo test --release -p whole-chain log::`
//! runs one.

mod added_mass;
mod bad_input;
mod contract;
mod dependencies;
mod elastic_tube_1d;
mod empty_reservoir;
mod export_fmu;
mod faults;
mod frequency_domain;
mod fuzz;
mod iterations;
mod log;
mod order_in_communication_step;
mod participants;
mod partitioned_monolithic;
mod platform;
mod processes;
mod protocol;
mod python;
mod replay_of_schemes;
mod reservoir_command;
mod rigid_dam_ramp;
mod run;
mod scene_mistakes;
mod scene_reference;
mod schemes;
mod states;
mod studies;
mod three_units;
mod two_masses;
mod westergaard_in_the_dam;
