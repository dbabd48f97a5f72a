//! The same checks for every participant: finite answers, and equal bits from a repeated step.

use cofferdam_assembly::participant::Prescribed;
use cofferdam_coupling::participant::{InProcess, Layout, Messages, Occasion, Participant, ParticipantError};
use cofferdam_dam::Dam;
use cofferdam_reservoir::Reservoir;
use cofferdam_shared_memory::{Deadlines, Starting, UnitCommand};
use cofferdam_unit::WetFace;
use std::num::NonZeroUsize;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use whole_chain::koyna;
use whole_chain::scenario::{Scenario, binary};

const H: f64 = 0.0025;

/// Inputs that change from step to step and differ from point to point.
fn inputs(participant: &dyn Participant, step: u32, factor: f64) -> Vec<f64> {
    let layout = &participant.description().inputs;
    let mut values = vec![0.0; layout.size()];
    for (channel, range) in layout.channels() {
        let size = match &*channel.name {
            "interface_pressure" => 3e4,
            "hydrostatic_pressure" => 0.0,
            _ => 2.0,
        };
        for (i, value) in values[range].iter_mut().enumerate() {
            *value = factor * size * (0.3 * f64::from(step) + 0.1 * i as f64).sin();
        }
    }
    values
}

fn battery(participant: &mut dyn Participant) -> Result<(), ParticipantError> {
    let name = participant.description().name.clone();
    let zeros = inputs(participant, 0, 0.0);
    let mut outputs = vec![0.0; participant.description().outputs.size()];
    participant.initialise(0.0, &zeros, &mut outputs)?;
    assert_eq!(participant.read("interface_x")?.len(), participant.read("interface_y")?.len());
    let layouts = participant.description().clone();
    let names = |layout: &Layout| layout.channels().map(|(c, _)| c.name.clone()).collect::<Vec<_>>();
    let not_read = [names(&layouts.inputs), names(&layouts.outputs), vec!["no_such_variable".to_owned()]];
    for exchanged in not_read.concat() {
        let refused = participant.read(&exchanged).expect_err(&exchanged).to_string();
        assert!(refused.contains(&format!("{name} has no variable `{exchanged}`")), "{refused}");
    }
    let mut again = outputs.clone();
    let mut time = 0.0;
    for step in 1..=150_u32 {
        let (trial, wanted) = (inputs(participant, step, -0.7), inputs(participant, step, 1.0));
        let occasion = Occasion { step: step.into(), iteration: 1, attempt: 1, time, communication_step: H };
        participant.save_state()?;
        participant.step(&occasion, &wanted, &mut outputs)?;
        // Two other attempts, then the first one again.
        for _ in 0..2 {
            participant.restore_state()?;
            participant.step(&occasion, &trial, &mut again)?;
            assert_ne!(bits(&again), bits(&outputs), "{name}, step {step}: inputs have no effect");
        }
        participant.restore_state()?;
        participant.step(&occasion, &wanted, &mut again)?;
        assert_eq!(bits(&again), bits(&outputs), "{name}, step {step}");
        time = f64::from(step) * H;
    }
    for (channel, range) in layouts.readable.channels() {
        let values = participant.read(&channel.name)?;
        assert!(
            values.len() == range.len() && values.iter().all(|v| v.is_finite()),
            "{name}, {}",
            channel.name
        );
        let last = values.len() - 1;
        let some = participant.read_at(&channel.name, &[last, 0, last + 1])?;
        assert_eq!(bits(&some[..2]), bits(&[values[last], values[0]]), "{name}, {}", channel.name);
        assert!(some.len() == 3 && some[2].is_nan(), "{name}, {}", channel.name);
    }
    Ok(())
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn prescribed() -> Result<(), Box<dyn std::error::Error>> {
    Ok(battery(&mut Prescribed::new(WetFace::straight([9.0, 90.0], 9)?)?)?)
}

#[test]
fn dam_in_process() -> Result<(), Box<dyn std::error::Error>> {
    Ok(battery(&mut InProcess::new(Dam::new(koyna::dam(10.0, true))?, "dam", Messages::default()))?)
}

#[test]
fn reservoir_in_process() -> Result<(), Box<dyn std::error::Error>> {
    let parameters = koyna::reservoir(WetFace::straight([0.0, koyna::DEPTH], 9)?, H, 0.5);
    Ok(battery(&mut InProcess::new(
        Reservoir::new(parameters, NonZeroUsize::MIN)?,
        "reservoir",
        Messages::default(),
    ))?)
}

#[test]
fn both_over_shared_memory() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0).set("time.duration", 0.5).set("time.communication_step", H);
    let scene = toml::to_string(&cofferdam_assembly::read_scene(&scenario.write(), &[])?.scene)?;
    let units = ["dam", "reservoir"].map(|name| {
        let mut command = Command::new(binary());
        command.args(["unit", name]);
        UnitCommand { name: name.to_owned(), command, brief: None }
    });
    let minute = Duration::from_secs(60);
    let deadlines = Deadlines { preparation: minute, step: minute };
    // All live until the end: a unit that ends ends the run of the others.
    let mut units = Starting::new(units, &scene, 1, deadlines)?.wait(&AtomicBool::new(false))?;
    Ok(units.iter_mut().try_for_each(|unit| battery(unit))?)
}

#[test]
fn an_answer_that_is_not_finite_is_refused() -> Result<(), Box<dyn std::error::Error>> {
    let mut dam = InProcess::new(Dam::new(koyna::dam(10.0, true))?, "dam", Messages::default());
    let zeros = inputs(&dam, 0, 0.0);
    let mut outputs = vec![0.0; dam.description().outputs.size()];
    dam.initialise(0.0, &zeros, &mut outputs)?;
    let mut bad = zeros.clone();
    bad[2] = f64::NAN;
    let occasion = Occasion { step: 1, iteration: 1, attempt: 1, time: 0.0, communication_step: H };
    let message = dam.step(&occasion, &bad, &mut outputs).expect_err("NaN is refused").to_string();
    assert!(
        message.contains("interface_pressure") && message.contains("[2]") && message.contains("NaN"),
        "{message}"
    );
    Ok(())
}
