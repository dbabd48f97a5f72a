//! Errors of a missing or wrong condition at the far end.

use super::{percent, record};
use crate::study::{StudyError, relative};
use cofferdam_analysis::context::threads;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::{Assembly, FarEndCondition};
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{Scene, Side};
use nalgebra::Complex;
use std::f64::consts::PI;

/// Frequencies over the first cut-off of a rigid bed.
const RATIOS: [f64; 4] = [0.5, 0.99, 1.5, 2.5];
/// Re s/ω: a closed reservoir has no finite response at its resonances.
const DAMPING: f64 = 1e-6;
/// Smallest interval of the record, s.
const STEP: f64 = 0.01;
/// Distance of the far end over the depth in the reference, where waves leave.
const REFERENCE: f64 = 1.0;

/// Relative L2 errors: on the face at four frequencies, and of the base pressure under the record.
pub fn table(scene: &Scene, motion: &GroundMotion, coarse: bool) -> Result<Table, StudyError> {
    let step = scene.time.communication_step;
    let mut scene = scene.clone();
    let instants = step * (STEP / step).round().max(1.0);
    let moved = record(&scene, motion, instants)?;
    scene.time.communication_step = instants;
    let exact = answers(&scene, FarEndCondition::Outgoing, REFERENCE, &moved)?;
    let names = RATIOS.map(|ratio| format!("ω = {ratio} ω₁"));
    let first = ["far end", "L/h"].map(str::to_owned).into_iter();
    let mut table = Table::new(first.chain(names).chain(["base pressure under the record".to_owned()]));
    let distances = if coarse { vec![1.0] } else { vec![0.5, 1.0, 2.0, 4.0] };
    for (name, far_end) in [
        ("waves leave", FarEndCondition::Outgoing),
        ("left out", FarEndCondition::LeftOut),
        ("wall", FarEndCondition::NoFlow),
        ("p = 0", FarEndCondition::NoPressure),
    ] {
        for &distance in &distances {
            if far_end == FarEndCondition::Outgoing && distance != distances[0] {
                continue;
            }
            let distance = if far_end == FarEndCondition::Outgoing { 0.5 * REFERENCE } else { distance };
            let found = answers(&scene, far_end, distance, &moved)?;
            let cells = found.iter().zip(&exact).map(|(found, exact)| percent(relative(found, exact)));
            table.row([name.to_owned(), distance.to_string()].into_iter().chain(cells));
        }
    }
    Ok(table)
}

/// Pressure on the face for a unit velocity of the dam along n at the frequencies, weighted by lengths, real and imaginary
/// parts one after another; then the base pressure under the record.
fn answers(
    scene: &Scene,
    far_end: FarEndCondition,
    distance: f64,
    moved: &nalgebra::DMatrix<f64>,
) -> Result<Vec<Vec<f64>>, StudyError> {
    let mut scene = scene.clone();
    scene.reservoir.far_end_distance = Some(distance * scene.depth());
    let first_cut_off = PI * scene.reservoir.sound_speed / (2.0 * scene.depth());
    let s = RATIOS.map(|ratio| Complex::new(DAMPING, 1.0) * ratio * first_cut_off);
    let weights = Assembly::of(&scene).dam_face(Side::Upstream)?.tributary_lengths();
    let mut all = Vec::new();
    for response in Assembly::with(&scene, threads(None)).frequency_response(far_end, &s)? {
        let pressure = weights
            .iter()
            .enumerate()
            .map(|(point, weight)| response.row(point).columns(0, weights.len()).sum() * weight.sqrt());
        all.push(pressure.flat_map(|p| [p.re, p.im]).collect());
    }
    let pressure = Assembly::with(&scene, threads(None)).pressure_of_record(far_end, moved)?;
    all.push(pressure.row(0).iter().copied().collect());
    Ok(all)
}
