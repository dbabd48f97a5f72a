//! Energy balance: it closes under strong shaking with slip, and the energy of undamped motion is conserved.

use crate::support;

use cofferdam_dam::contact::Integration;
use cofferdam_dam::{CrackParameters, Dam, DamError, DamParameters, Damping, DampingFrequencies, Fidelity};
use cofferdam_unit::{CoSimulation, variables::dam as variable};

/// A dam after bursts of 0.5 g until `end` (s), its peak kinetic energy and its largest balance error, J/m.
fn shaken(parameters: DamParameters, end: f64) -> Result<(Dam, f64, f64), DamError> {
    let mut dam = support::at_rest(parameters)?;
    assert_eq!(dam.state().energy().gained().strain, 0.0);
    assert_eq!(support::get(&dam, &variable::ENERGY_BALANCE_ERROR), [0.0]);
    let (mut peak, mut worst) = (0.0f64, 0.0f64);
    while dam.state().time() < end {
        let until = dam.state().time() + 2.5e-3;
        support::shake(&mut dam, 2.5e-3, until, support::bursts)?;
        peak = peak.max(support::get(&dam, &variable::KINETIC_ENERGY)[0]);
        worst = worst.max(support::get(&dam, &variable::ENERGY_BALANCE_ERROR)[0].abs());
    }
    Ok((dam, peak, worst))
}

/// The block slides by decimetres and lifts off. Tolerance: 0.05 % of the peak kinetic energy; the
/// error comes from contacts that open and close within a time step.
#[test]
fn the_ledger_closes_while_the_crack_slides() -> Result<(), DamError> {
    let (dam, peak, worst) = shaken(support::koyna(5.0), 7.0)?;
    let work = dam.state().energy().work;
    let sliding = support::get(&dam, &variable::CRACK_SLIDING)[0];
    println!("Koyna, 0.5 g bursts: slip {sliding:.4} m; {work:.0?}; peak kinetic {peak:.0} J/m");
    println!("largest balance error {worst:.1} J/m = {:.2e} of peak kinetic energy", worst / peak);
    assert!(sliding > 0.01 && work.friction > 0.0 && work.damping > 0.0);
    assert!(worst < 5e-4 * peak);
    Ok(())
}

/// Without damping contacts open and close all the time; the time step is limited for this reason. Tolerance:
/// 0.3 % of the peak kinetic energy.
#[test]
fn the_ledger_closes_without_damping_too() -> Result<(), DamError> {
    let undamped = DamParameters { damping: Damping::None, ..support::koyna(5.0) };
    let (dam, peak, worst) = shaken(undamped, 6.0)?;
    let sliding = support::get(&dam, &variable::CRACK_SLIDING)[0];
    println!(
        "undamped: slip {sliding:.3} m, largest balance error {:.2e} of peak kinetic energy",
        worst / peak
    );
    assert!(sliding.abs() > 0.01 && worst < 3e-3 * peak);
    Ok(())
}

/// Dams that differ in damping, crack, fidelity and water.
fn variants() -> Vec<(&'static str, DamParameters)> {
    let dam = || support::koyna(10.0);
    let at = DampingFrequencies::MultiplesOfFirst([1.0, 5.0]);
    let damped = |damping| DamParameters { damping, ..dam() };
    let cracked = |change: fn(&mut CrackParameters)| {
        let mut dam = dam();
        dam.cracks.iter_mut().for_each(change);
        dam
    };
    vec![
        ("Rayleigh", dam()),
        ("mass", damped(Damping::Mass { ratio: 0.05, frequencies: at })),
        ("stiffness", damped(Damping::Stiffness { ratio: 0.05, frequencies: at })),
        ("local", damped(Damping::Local { coefficient: 0.15 })),
        ("none", damped(Damping::None)),
        ("bonded", cracked(|crack| (crack.cohesion, crack.tensile_strength) = (2e5, 1e5))),
        ("dilating", cracked(|crack| crack.dilation = 0.1)),
        ("Gauss points", cracked(|crack| crack.integration = Integration::Gauss)),
        ("added mass", support::with_water(dam())),
        ("added mass, local", support::with_water(damped(Damping::Local { coefficient: 0.15 }))),
        ("reduced", DamParameters { fidelity: Fidelity::Reduced { modes: None }, ..dam() }),
    ]
}

/// The error falls with the time step Δt: at least in proportion, from the default to an eighth of it, and to 3e-4 of
/// the peak kinetic energy there. Its largest part comes from contacts that open and close within a time
/// step, of second order.
#[test]
fn the_balance_error_falls_with_the_time_step() -> Result<(), DamError> {
    for (name, parameters) in variants() {
        let dam = Dam::new(parameters.clone())?;
        let default = dam.time_step_limit() / dam.critical_time_step().limit;
        let error = |share: f64| -> Result<f64, DamError> {
            let time_step_safety = share * default;
            let (_, peak, worst) = shaken(DamParameters { time_step_safety, ..parameters.clone() }, 2.0)?;
            Ok(worst / peak)
        };
        let (coarse, fine) = (error(1.0)?, error(1.0 / 8.0)?);
        println!("{name}: balance error {coarse:.1e}, with an eighth of the time step {fine:.1e}");
        assert!(fine < coarse / 8.0 && fine < 3e-4, "{name}");
    }
    Ok(())
}

/// Check that the balance can fail: input work that the dam did not receive must appear as an error.
#[test]
fn the_ledger_sees_work_that_was_not_done() -> Result<(), DamError> {
    let mut dam = support::at_rest(DamParameters { time_step_safety: 0.2, ..support::koyna(10.0) })?;
    support::shake(&mut dam, 2.5e-3, 1.0, support::bursts)?;
    let mut ledger = *dam.state().energy();
    let closed = ledger.balance_error().abs();
    ledger.work.input *= 1.05;
    println!("balance error {closed:.1} J/m, with 5 % more input {:.1} J/m", ledger.balance_error());
    assert!(ledger.balance_error().abs() > 100.0 * closed);
    Ok(())
}

/// Undamped intact dam, 300 s of free vibration: total energy (including that of the weight) in the second
/// half against that in the first half. Tolerance: central differences conserve a nearby energy exactly; the
/// computed energy oscillates by (ωΔt)²/8.
#[test]
fn free_vibration_keeps_its_energy_for_five_minutes() -> Result<(), DamError> {
    let parameters = DamParameters {
        cracks: Vec::new(),
        damping: Damping::None,
        water_depth: 0.0,
        ..support::koyna(10.0)
    };
    let mut dam = support::at_rest(parameters)?;
    support::shake(&mut dam, 5e-3, 0.5, |time| 3.0 * (12.0 * time).sin() * f64::from(time < 0.45))?;
    let mut means = [0.0; 2];
    let input = dam.state().energy().work.input;
    let start = dam.state().time();
    for half in &mut means {
        for _ in 0..30_000 {
            dam.step(dam.state().time(), 5e-3)?;
            let (gained, work) = (dam.state().energy().gained(), dam.state().energy().work);
            *half += (gained.kinetic + gained.strain - (work.input - input)) / 3e4;
        }
    }
    let growth = means[1] / means[0] - 1.0;
    println!("free vibration over {:.0} s: energy growth {growth:+.1e}", dam.state().time() - start);
    assert!(growth.abs() < 1e-5);
    Ok(())
}

/// From its state of rest the dam moves only because of the residual forces, 1e-9 of the loads.
#[test]
fn an_unloaded_run_stays_at_rest() -> Result<(), DamError> {
    let mut dam: Dam = support::at_rest(support::koyna(5.0))?;
    let (mut acceleration, mut displacement) = (0.0f64, 0.0f64);
    while dam.state().time() < 0.5 {
        dam.step(dam.state().time(), 2.5e-3)?;
        for a in support::get(&dam, &variable::CREST_ACCELERATION) {
            acceleration = acceleration.max(a.abs());
        }
        for u in support::get(&dam, &variable::CREST_DISPLACEMENT) {
            displacement = displacement.max(u.abs());
        }
    }
    let sliding = support::get(&dam, &variable::CRACK_SLIDING)[0];
    println!(
        "at rest for 0.5 s: crest ≤ {acceleration:.1e} m/s², {displacement:.1e} m; slip {sliding:.1e} m"
    );
    assert!(acceleration < 1e-5 && displacement < 1e-9 && sliding.abs() < 1e-9);
    Ok(())
}
