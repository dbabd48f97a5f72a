//! Memory is allocated once in each communication step, never in a time step.

use crate::support;

use allocation_counter::measure;
use cofferdam_dam::{DamError, DamParameters, Fidelity};
use cofferdam_unit::CoSimulation;

#[test]
fn time_steps_allocate_nothing() -> Result<(), DamError> {
    for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }, Fidelity::RigidBlocks] {
        let counts = [0.9, 0.009].map(|safety| -> Result<(usize, u64), DamError> {
            let parameters = DamParameters { fidelity, time_step_safety: safety, ..support::koyna(10.0) };
            let mut dam = support::at_rest(parameters)?;
            support::shake(&mut dam, 2.5e-3, 0.5, support::bursts)?;
            let time = dam.state().time();
            let mut stepped = Ok(());
            let count = measure(|| stepped = dam.step(time, 2.5e-3)).count_total;
            stepped.map(|()| (dam.time_steps_per(2.5e-3), count))
        });
        let [few, many] = counts;
        let ((few, count), (many, same)) = (few?, many?);
        println!("{fidelity:?}: {few} and {many} time steps, {count} and {same} allocations");
        assert!(many > 20 * few && count == same);
    }
    Ok(())
}
