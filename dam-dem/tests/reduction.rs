//! Reduced models against the full model, and against exact solutions.

use crate::support;

use cofferdam_dam::{
    CrackLine, CrackParameters, Dam, DamError, DamParameters, Damping, Fidelity, Kinematics, Section,
};
use cofferdam_unit::{CoSimulation, variables::dam as variable};
use support::{Record, with_water};

const STEP: f64 = 2.5e-3;
const REDUCED: Fidelity = Fidelity::Reduced { modes: None };

/// Time histories of a dam, one value for each communication step.
struct Histories {
    crest: Vec<f64>,
    rotation: Vec<f64>,
    sliding: Vec<f64>,
    balance: f64,
}

impl Histories {
    fn of(parameters: DamParameters, ground: impl Fn(f64) -> f64, until: f64) -> Result<Self, DamError> {
        let mut dam = support::at_rest(parameters)?;
        let mut histories = Self { crest: vec![], rotation: vec![], sliding: vec![], balance: 0.0 };
        let mut peak = 0.0f64;
        while dam.state().time() < until - STEP / 2.0 {
            let time = dam.state().time();
            dam.set(variable::GROUND_ACCELERATION.value_reference, &[ground(time + STEP), 0.0])?;
            dam.step(time, STEP)?;
            let first = |variable| support::get(&dam, variable).first().copied().unwrap_or(0.0);
            histories.crest.push(first(&variable::CREST_DISPLACEMENT));
            histories.rotation.push(first(&variable::CRACK_ROTATION));
            histories.sliding.push(first(&variable::CRACK_SLIDING));
            peak = peak.max(dam.state().energy().now.kinetic);
        }
        histories.balance = dam.state().energy().balance_error() / peak;
        Ok(histories)
    }

    /// Relative differences of peak crest displacement, peak rotation and residual sliding from those of `other`.
    fn differences(&self, other: &Self) -> [f64; 3] {
        let last = |run: &Self| run.sliding.last().map_or(0.0, |s| s.abs());
        let sizes = |run: &Self| [largest(&run.crest), largest(&run.rotation), last(run)];
        let (own, others) = (sizes(self), sizes(other));
        [0, 1, 2].map(|i| own[i] / others[i] - 1.0)
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, b| a.max(b.abs()))
}

/// Relative L2 difference.
fn apart(values: &[f64], reference: &[f64]) -> f64 {
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let difference = squares(&mut values.iter().zip(reference).map(|(a, b)| a - b));
    (difference / squares(&mut reference.iter().copied())).sqrt()
}

fn level(fidelity: Fidelity, parameters: DamParameters) -> DamParameters {
    DamParameters { fidelity, ..parameters }
}

/// Three records times 0.7 with both polarities and added mass. Tolerances: crest 2 %, rotation 5 %, residual sliding
/// 10 %. If blocks rock so strongly that changes of the ground motion by up to 1 % change the results of the full
/// model by more, the tolerance is twice the largest of these changes.
#[test]
fn reduced_blocks_slide_and_rock_as_all_elements_do() -> Result<(), DamError> {
    let full = with_water(support::koyna(7.0));
    let reduced = level(REDUCED, full.clone());
    for name in support::RECORDS {
        let record = Record::read(name);
        for polarity in [1.0, -1.0] {
            let run = |parameters: &DamParameters, scale: f64| {
                Histories::of(parameters.clone(), |t| 0.7 * scale * polarity * record.at(t), 9.0)
            };
            let (reference, answer) = (run(&full, 1.0)?, run(&reduced, 1.0)?);
            let found = answer.differences(&reference);
            println!(
                "{name} {polarity:+}: crest {:+.1e}, rotation {:+.1e}, sliding {:+.1e} of {:.1} mm; balance {:+.1e}, full {:+.1e}",
                found[0],
                found[1],
                found[2],
                1e3 * reference.sliding.last().unwrap_or(&0.0),
                answer.balance,
                reference.balance
            );
            let limits = [0.02, 0.05, 0.1];
            if (0..3).any(|i| found[i].abs() > limits[i]) {
                let mut spread = [0.0f64; 3];
                for scale in [0.99, 0.995, 1.005, 1.01] {
                    let other = run(&full, scale)?.differences(&reference);
                    (0..3).for_each(|i| spread[i] = spread[i].max(other[i].abs()));
                }
                println!("  changes of the ground motion by up to 1 % change the full model by {spread:.3?}");
                assert!((0..3).all(|i| found[i].abs() < f64::max(limits[i], 2.0 * spread[i])));
            }
            assert!(answer.balance.abs() < 2e-3 && reference.balance.abs() < 2e-3);
        }
    }
    Ok(())
}

/// Small-strain kinematics, so that truncation of the modes is the only error; half a record, in which no impacts
/// amplify differences.
#[test]
fn more_modes_come_closer() -> Result<(), DamError> {
    let small = DamParameters { kinematics: Kinematics::Small, ..with_water(support::koyna(7.0)) };
    let record = Record::read(support::RECORDS[1]);
    let run = |parameters: DamParameters| Histories::of(parameters, |t| 0.5 * record.at(t), 4.0);
    let full = run(small.clone())?;
    let mut errors = Vec::new();
    for modes in [2, 8, 32] {
        let reduced = run(level(Fidelity::Reduced { modes: Some(modes) }, small.clone()))?;
        errors.push(apart(&reduced.crest, &full.crest));
    }
    println!("crest, 2, 8, 32 modes a block: relative L2 {errors:.5?}");
    assert!(errors[0] > 2.0 * errors[1] && errors[1] > errors[2] && errors[2] < 3e-3);
    Ok(())
}

/// The state of rest is linear as long as contacts stick, and the modes represent it exactly.
#[test]
fn rest_is_that_of_all_elements() -> Result<(), DamError> {
    for cracks in [vec![66.5], vec![30.0, 66.5, 85.0]] {
        let small = DamParameters {
            kinematics: Kinematics::Small,
            cracks: cracks.into_iter().map(support::crack_at).collect(),
            ..support::koyna(7.0)
        };
        let rest = |parameters| -> Result<[f64; 2], DamError> {
            let dam = support::at_rest(parameters)?;
            let crest = support::get(&dam, &variable::CREST_STATIC_DISPLACEMENT);
            Ok([crest[0], crest[1]])
        };
        let (full, reduced) = (rest(small.clone())?, rest(level(REDUCED, small))?);
        let error = (full[0] - reduced[0]).hypot(full[1] - reduced[1]) / full[0].hypot(full[1]);
        println!("crest at rest {full:.6?} m, reduced apart by {error:.1e}");
        assert!(error < 1e-6);
    }
    Ok(())
}

/// A block 8 m high and 2 m wide rocks on a short fixed block by a few degrees: finite rotation of a reduced block.
#[test]
fn a_block_turns_by_a_finite_angle() -> Result<(), DamError> {
    let tall = DamParameters {
        section: Section::rectangle(2.0, 9.0),
        water_depth: 0.0,
        cracks: vec![cofferdam_dam::CrackParameters {
            normal_stiffness: 1e10,
            shear_stiffness: 1e10,
            ..support::crack_at(1.0)
        }],
        damping: Damping::None,
        ..support::koyna(1.0)
    };
    let pulse = |t: f64| if t < 0.45 { 6.0 } else { 0.0 };
    let run = |parameters| Histories::of(parameters, pulse, 2.0);
    let full = run(tall.clone())?;
    let reduced = run(level(REDUCED, tall.clone()))?;
    let small = run(level(REDUCED, DamParameters { kinematics: Kinematics::Small, ..tall }))?;
    let [turned, linear] = [&reduced, &small].map(|run| apart(&run.rotation, &full.rotation));
    println!(
        "rocking to {:.2}°: relative L2 of the rotation {turned:.1e}, with small rotations {linear:.1e}; balance {:.1e}",
        largest(&full.rotation).to_degrees(),
        reduced.balance
    );
    assert!(largest(&full.rotation) > 0.05 && turned < 0.01 && linear > 3.0 * turned);
    assert!(reduced.balance.abs() < 5e-3);
    Ok(())
}

/// The intact dam by elements and by modes under two records, against a superposition of all modes of the
/// same matrices that is exact between the samples of the record (oscillator under a force that is linear in
/// time).
#[test]
fn the_intact_dam_follows_its_own_modes() -> Result<(), DamError> {
    let intact = DamParameters { cracks: vec![], kinematics: Kinematics::Small, ..support::koyna(7.0) };
    let cracked = DamParameters { kinematics: Kinematics::Small, ..support::koyna(7.0) };
    for name in &support::RECORDS[..2] {
        let record = Record::read(name);
        let exact = support::modal_crest(&Dam::new(intact.clone())?, |t| record.at(t), STEP, 15.0);
        let elements = Histories::of(intact.clone(), |t| record.at(t), 15.0)?;
        let few =
            Histories::of(level(Fidelity::Intact { modes: None }, cracked.clone()), |t| record.at(t), 15.0)?;
        let errors = [&elements, &few].map(|run| apart(&run.crest, &exact));
        println!(
            "intact dam, {name}: crest by elements {:.1e}, by modes {:.1e} of the exact one",
            errors[0], errors[1]
        );
        assert!(errors.iter().all(|error| *error < 5e-3));
        assert!(few.sliding.iter().all(|sliding| sliding.abs() < 1e-12));
    }
    Ok(())
}

/// A rigid block on springs settles by its weight over their stiffness and does not move sideways. Rigid
/// blocks without a crack are refused.
#[test]
fn rigid_blocks_rest_on_their_contacts() -> Result<(), DamError> {
    let crack = support::crack_at(40.0);
    let parameters = DamParameters {
        section: Section::rectangle(20.0, 60.0),
        water_depth: 0.0,
        cracks: vec![crack.clone()],
        ..support::koyna(5.0)
    };
    let dam = support::at_rest(level(Fidelity::RigidBlocks, parameters.clone()))?;
    let closure = 2640.0 * 9.81 * 20.0 / crack.normal_stiffness;
    let crest = support::get(&dam, &variable::CREST_STATIC_DISPLACEMENT);
    println!("rigid block settles by {:.6e} m, exact {closure:.6e} m", -crest[1]);
    assert!((-crest[1] / closure - 1.0).abs() < 1e-9 && crest[0].abs() < 1e-9 * closure);
    let uncracked = DamParameters { cracks: vec![], ..level(Fidelity::RigidBlocks, parameters) };
    assert_eq!(Dam::new(uncracked).err(), Some(DamError::RigidWithoutCrack));
    Ok(())
}

/// States of modes can be restored and serialised, and other dams refuse them, as for states of nodes.
#[test]
fn states_of_modes_give_the_same_bits_again() -> Result<(), DamError> {
    for fidelity in [REDUCED, Fidelity::RigidBlocks, Fidelity::Intact { modes: Some(5) }] {
        let parameters = level(fidelity, support::koyna(10.0));
        let mut dam = support::at_rest(parameters.clone())?;
        support::shake(&mut dam, STEP, 1.0, support::bursts)?;
        let saved = dam.save_state();
        let go = |dam: &mut Dam| -> Result<Vec<u64>, DamError> {
            support::shake(dam, STEP, 1.2, support::bursts)?;
            Ok(dam.variables().iter().flat_map(|v| support::get(dam, v)).map(f64::to_bits).collect())
        };
        let first = go(&mut dam)?;
        dam.restore_state(&saved)?;
        assert_eq!(first, go(&mut dam)?);
        let mut fresh = Dam::new(parameters)?;
        let bytes = dam.serialise_state(&saved)?;
        fresh.restore_state(&fresh.deserialise_state(&bytes)?)?;
        assert_eq!(first, go(&mut fresh)?);
        let other = Dam::new(support::koyna(10.0))?;
        assert!(other.deserialise_state(&bytes).is_err());
    }
    Ok(())
}

/// While every contact sticks, the error of the long time steps falls with their length.
#[test]
fn long_time_steps_do_while_every_contact_sticks() -> Result<(), DamError> {
    let with_safety = |time_step_safety| {
        let parameters = DamParameters { time_step_safety, ..level(REDUCED, support::koyna(10.0)) };
        Histories::of(parameters, |time| 0.02 * support::bursts(time), 1.0)
    };
    let dam = Dam::new(level(REDUCED, support::koyna(10.0)))?;
    let [calm, others] = [dam.calm_time_steps_per(STEP), Some(dam.time_steps_per(STEP))];
    let long = (STEP / (2.88 * dam.time_step_limit())).ceil() as usize;
    assert!(calm == Some(long) && others > Some(2 * long), "{calm:?}, {others:?}");
    assert_eq!(Dam::new(support::koyna(10.0))?.calm_time_steps_per(STEP), None);

    let exact = with_safety(0.9 / 64.0)?;
    let error = |safety| Ok::<_, DamError>(apart(&with_safety(safety)?.crest, &exact.crest));
    let (usual, first, second, third) = (error(0.9)?, error(0.3)?, error(0.15)?, error(0.075)?);
    assert!(usual < 1e-3 && usual > first, "{usual:e}, {first:e}");
    assert!(first > 1.7 * second && second > 1.7 * third, "{first:e}, {second:e}, {third:e}");
    Ok(())
}

/// An attempt with long time steps leaves no trace if a contact does not stick in it; a step that goes to and fro between both is
/// settled, so that an iteration ends.
#[test]
fn whether_every_contact_sticks_gets_a_definite_answer() -> Result<(), DamError> {
    let mut dam = support::at_rest(level(REDUCED, support::koyna(10.0)))?;
    support::shake(&mut dam, STEP, 0.4, |time| 0.02 * support::bursts(time))?;
    let start = dam.save_state();
    let mut step = |ground: f64| -> Result<(f64, f64), DamError> {
        dam.restore_state(&start)?;
        dam.set(variable::GROUND_ACCELERATION.value_reference, &[ground, 0.0])?;
        dam.step(start.time(), STEP)?;
        let slipping = support::get(&dam, &variable::CRACK_SLIPPING)[0];
        Ok((support::get(&dam, &variable::CREST_DISPLACEMENT)[0], slipping))
    };
    let (calm, slipping) = step(0.1)?;
    assert_eq!(slipping, 0.0);
    let (restless, slipping) = step(1e4)?;
    assert!(slipping > 0.0);
    assert_eq!(step(0.1)?.0, calm);
    assert_eq!(step(1e4)?.0, restless);
    let (settled, _) = step(0.1)?;
    assert!(settled != calm && (settled / calm - 1.0).abs() < 1e-2, "{settled:e}, {calm:e}");
    assert_eq!((step(1e4)?.0, step(0.1)?.0), (restless, settled));
    Ok(())
}

#[test]
fn what_modes_cannot_do_is_refused() {
    let local = DamParameters { damping: Damping::Local { coefficient: 0.2 }, ..support::koyna(10.0) };
    assert_eq!(Dam::new(level(REDUCED, local)).err(), Some(DamError::LocalDampingOfModes));
    let none = level(Fidelity::Reduced { modes: Some(0) }, support::koyna(10.0));
    assert!(matches!(Dam::new(none), Err(DamError::OutOfRange { parameter: "modes", .. })));
}

/// A joint under a part of the base only: beyond it the ground holds the nodes of the base, at its end, too.
#[test]
fn the_ground_holds_what_a_joint_does_not_free() -> Result<(), DamError> {
    let joint = CrackParameters {
        line: CrackLine::Polyline(vec![[0.0, 0.0], [20.0, 0.0]]),
        ..support::crack_at(0.0)
    };
    let parameters = DamParameters { cracks: vec![joint], envelopes: true, ..support::koyna(10.0) };
    let mut crests = Vec::new();
    for fidelity in [Fidelity::Dem, REDUCED] {
        let mut dam = support::at_rest(level(fidelity, parameters.clone()))?;
        support::shake(&mut dam, STEP, 1.0, support::bursts)?;
        let [x, y] = [variable::NODE_X, variable::NODE_Y].map(|v| support::get(&dam, &v));
        let [u, v] =
            [variable::NODE_DISPLACEMENT_X, variable::NODE_DISPLACEMENT_Y].map(|v| support::get(&dam, &v));
        let held = |node: &usize| y[*node] == 0.0 && x[*node] >= 20.0 - 1e-9;
        let (of_ground, moved): (Vec<usize>, Vec<usize>) =
            (0..x.len()).filter(held).partition(|&node| u[node] == 0.0 && v[node] == 0.0);
        assert!(of_ground.len() > 5 && moved.is_empty(), "{fidelity:?}: {moved:?}");
        for variable in variable::ALL.iter().filter(|variable| variable.name.starts_with("envelope_")) {
            let values = support::get(&dam, variable);
            assert!(values.iter().all(|value| value.is_finite()), "{fidelity:?}: {}", variable.name);
        }
        crests.push(support::get(&dam, &variable::CREST_DISPLACEMENT)[0]);
    }
    println!("crest of all elements and of modes: {crests:?}");
    assert!((crests[1] / crests[0] - 1.0).abs() < 0.05, "{crests:?}");
    Ok(())
}

/// Below a crack that frees no block nothing moves, and nothing slides or vibrates by itself.
#[test]
fn a_crack_whose_sides_are_held_frees_no_rigid_block() -> Result<(), DamError> {
    let upright = CrackParameters {
        line: CrackLine::Polyline(vec![[30.0, -1.0], [30.0, 200.0]]),
        ..support::crack_at(0.0)
    };
    let parameters = DamParameters { cracks: vec![upright], ..support::koyna(10.0) };
    let rigid = Dam::new(level(Fidelity::RigidBlocks, parameters.clone())).map(drop);
    assert!(matches!(rigid, Err(DamError::RigidWithoutCrack)), "{rigid:?}");
    assert_eq!(parameters.flutter([9810.0, 0.0])?, []);
    Ok(())
}
