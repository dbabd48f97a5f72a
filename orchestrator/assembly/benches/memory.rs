//! Memory of the reservoir by its models and methods: `cargo bench -p cofferdam-assembly --bench memory`.
//!
//! The water of the main scene: 91.75 m deep, 18 panels of the wet face, α = 0.9, 25 s in steps of 2.5 ms. Bytes are those
//! that are allocated: by the unit at rest, by one saved state, and at most while a frequency is assembled and solved.
//! A counting allocator measures them; it costs two atomic operations an allocation, so that only this program has it.

use cofferdam_reservoir::{Complex64, Fidelity, Method, Reservoir, ReservoirParameters, boundary_system};
use cofferdam_unit::{CoSimulation, WetFace};
use peak_alloc::PeakAlloc;
use std::error::Error;
use std::num::NonZeroUsize;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const DEPTH: f64 = 91.75;

fn main() -> Result<(), Box<dyn Error>> {
    let water = ReservoirParameters {
        wave_reflection_coefficient: 0.9,
        communication_step: 0.0025,
        horizon: 25.0,
        ..ReservoirParameters::before(WetFace::straight([0.0, DEPTH], 18)?)
    };
    println!("{:<20} {:>10} {:>16}", "water", "unit, MB", "saved state, kB");
    let models = [
        ("Westergaard", Fidelity::Westergaard, Method::default()),
        ("incompressible", Fidelity::Incompressible, Method::default()),
        ("finite elements", Fidelity::Compressible, Method::FiniteElements),
        ("recursion", Fidelity::Compressible, Method::Recursive),
        ("Radau, 2 stages", Fidelity::Compressible, Method::Radau2),
    ];
    for (name, fidelity, method) in models {
        let parameters = ReservoirParameters { fidelity, method, ..water.clone() };
        let before = MEMORY.current_usage();
        let mut unit = Reservoir::new(parameters, NonZeroUsize::MIN)?;
        unit.initialise(0.0)?;
        let at_rest = MEMORY.current_usage();
        let state = unit.save_state();
        let [unit, saved] = [at_rest - before, MEMORY.current_usage() - at_rest];
        drop(state);
        println!("{name:<20} {:>10.3} {:>16.1}", unit as f64 / 1e6, saved as f64 / 1e3);
    }
    println!("\n{:<20} {:>10}", "elements of the face", "at most, MB");
    for elements in [8, 16, 32, 64, 128, 256] {
        let system = boundary_system(&ReservoirParameters {
            element_size: DEPTH / f64::from(elements),
            ..water.clone()
        })?;
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        system.symbol(Complex64::new(0.0, 30.0))?;
        println!("{elements:<20} {:>10.2}", (MEMORY.peak_usage() - before) as f64 / 1e6);
    }
    Ok(())
}
