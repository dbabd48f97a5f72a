//! `cofferdam reservoir impulse`.

use super::figure;
use super::points::{Points, Shown, force};
use super::{Common, Failure, Water, undrawn, unfit};
use crate::terminal::{print, warn};
use cofferdam_analysis::closed_form::{Exact, Motion};
use cofferdam_analysis::picture::History;
use cofferdam_analysis::table::Table;
use cofferdam_reservoir::{Complex64, Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir::{GROUND_ACCELERATION, INTERFACE_ACCELERATION, INTERFACE_PRESSURE};
use cofferdam_unit::{CoSimulation, Level, Messages};

/// Arguments of `cofferdam reservoir impulse`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,

    /// Motion of the rigid dam and the ground
    #[arg(short, long, value_enum, default_value_t = super::Motion::Horizontal)]
    motion: super::Motion,

    #[command(flatten)]
    points: Points,

    /// Simulated time, s (default: ten periods 4h/c)
    #[arg(long, value_name = "S")]
    duration: Option<f64>,

    /// Also compute a ramp to 1 m/s² within this time, s; the acceleration is then held
    #[arg(long, value_name = "S")]
    ramp: Option<f64>,
}

pub const HELP: &str = "\
The reservoir unit takes the communication steps of the scene with the method
of the scene; a rigid dam moves with the ground. The impulse is a triangle of
acceleration: from 0 to 1/H at the end of the first step H, and back to 0 at
the end of the second. The velocity of the dam is 1 m/s from then on. With
--ramp T, an acceleration that rises to 1 m/s² within T and then stays constant
is computed too.

The columns of impulse.csv and ramp.csv are time [s], acceleration [m/s2], the
pressure at every point [Pa] and the horizontal force on the wet face [N/m]. A
column named exact contains the closed-form base pressure for the same
acceleration (Chopra 1967), if there is one: for horizontal motion, a vertical
face and a level rigid bed. impulse.svg and ramp.svg plot them. Motion is
positive downstream or up, pressure in compression.

Water without memory responds to an impulse with an impulse, which a history
cannot show; use `reservoir response` for its added mass.

Examples:
  cofferdam reservoir impulse scenes/koyna-intact --output impulse
      Ten periods of the reservoir after the impulse.
  cofferdam reservoir impulse scenes/rigid-dam-ramp --ramp 0.1 --duration 2 \\
    --set reservoir.method=bdf2 --output impulse
      Impulse and ramp with another method.

Exit status: 0 completed, 1 results could not be written, 2 the scene or an
option is invalid, 4 the water cannot be computed.";

/// Largest number of communication steps.
const MOST_STEPS: f64 = 1e6;

/// Acceleration, pressures and force at the end of a step.
struct Row {
    time: f64,
    acceleration: f64,
    /// At the shown points, Pa.
    pressure: Vec<f64>,
    /// N/m.
    force: f64,
    /// Pressure at the base by the closed form, Pa.
    exact: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { common, motion, ramp, .. } = arguments;
    let motion = Motion::from(*motion);
    let mut water = common.load()?;
    if !water.parameters.fidelity.has_memory() {
        return Err(unfit(
            "water without memory responds to an impulse with an impulse; use `cofferdam reservoir response`, or choose \
             `reservoir.fidelity` = \"compressible\"",
        ));
    }
    let (face, step) = (water.parameters.wet_face.clone(), water.parameters.communication_step);
    let duration = arguments.duration.unwrap_or(40.0 * face.depth() / water.parameters.sound_speed);
    if !(duration >= 2.0 * step && duration / step <= MOST_STEPS) {
        return Err(unfit(format!(
            "--duration is {duration} s; it must be two to {MOST_STEPS:e} communication steps of {step} s"
        )));
    }
    if let Some(rise) = ramp.filter(|rise| !(*rise > 0.0 && rise.is_finite())) {
        return Err(unfit(format!("--ramp is {rise} s; it must be greater than 0")));
    }
    let shown = arguments.points.on(&face)?;
    let exact = Exact::of(&water.parameters, motion).and_then(Exact::with_history);
    print(&water.title);
    match &exact {
        Ok(exact) => print(format!("base compared with the closed form: {}", exact.source())),
        Err(why) => print(format!("no closed form: {why}")),
    }
    let steps = (duration / step - 1e-9).ceil() as usize;
    water.parameters.horizon = steps as f64 * step;
    let (messages, threads) = (Messages::default(), common.threads());
    let mut unit = messages.listen(|| Reservoir::new(water.parameters.clone(), threads))?;
    for (_, _, text) in messages.take().into_iter().filter(|(level, ..)| *level == Level::Warning) {
        warn(format!("warning: {text}"));
    }
    unit.initialise(0.0)?;
    let start = unit.save_state();
    let mut files = Vec::new();
    let cases = [
        Some((["impulse.csv", "impulse.svg"], Case::Impulse)),
        ramp.map(|rise| (["ramp.csv", "ramp.svg"], Case::Ramp(rise))),
    ];
    for ([csv, svg], case) in cases.into_iter().flatten() {
        unit.restore_state(&start)?;
        let samples: Vec<f64> = (0..=steps).map(|n| case.acceleration(n, step)).collect();
        let rows = stepped(&mut unit, motion, &shown, &samples, exact.as_ref().ok())?;
        report(case, &rows, &shown);
        files.push((csv, table(&rows, &shown).csv().map_err(undrawn(csv))?));
        files.push((svg, picture(&water, case, &rows, &shown).map_err(undrawn(svg))?));
    }
    common.write(&files)
}

#[derive(Clone, Copy)]
enum Case {
    Impulse,
    /// Rise time, s.
    Ramp(f64),
}

impl Case {
    fn name(self) -> &'static str {
        match self {
            Self::Impulse => "impulse",
            Self::Ramp(_) => "ramp",
        }
    }

    /// At the end of step `n`, linear in between, m/s².
    fn acceleration(self, n: usize, step: f64) -> f64 {
        match self {
            Self::Impulse if n == 1 => 1.0 / step,
            Self::Impulse => 0.0,
            Self::Ramp(rise) => (n as f64 * step / rise).min(1.0),
        }
    }
}

/// Takes a step for each acceleration (m/s²) except the first.
fn stepped(
    unit: &mut Reservoir,
    motion: Motion,
    shown: &[Shown],
    samples: &[f64],
    exact: Option<&Exact>,
) -> Result<Vec<Row>, ReservoirError> {
    let ReservoirParameters { wet_face: face, communication_step: step, .. } = unit.parameters().clone();
    let along: Vec<f64> = face.normals().iter().map(|n| n[motion.axis()]).collect();
    let record: Vec<(f64, f64)> = samples.iter().enumerate().map(|(n, a)| (n as f64 * step, *a)).collect();
    let record = without_straight(&record);
    let mut rows = Vec::with_capacity(samples.len());
    let mut pressure = vec![0.0; face.len()];
    for (n, &acceleration) in samples.iter().enumerate() {
        let time = n as f64 * step;
        if n > 0 {
            let mean = 0.5 * (samples[n - 1] + acceleration);
            let moved: Vec<f64> = along.iter().map(|n| mean * n).collect();
            unit.set(INTERFACE_ACCELERATION.value_reference, &moved)?;
            let mut ground = [0.0; 2];
            ground[motion.axis()] = acceleration;
            unit.set(GROUND_ACCELERATION.value_reference, &ground)?;
            unit.step((n - 1) as f64 * step, step)?;
            unit.get(INTERFACE_PRESSURE.value_reference, &mut pressure)?;
        }
        let complex: Vec<Complex64> = pressure.iter().map(|p| Complex64::from(*p)).collect();
        rows.push(Row {
            time,
            acceleration,
            pressure: shown.iter().map(|point| point.of(&complex).re).collect(),
            force: force(&face, &complex).re,
            exact: exact.map(|exact| exact.base_pressure(&record, time)),
        });
    }
    Ok(rows)
}

/// A record without points on the straight line between their neighbours.
fn without_straight(record: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let slope = |a: &(f64, f64), b: &(f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    let bends = |i: &usize| {
        let (before, at) = (&record[i - 1], &record[*i]);
        record.get(i + 1).is_none_or(|after| (slope(before, at) - slope(at, after)).abs() > 1e-9)
    };
    let inner = (1..record.len()).filter(bends).map(|i| record[i]);
    record.first().copied().into_iter().chain(inner).collect()
}

fn at_base(shown: &[Shown]) -> Option<usize> {
    shown.iter().position(|point| point.elevation == 0.0)
}

/// Prints the difference of the base pressure from the closed form, in the mean square over time.
fn report(case: Case, rows: &[Row], shown: &[Shown]) {
    let peak = rows.iter().fold(0.0f64, |most, row| most.max(row.force.abs()));
    print(format!("{}: {} steps, force at most {peak:.4e} N/m", case.name(), rows.len() - 1));
    let Some(base) = at_base(shown) else { return };
    let (mut apart, mut size) = (0.0, 0.0);
    for row in rows {
        let Some(exact) = row.exact else { return };
        apart += (row.pressure[base] - exact).powi(2);
        size += exact * exact;
    }
    let off = 100.0 * (apart / size).sqrt();
    print(format!(
        "{}: pressure at the base {off:.3} % from the closed form (root mean square over time)",
        case.name()
    ));
}

fn table(rows: &[Row], shown: &[Shown]) -> Table {
    let base = at_base(shown).filter(|_| rows.iter().any(|row| row.exact.is_some()));
    let points = shown.iter().map(|point| format!("pressure at {} [Pa]", point.label()));
    let mut headings = vec!["time [s]".to_owned(), "acceleration [m/s2]".to_owned()];
    headings.extend(points.chain(std::iter::once("force [N/m]".to_owned())));
    headings.extend(base.map(|base| format!("pressure at {} exact [Pa]", shown[base].label())));
    let mut table = Table::new(headings);
    for row in rows {
        // To the picosecond, so that 4.01 is not written as 4.010000000000001.
        let time = (row.time * 1e12).round() / 1e12;
        let first = [time, row.acceleration];
        let cells = first.into_iter().chain(row.pressure.iter().copied()).chain([row.force]);
        let cells = cells.chain(row.exact.filter(|_| base.is_some()));
        table.row(cells.map(|cell| cell.to_string()));
    }
    table
}

fn picture(
    water: &Water,
    case: Case,
    rows: &[Row],
    shown: &[Shown],
) -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    let history = |label: String, colour: usize, dashed: bool, value: &dyn Fn(&Row) -> Option<f64>| History {
        label,
        colour,
        dashed,
        points: rows.iter().filter_map(|row| Some((row.time, value(row)?))).collect(),
    };
    let mut pressures: Vec<History> = shown
        .iter()
        .enumerate()
        .map(|(i, point)| history(point.label(), i, false, &|row| Some(row.pressure[i])))
        .collect();
    if let Some(base) = at_base(shown) {
        let exact = history("base, closed form".to_owned(), base, true, &|row| row.exact);
        pressures.extend(Some(exact).filter(|exact| !exact.points.is_empty()));
    }
    let force = [history("force".to_owned(), shown.len(), false, &|row| Some(row.force))];
    let title = match case {
        Case::Impulse => format!(
            "{}: rigid dam, 1 m/s from t = {} s on",
            water.title,
            2.0 * water.parameters.communication_step
        ),
        Case::Ramp(rise) => format!("{}: rigid dam, ramp to 1 m/s² within {rise} s", water.title),
    };
    figure::histories(&title, &pressures, &force, ["pressure, Pa", "force, N/m"])
}
