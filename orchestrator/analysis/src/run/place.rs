//! Restores units, scheme and observers of a run that continues.

use super::RunError;
use crate::context::Context;
use cofferdam_assembly::Assembly;
use cofferdam_assembly::log::scene_of;
use cofferdam_coupling::observer::Past;
use cofferdam_coupling::participant::Participant;
use cofferdam_coupling::run_state::{RunState, RunStateError};
use cofferdam_coupling::scheme::{Graph, UnitId};
use cofferdam_coupling::simulation::{Course, Simulation};
use cofferdam_log::replay::bring;
use cofferdam_log::{LastCheckpoint, Log, LogReadError};
use cofferdam_scene::Scene;

/// A step of a run at which a branch leaves it.
pub struct Fork {
    pub log: Log,
    /// The first step that is computed with other settings.
    pub step: u64,
    /// The last checkpoint before it; `None` for initialisation.
    pub checkpoint: Option<LastCheckpoint>,
    /// Changed settings.
    pub settings: Vec<String>,
}

/// Contents of the log up to and including a checkpoint.
pub fn until<'a>(
    log: &Log,
    checkpoint: &'a LastCheckpoint,
) -> Result<impl Iterator<Item = Result<Past, RunError>> + 'a, LogReadError> {
    let mut reports = log.reports()?;
    let mut done = false;
    Ok(std::iter::from_fn(move || {
        let next = if done { None } else { reports.next() };
        done = matches!(&next, Some(Ok(Past::Checkpoint(found))) if (found.step, &found.run) == (checkpoint.step, &checkpoint.run));
        next.map(|past| past.map_err(RunError::from))
    }))
}

/// Puts units and scheme where they were at a checkpoint.
pub fn place(
    simulation: &mut Simulation,
    course: &mut Course,
    log: &Log,
    checkpoint: &LastCheckpoint,
    context: &Context<'_>,
) -> Result<(), RunError> {
    let ids: Vec<UnitId> = simulation.graph.ids().collect();
    for id in ids {
        let unit = &mut simulation.graph[id];
        let stands = match checkpoint.units.get(id.0).and_then(Option::as_ref) {
            Some((step, state)) => {
                unit.deserialise(state)?;
                Some(*step)
            }
            None => None,
        };
        if stands != Some(checkpoint.step) {
            brought(log, id, unit, stands, checkpoint.step, context)?;
        }
    }
    let state = RunState::from_bytes(simulation.fingerprint().map_err(RunStateError::from)?, &checkpoint.run)
        .map_err(RunStateError::from)?;
    Ok(simulation.resume(course, &state)?)
}

/// Brings a unit, which is new or `stands` at the end of a step, to the end of another step by the logged requests.
fn brought(
    log: &Log,
    id: UnitId,
    unit: &mut dyn Participant,
    stands: Option<u64>,
    step: u64,
    context: &Context<'_>,
) -> Result<(), RunError> {
    let name = unit.description().name.clone();
    let not_there = |why: String| RunError::NotThere { unit: name.clone(), step, why };
    if stands.is_none() {
        context.line(format!("{name} cannot save its state: its {step} steps are repeated"));
    }
    let brought = bring(log, id, unit, stands, step, |_| ()).map_err(|cause| not_there(cause.to_string()))?;
    match brought.divergence {
        None => Ok(()),
        Some(divergence) => Err(not_there(divergence.report(["the log", "the unit now"]).to_string())),
    }
}

/// A run continues bit for bit only with the units of the log.
pub fn same_units(log: &Log, graph: &Graph) -> Result<(), RunError> {
    for (unit, logged) in graph.units().zip(&log.head().units) {
        let now = unit.description().fingerprint.to_string();
        if now != logged.fingerprint {
            let why = format!(
                "the {} has other inputs now (fingerprint {now:.12}, {:.12} in the log); use the build and the files \
                 of the run, or `branch`",
                logged.name, logged.fingerprint
            );
            return Err(RunError::NoWayOn { log: log.path().to_owned(), why });
        }
    }
    Ok(())
}

/// A branch exchanges the variables of the run that it leaves, because its log begins with theirs.
pub fn same_variables(fork: &Fork, graph: &Graph) -> Result<(), RunError> {
    let logged = &fork.log.head().units;
    let refused = |why: String| Err(RunError::NoWayOn { log: fork.log.path().to_owned(), why });
    if graph.units().count() != logged.len() {
        return refused(format!("a branch has the {} units of its run; run the scene instead", logged.len()));
    }
    for (unit, logged) in graph.units().zip(logged) {
        let now = unit.description();
        let other = now.inputs.unlike(&logged.inputs).or_else(|| now.outputs.unlike(&logged.outputs));
        if let Some(variable) = other {
            return refused(format!(
                "with these settings the {} exchanges other variables or at other points, such as `{variable}`; run the scene \
                 instead",
                now.name
            ));
        }
    }
    Ok(())
}

/// Brings the units of a branch to the end of step `step` of the run. Unchanged units, and dams with changes only to the
/// strength of cracks, receive the same states; other units repeat the logged requests.
pub fn hand_over(
    scene: &Scene,
    [from, to]: [&mut Graph; 2],
    fork: &Fork,
    step: u64,
    context: &Context<'_>,
) -> Result<(), RunError> {
    let scenes = [&scene_of(&fork.log)?, scene];
    let ids: Vec<UnitId> = to.ids().collect();
    for id in ids {
        let fingerprint = to[id].description().fingerprint;
        let same = from[id].description().fingerprint == fingerprint;
        let state = match same || Assembly::of(scenes[1]).continues_state_of(scenes[0], id) {
            true => from[id].serialise()?,
            false => None,
        };
        match state {
            Some(state) if same => to[id].deserialise(&state)?,
            Some(state) => {
                let relabelled = cofferdam_unit::relabel(&state, fingerprint);
                let relabelled = relabelled.map_err(RunStateError::from)?;
                to[id].deserialise(&relabelled)?;
                context.line(format!(
                    "{} continues from its state with other cracks",
                    to[id].description().name
                ));
            }
            None if same => brought(&fork.log, id, &mut to[id], None, step, context)?,
            None => {
                let name = to[id].description().name.clone();
                context.line(format!("{name} is a new unit: the requests of {step} steps are repeated"));
                bring(&fork.log, id, &mut to[id], None, step, |_| ())
                    .map_err(|cause| RunError::NotThere { unit: name, step, why: cause.to_string() })?;
            }
        }
    }
    Ok(())
}
