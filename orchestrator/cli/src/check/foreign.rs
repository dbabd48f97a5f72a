//! Tests units of other programs.

use super::CheckError;
use crate::context::context;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::start::{Start, Transport, deadlines};
use cofferdam_assembly::Assembly;
use cofferdam_assembly::participant::{check_sign, held_answer, self_test};
use cofferdam_coupling::participant::{AccelerationMeaning, Description, Occasion, Participant};
use cofferdam_coupling::scheme::{CouplingError, UnitId};
use cofferdam_scene::{Scene, Source};
use cofferdam_unit::{Capabilities, Role};
use std::sync::atomic::AtomicBool;

/// Steps after which a unit has a past.
const PAST: u64 = 3;
/// Time that a unit of another program may take for a step, s.
const DEADLINE: f64 = 60.0;

/// A unit of a scene; that of another program in a process of its own, where it does no harm.
pub fn unit(id: UnitId, scene: &Scene) -> Result<Box<dyn Participant>, CheckError> {
    let foreign = Assembly::of(scene).source(id).is_foreign();
    let start = Start {
        scene,
        resolved: &toml::to_string(scene)?,
        transport: if foreign { Transport::SharedMemory } else { Transport::InProcess },
        threads: threads(None),
        deadlines: deadlines(DEADLINE),
        interrupted: &AtomicBool::new(false),
        announce: false,
        context: context(),
    };
    Ok(start.units(&[id])?.remove(0))
}

/// Tests a unit of another program at rest and, if it can save its state, after some steps, and whether it fits the scene;
/// returns its response to the first test.
pub fn test(
    unit: &mut dyn Participant,
    role: Role,
    request: &[f64],
    pressure: f64,
    scene: &Scene,
) -> Result<f64, CheckError> {
    let Capabilities { saved_state, variable_communication_step, .. } = unit.description().capabilities;
    let participant = || unit.description().name.clone();
    if !variable_communication_step && scene.stepping().varies() {
        return Err(CouplingError::FixedStep { participant: participant() }.into());
    }
    let communication_step = scene.time.communication_step;
    let occasion = |step: u64| Occasion {
        step,
        iteration: 1,
        attempt: 1,
        time: (step - 1) as f64 * communication_step,
        communication_step,
    };
    let mut outputs = vec![0.0; unit.description().outputs.size()];
    unit.initialise(0.0, request, &mut outputs)?;
    let change = self_test(unit, role, request, pressure, &occasion(1))?;
    check_sign(unit, role, change)?;
    // One that cannot go back has taken the first step already.
    let steps = if saved_state { vec![occasion(1), occasion(2)] } else { vec![occasion(2)] };
    if saved_state {
        unit.save_state()?;
    }
    let held = held_answer(unit, role, request, pressure, &steps)?;
    if saved_state {
        unit.restore_state()?;
        let name = if role == Role::Fluid { "interface_acceleration" } else { "interface_pressure" };
        let driven = unit.description().inputs.range(name).unwrap_or_default();
        let mut moved = request.to_vec();
        // It may refuse steps beyond the end of the run.
        let past = PAST.min(scene.steps().saturating_sub(1));
        for step in 1..=past {
            unit.save_state()?;
            moved[driven.clone()].fill(if role == Role::Fluid {
                step as f64
            } else {
                pressure * step as f64
            });
            unit.step(&occasion(step), &moved, &mut outputs)?;
        }
        self_test(unit, role, &moved, pressure, &occasion(past + 1))?;
    }
    // A unit that responds only after the requested step has a sign of 0.
    Ok(if change == 0.0 { change } else { held })
}

/// Description of a unit and, if it belongs to another program, of its capabilities; `change` is its response to a test, to be
/// compared with the `added_mass` (kg/m) of Westergaard's water.
pub fn told(unit: &dyn Participant, source: Source<'_>, change: f64, added_mass: Option<f64>) -> String {
    let Description { solver, outputs, capabilities, .. } = unit.description();
    if !source.is_foreign() {
        return solver.clone();
    }
    let points = outputs.range("interface_pressure").or(outputs.range("interface_acceleration"));
    let points = points.map_or(0, |range| range.len());
    let answer = match added_mass {
        Some(mass) => format!(
            "1 m/s² into the water, held for two steps, gives {:.3} MN/m (Westergaard's added mass {:.3}; water with a memory takes longer)",
            change / 1e6,
            mass / 1e6
        ),
        None => "a pressure pushes it into the dam".to_owned(),
    };
    let tested = match (change == 0.0, capabilities.saved_state) {
        (true, _) => "it does not respond within the requested step".to_owned(),
        (false, true) => format!("repeated steps and sign are correct: {answer}"),
        (false, false) => format!("its sign is correct: {answer}"),
    };
    let steps = if capabilities.variable_communication_step { "of any length" } else { "of equal length" };
    let schemes = if capabilities.saved_state { "any scheme" } else { "explicit schemes alone" };
    let meaning = match source.acceleration() {
        AccelerationMeaning::Mean => "the mean over the step",
        AccelerationMeaning::End => "that at the step's end",
    };
    format!(
        "{solver}; {points} points, {tested}; it takes steps {steps} and fits {schemes}; its acceleration is \
         taken to be {meaning}"
    )
}
