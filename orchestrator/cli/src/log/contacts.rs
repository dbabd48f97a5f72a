//! The contacts of the dam at the end of a step: `cofferdam log show --contacts`.

use super::Failure;
use crate::context::context;
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::start::{Start, Transport, deadlines};
use cofferdam_assembly::log::scene_of;
use cofferdam_assembly::units::DAM;
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_log::replay::bring;
use cofferdam_log::{Log, LoggedExchange};
use std::sync::atomic::AtomicBool;

/// Longest time that a dam in a process of its own may take for a step, s.
const DEADLINE: f64 = 60.0;

/// The fields of the contacts that are shown.
const FIELDS: [&str; 6] = [
    "contact_x",
    "contact_y",
    "contact_opening",
    "contact_slip",
    "contact_normal_stress",
    "contact_shear_stress",
];

/// Numbers of sticking, slipping and open contacts of each crack in the dam of the run.
const COUNTS: [&str; 3] = ["crack_sticking", "crack_slipping", "crack_open"];

/// Prints the contacts at the end of the step of `accepted`, an exchange of the run with its dam.
pub fn show(log: &Log, accepted: &LoggedExchange) -> Result<(), Failure> {
    let step = accepted.occasion.step;
    let mut dam = there(log, step)?;
    let failed = |cause: ParticipantError| Failure::dam(log, cause.to_string());
    let mut fields = Vec::new();
    for name in FIELDS {
        fields.push(dam.read(name).map_err(failed)?);
    }
    let [x, y, opening, slip, normal, shear] = [0, 1, 2, 3, 4, 5].map(|i: usize| &fields[i]);
    let outputs = accepted.outputs.as_deref().unwrap_or_default();
    let layout = &log.head().unit(DAM).outputs;
    let counted =
        COUNTS.map(|name| layout.range(name).and_then(|range| outputs.get(range)).unwrap_or_default());
    // An intact dam has cracks without contacts.
    if counted.iter().copied().flatten().all(|count| *count == 0.0) {
        return Err(none(log, "its dam has no cracks"));
    }
    let cracks = counted[0].iter().zip(counted[1]).zip(counted[2]);
    print(format!("contacts at the end of step {step}, t = {:.6} s, from the heel", accepted.occasion.end()));
    let mut next = 0;
    for (crack, ((sticking, slipping), open)) in cracks.enumerate() {
        print(format!("  crack {crack}: {sticking} sticking, {slipping} slipping, {open} open"));
        print(format!(
            "  {:>8} {:>9} {:>9} {:>13} {:>13} {:>13} {:>13} {:>9}  is",
            "contact", "x [m]", "y [m]", "opening [m]", "slip [m]", "normal [Pa]", "shear [Pa]", "shear/n."
        ));
        let end = next + (sticking + slipping + open) as usize;
        for i in next..end.min(x.len()) {
            // A bond that is pulled is closed; a side that leaves quickly presses no more, but is not open yet.
            let is_open = normal[i] == 0.0 && opening[i] >= 0.0;
            let share = match normal[i] > 0.0 {
                true => format!("{:.4}", shear[i].abs() / normal[i]),
                false => "-".to_owned(),
            };
            print(format!(
                "  {:>8} {:>9.3} {:>9.3} {:>13.4e} {:>13.4e} {:>13.4e} {:>13.4e} {share:>9}  {}",
                i - next,
                x[i],
                y[i],
                opening[i],
                slip[i],
                normal[i],
                shear[i],
                if is_open { "open" } else { "closed" }
            ));
        }
        next = end;
    }
    Ok(())
}

fn none(log: &Log, why: &str) -> Failure {
    Failure::NoContacts { path: log.path().to_owned(), why: why.to_owned() }
}

/// The dam, made again and put to the end of a step.
fn there(log: &Log, step: u64) -> Result<Box<dyn Participant>, Failure> {
    let (head, scene) = (log.head(), scene_of(log)?);
    let none = |why: &str| none(log, why);
    if scene.dam.is_none() {
        return Err(none("its dam is prescribed"));
    }
    if let Some(parent) = head.parent.as_ref().filter(|parent| step < parent.step) {
        return Err(none(&format!(
            "steps up to {} are those of the run {}; use its log",
            parent.step, parent.log
        )));
    }
    let failed = |why: String| Failure::dam(log, why);
    let start = Start {
        scene: &scene,
        resolved: &head.scene_text,
        transport: Transport::InProcess,
        threads: threads(None),
        deadlines: deadlines(DEADLINE),
        interrupted: &AtomicBool::new(false),
        announce: false,
        context: context(),
    };
    let mut dam = start.units(&[DAM]).map_err(|cause| failed(cause.to_string()))?.remove(0);
    let description = dam.description();
    if FIELDS.iter().any(|name| description.readable.range(name).is_none()) {
        return Err(none(match scene.dam.as_ref().is_some_and(|dam| dam.fidelity.is_foreign()) {
            true => "its dam is simulated by another program, which reports no contacts",
            false => "its dam has no cracks",
        }));
    }
    if description.fingerprint.to_string() != head.unit(DAM).fingerprint {
        return Err(failed("it has other inputs now; use the build and the files of the run".to_owned()));
    }
    let state = log.checkpoint(step)?.and_then(|mut found| found.units.get_mut(DAM.0)?.take());
    let stands = match state {
        Some((stands, state)) => {
            dam.deserialise(&state).map_err(|cause| failed(cause.to_string()))?;
            Some(stands)
        }
        None => None,
    };
    if stands != Some(step) {
        let brought = bring(log, DAM, &mut *dam, stands, step, |_| ());
        if let Some(divergence) = brought.map_err(|cause| failed(cause.to_string()))?.divergence {
            return Err(failed(divergence.report(["the log", "the dam now"]).to_string()));
        }
    }
    Ok(dam)
}
