//! The pressure over height at chosen instants.

use super::data::Profile;
use super::folder::RunFolder;
use super::westergaard;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_log::LoggedExchanges;
use cofferdam_log::{Entry, Log, LogReadError};
use cofferdam_scene::{ReservoirScene, Side};

/// Points of a parabola.
const POINTS: u32 = 48;

/// The pressure on each wet face when the base pressure and the crest displacement peaked, and at the end; nothing of a run that
/// logged no exchanges.
///
/// **Errors**: the log cannot be read.
pub fn of(run: &RunFolder) -> Result<Vec<Profile>, LogReadError> {
    let scene = &run.loaded.scene;
    if scene.log.exchanges == LoggedExchanges::None || !scene.has_water() {
        return Ok(Vec::new());
    }
    let mut profiles = Vec::new();
    let peak_acceleration =
        run.loaded.ground_motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    let filled = |(_, (_, water)): &(usize, (Side, &ReservoirScene))| !water.is_empty();
    for (index, (side, water)) in scene.waters().enumerate().filter(filled) {
        let (unit, points) = (UnitId(index + 1), points(run, side));
        let (depth, density) = (scene.depth_of(side), water.density);
        // Westergaard's face moves away from its water where it moves downstream.
        let outwards = if side == Side::Upstream { 1.0 } else { -1.0 };
        let first = points.first().map_or(0.0, |point| point[1]);
        let heights: Vec<f64> = points.iter().map(|point| point[1] - first).collect();
        for Chosen { instant, row, at_peak } in instants(run, side.table()) {
            let Some((time, pressure)) = pressure(&run.log, unit, row as u64)? else { continue };
            if pressure.len() != heights.len() {
                continue;
            }
            let column = run.histories.column("ground_acceleration.x");
            let ground_acceleration = column.and_then(|column| column.get(row)).copied().unwrap_or(0.0);
            // the peak acceleration, in the direction that gives the pressure at the base its sign
            let towards = -outwards * pressure.first().copied().unwrap_or(0.0).signum();
            let parabola_acceleration = towards * peak_acceleration;
            let parabola = |i: u32| {
                // Closer together where the parabola is steep.
                let y = depth * (1.0 - (1.0 - f64::from(i) / f64::from(POINTS)).powi(2));
                [y, westergaard::pressure(outwards * parabola_acceleration, density, depth, y)]
            };
            let westergaard = if at_peak { (0..=POINTS).map(parabola).collect() } else { Vec::new() };
            profiles.push(Profile {
                instant: instant.to_owned(),
                water: side.table().to_owned(),
                time,
                ground_acceleration,
                computed: heights.iter().zip(&pressure).map(|(y, p)| [*y, *p]).collect(),
                parabola_acceleration,
                westergaard,
            });
        }
    }
    Ok(profiles)
}

/// An instant, s, and the pressure then: heights above the foot of the face, m, and pressures, Pa.
pub type Instant = (f64, Vec<[f64; 2]>);

/// The instant of `run` that is nearest to `time` (s), and the pressure on the face of `water` then: heights above its foot, m, and
/// pressures, Pa. None where the run has no such water or pressure, or no step there.
///
/// **Errors**: the log cannot be read.
pub fn nearest(run: &RunFolder, water: &str, time: f64) -> Result<Option<Instant>, LogReadError> {
    let scene = &run.loaded.scene;
    let of = scene.waters().enumerate().find(|(_, (side, _))| side.table() == water);
    let Some((index, (side, _))) = of.filter(|_| scene.log.exchanges != LoggedExchanges::None) else {
        return Ok(None);
    };
    let times = run.histories.column("time").unwrap_or(&[]);
    let away = |row: &usize| (times[*row] - time).abs();
    let Some(row) = (0..times.len()).min_by(|a, b| away(a).total_cmp(&away(b))) else { return Ok(None) };
    let before = row.saturating_sub(1);
    let step = times.get(before + 1).map_or(0.0, |end| end - times[before]);
    if away(&row) > step {
        return Ok(None);
    }
    let points = points(run, side);
    let first = points.first().map_or(0.0, |point| point[1]);
    let found = pressure(&run.log, UnitId(index + 1), row as u64)?;
    Ok(found.filter(|(_, pressure)| pressure.len() == points.len()).map(|(end, pressure)| {
        (end, points.iter().zip(&pressure).map(|(point, pressure)| [point[1] - first, *pressure]).collect())
    }))
}

/// The points of a water, m.
pub fn points(run: &RunFolder, side: Side) -> &[[f64; 2]] {
    let manifest = &run.manifest;
    match side {
        Side::Upstream => manifest.reservoir_wet_face.as_ref().unwrap_or(&manifest.wet_face),
        Side::Downstream => {
            let face = manifest.further_wet_faces.iter().find(|face| face.water == side.table());
            face.map_or(&[], |face| face.own_points.as_ref().unwrap_or(&face.points))
        }
    }
}

/// An instant that is shown.
struct Chosen {
    instant: &'static str,
    /// Its row in the histories.
    row: usize,
    /// Whether something peaks then, so that the pressure compares with that of the peak ground acceleration.
    at_peak: bool,
}

/// The chosen instants.
fn instants(run: &RunFolder, water: &str) -> Vec<Chosen> {
    let peak = |column: &str| {
        let values = run.histories.column(column)?.iter().enumerate();
        let peak = values.rev().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        (*peak.1 != 0.0).then_some(peak.0)
    };
    let chosen = [
        ("peak base pressure", peak(&format!("{water}.base_pressure")), true),
        ("peak crest displacement", peak("dam.crest_displacement.x"), true),
        ("end of the run", run.histories.rows().checked_sub(1), false),
    ];
    let found =
        chosen.into_iter().filter_map(|(instant, row, at_peak)| Some(Chosen { instant, row: row?, at_peak }));
    found.collect()
}

/// The end of `step`, s, and the accepted pressure, Pa.
fn pressure(log: &Log, unit: UnitId, step: u64) -> Result<Option<(f64, Vec<f64>)>, LogReadError> {
    let layout = &log.head().unit(unit).outputs;
    let Some(range) = layout.range("interface_pressure") else { return Ok(None) };
    for entry in log.entries_from(step)? {
        match entry {
            Ok(Entry::Exchange(exchange))
                if exchange.unit == unit && exchange.accepted && exchange.occasion.step == step =>
            {
                let pressure = exchange.outputs.as_ref().and_then(|outputs| outputs.get(range));
                return Ok(pressure.map(|pressure| (exchange.occasion.end(), pressure.to_vec())));
            }
            Ok(Entry::Step(of)) if of.occasion.step > step => break,
            Ok(_) => {}
            // A damaged log has no such exchange.
            Err(_) => break,
        }
    }
    Ok(None)
}
