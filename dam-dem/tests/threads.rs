//! A large mesh on several threads.

use crate::support;

use std::num::NonZeroUsize;

use cofferdam_dam::{DamError, DamParameters, Damping, DampingFrequencies};
use cofferdam_unit::CoSimulation;

/// With elements and nodes in parts, results are the same, bit for bit, with any number of threads, including
/// the energies.
#[test]
fn a_large_dam_moves_alike_on_any_number_of_threads() -> Result<(), DamError> {
    let frequencies = DampingFrequencies::RadiansPerSecond([19.0, 95.0]);
    let damping = Damping::Rayleigh { ratio: 0.05, frequencies };
    let dam = support::at_rest(DamParameters { damping, ..support::koyna(0.7) })?;
    assert!(dam.element_count() > 20_000, "{} elements make one part only", dam.element_count());
    let mut states = Vec::new();
    for threads in [1, 2, 3] {
        let mut dam = dam.clone().on_threads(NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN))?;
        support::shake(&mut dam, 1e-3, 2e-3, |time| 4e3 * time)?;
        states.push(dam.save_state());
    }
    assert!(states[0] != dam.save_state() && states.iter().all(|state| *state == states[0]));
    Ok(())
}
