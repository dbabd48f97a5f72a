//! Saved states.

use crate::support;

use cofferdam_dam::contact::Integration;
use cofferdam_dam::{CrackParameters, Dam, DamError, DamParameters, Damping, DampingFrequencies, Fidelity};
use cofferdam_unit::{CallError, CoSimulation, Fingerprint, StateError, variables::dam as variable};
use proptest::prelude::*;

/// Bits of all outputs.
fn outputs(dam: &Dam) -> Vec<u64> {
    dam.variables().iter().flat_map(|v| support::get(dam, v)).map(f64::to_bits).collect()
}

fn sliding_dam() -> Result<Dam, DamError> {
    let mut dam = support::at_rest(support::koyna(7.0))?;
    support::shake(&mut dam, 2.5e-3, 1.25, support::bursts)?;
    Ok(dam)
}

#[test]
fn a_repeated_step_gives_the_same_bits() -> Result<(), DamError> {
    let mut dam = sliding_dam()?;
    let slipping = support::get(&dam, &variable::CRACK_SLIDING)[0];
    assert!(slipping.abs() > 1e-3, "the block must slide: {slipping}");
    let saved = dam.save_state();
    let kept = saved.clone();
    let push = vec![2e4; dam.wet_face().map_or(0, |face| face.len())];
    let go = |dam: &mut Dam| -> Result<Vec<u64>, DamError> {
        dam.set(variable::INTERFACE_PRESSURE.value_reference, &push)?;
        support::shake(dam, 2.5e-3, dam.state().time() + 0.05, support::bursts)?;
        Ok(outputs(dam))
    };
    let first = go(&mut dam)?;
    dam.restore_state(&saved)?;
    assert_eq!(first, go(&mut dam)?);
    assert_eq!(saved, kept);

    let mut fresh = Dam::new(support::koyna(7.0))?;
    let bytes = dam.serialise_state(&saved)?;
    fresh.restore_state(&fresh.deserialise_state(&bytes)?)?;
    assert_eq!(first, go(&mut fresh)?);
    println!("20 steps from a state at slip {slipping:.4} m: bit-equal, restored and in a fresh dam");
    Ok(())
}

#[test]
fn a_state_does_not_grow() -> Result<(), DamError> {
    let mut dam = support::at_rest(support::koyna(7.0))?;
    let start = dam.serialise_state(&dam.save_state())?.len();
    support::shake(&mut dam, 2.5e-3, 1.0, support::bursts)?;
    let end = dam.serialise_state(&dam.save_state())?.len();
    println!("serialised state: {start} bytes at time 0, {end} bytes after 400 steps");
    assert_eq!(start, end);
    Ok(())
}

#[test]
fn foreign_states_are_refused() -> Result<(), DamError> {
    let dam = support::at_rest(support::koyna(10.0))?;
    let bytes = dam.serialise_state(&dam.save_state())?;
    let mut other = Dam::new(DamParameters { gravity: 9.8, ..support::koyna(10.0) })?;
    assert!(matches!(other.deserialise_state(&bytes), Err(DamError::State(StateError::Fingerprint { .. }))));
    let mut finer = Dam::new(support::koyna(7.0))?;
    for foreign in [&mut finer, &mut other] {
        let refused = foreign.restore_state(&dam.save_state());
        assert!(matches!(refused, Err(DamError::State(StateError::Fingerprint { .. }))), "{refused:?}");
    }
    Ok(())
}

#[test]
fn calls_out_of_order_are_refused() -> Result<(), DamError> {
    let mut dam = Dam::new(support::koyna(10.0))?;
    assert!(matches!(dam.step(0.0, 0.01), Err(DamError::Call(CallError::Order { .. }))));
    let mut crest = [0.0; 2];
    let early = dam.get(variable::CREST_DISPLACEMENT.value_reference, &mut crest);
    assert!(matches!(early, Err(DamError::Call(CallError::Order { .. }))));
    dam.set(variable::HYDROSTATIC_PRESSURE.value_reference, &support::hydrostatic(&dam))?;
    assert!(matches!(dam.initialise(f64::NAN), Err(DamError::OutOfRange { .. })));
    dam.initialise(2.0)?;
    assert!(matches!(dam.step(f64::NAN, 0.01), Err(DamError::Call(CallError::Time { .. }))));
    assert!(matches!(dam.initialise(2.0), Err(DamError::Call(CallError::Order { .. }))));
    assert!(matches!(dam.step(0.0, 0.01), Err(DamError::Call(CallError::Time { .. }))));
    assert!(matches!(dam.step(2.0, 0.0), Err(DamError::OutOfRange { .. })));
    let nan = dam.set(variable::GROUND_ACCELERATION.value_reference, &[f64::NAN, 0.0]);
    assert!(matches!(nan, Err(DamError::Call(CallError::NonFinite { .. }))));
    let fixed = dam.set(variable::DENSITY.value_reference, &[1.0]);
    assert!(matches!(fixed, Err(DamError::Call(CallError::NotSettable { .. }))));
    let late = vec![0.0; support::hydrostatic(&dam).len()];
    let late = dam.set(variable::HYDROSTATIC_PRESSURE.value_reference, &late);
    assert!(matches!(late, Err(DamError::Call(CallError::Order { .. }))));
    dam.set(variable::GROUND_ACCELERATION.value_reference, &[1e300, 0.0])?;
    let saved = dam.save_state();
    let blown = dam.step(2.0, 0.01);
    assert!(matches!(blown, Err(DamError::NonFinite { .. })), "{blown:?}");
    assert_eq!(dam.save_state(), saved);
    Ok(())
}

#[test]
fn an_empty_reservoir_has_no_interface_points() -> Result<(), DamError> {
    let mut dam = Dam::new(DamParameters { water_depth: 0.0, ..support::koyna(10.0) })?;
    assert!(dam.wet_face().is_none());
    dam.set(variable::INTERFACE_PRESSURE.value_reference, &[])?;
    dam.initialise(0.0)?;
    dam.step(0.0, 0.01)?;
    assert!(support::get(&dam, &variable::INTERFACE_ACCELERATION).is_empty());
    Ok(())
}

/// Everything that a dam's parameters can leave out or choose, from few values each, so that two dams differ in little.
fn parameters() -> impl Strategy<Value = DamParameters> {
    let value = || prop::sample::select(vec![0.0, 0.3, 3e5]);
    let maybe = || prop::option::of(prop::sample::select(vec![0.3, 3e5]));
    let crack = (value(), value(), maybe(), value(), maybe(), any::<bool>()).prop_map(
        |(cohesion, tensile_strength, residual, dilation, dilation_slip, gauss)| CrackParameters {
            cohesion,
            tensile_strength,
            residual_friction_coefficient: residual,
            dilation,
            dilation_slip,
            integration: if gauss { Integration::Gauss } else { Integration::Nodal },
            ..support::crack_at(66.5)
        },
    );
    let frequencies = prop_oneof![
        Just(DampingFrequencies::MultiplesOfFirst([1.0, 5.0])),
        Just(DampingFrequencies::RadiansPerSecond([1.0, 5.0])),
    ];
    let damping = (0..5, frequencies).prop_map(|(kind, frequencies)| match kind {
        0 => Damping::None,
        1 => Damping::Rayleigh { ratio: 0.3, frequencies },
        2 => Damping::Mass { ratio: 0.3, frequencies },
        3 => Damping::Stiffness { ratio: 0.3, frequencies },
        _ => Damping::Local { coefficient: 0.3 },
    });
    let fidelity = prop_oneof![
        Just(Fidelity::Dem),
        Just(Fidelity::RigidBlocks),
        prop::option::of(1usize..3).prop_map(|modes| Fidelity::Reduced { modes }),
        prop::option::of(1usize..3).prop_map(|modes| Fidelity::Intact { modes }),
    ];
    let added_mass = prop::option::of(prop_oneof![Just(vec![vec![0.3]]), Just(vec![vec![0.3, 0.3]])]);
    (prop::collection::vec(crack, 0..3), damping, fidelity, added_mass, any::<bool>()).prop_map(
        |(cracks, damping, fidelity, added_mass, drags_blocks)| DamParameters {
            cracks,
            damping,
            fidelity,
            added_mass,
            drags_blocks,
            ..support::koyna(10.0)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Equal parameters, and only these, have equal fingerprints.
    #[test]
    fn fingerprints_tell_all_parameters_apart(one in parameters(), other in parameters()) {
        let of = |parameters: &DamParameters| Fingerprint::of("dam", parameters).expect("parameters are hashed");
        prop_assert_eq!(of(&one) == of(&other), one == other);
        prop_assert_eq!(of(&one), of(&one.clone()));
    }
}

/// The state of a bonded crack is none of a crack whose tensile strength is what the cohesion was.
#[test]
fn a_bond_of_another_kind_is_another_dam() -> Result<(), DamError> {
    let bonded = |cohesion, tensile_strength| {
        let mut dam = support::koyna(10.0);
        (dam.cracks[0].cohesion, dam.cracks[0].tensile_strength) = (cohesion, tensile_strength);
        support::at_rest(dam)
    };
    let (one, mut other) = (bonded(3e5, 0.0)?, bonded(0.0, 3e5)?);
    let refused = other.restore_state(&one.save_state());
    assert!(matches!(refused, Err(DamError::State(StateError::Fingerprint { .. }))), "{refused:?}");
    Ok(())
}
