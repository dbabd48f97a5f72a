//! `cofferdam reservoir record`.

use super::figure;
use super::points::{Points, Shown, force_and_moment};
use super::{Common, Failure, undrawn};
use crate::terminal::print;
use cofferdam_analysis::picture::History;
use cofferdam_analysis::table::Table;
use cofferdam_reservoir::{ReservoirParameters, pressure_of_record};
use nalgebra::DMatrix;

/// Arguments of `cofferdam reservoir record`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,

    #[command(flatten)]
    points: Points,
}

pub const HELP: &str = "\
A rigid dam on rigid rock moves with the ground motion of the scene. The
pressure on the dam is computed from the frequency response for the whole
simulated time at once, without a deformable dam and without iterations. The
ground acceleration is linear between communication points. Compressible water
is computed by a damped Fourier transform with the communication step,
independent of `reservoir.method`; water without memory by its added mass.

The columns of record.csv are time [s], the ground acceleration [m/s2], with
vertical ground motion also the vertical acceleration [m/s2], the pressure at
the base and at every point [Pa], the horizontal force on the wet face [N/m] and
the overturning moment about the heel [N·m/m]. record.svg plots them. The peaks
are printed, also relative to the hydrostatic values. Motion is positive
downstream and upwards, pressure in compression.

Examples:
  cofferdam reservoir record scenes/koyna-intact --output record
      Koyna's reservoir under the record, with a rigid dam.
  cofferdam reservoir record scenes/koyna-intact --at 0 --at 30 \\
    --set reservoir.wave_reflection_coefficient=0.5 --output record
      Two chosen points, and a bed that absorbs more.

Exit status: 0 completed, 1 results could not be written, 2 the scene or an
option is invalid, 4 the water cannot be computed.";

/// Values at an instant.
struct Row {
    time: f64,
    /// Of the ground, horizontally and, where it moves so, vertically, m/s².
    acceleration: Vec<f64>,
    /// At the base, Pa.
    base: f64,
    /// At the shown points, Pa.
    pressure: Vec<f64>,
    /// N/m.
    force: f64,
    /// N·m/m.
    moment: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    let water = common.load()?;
    let ReservoirParameters { wet_face: face, communication_step: step, density, gravity, .. } =
        &water.parameters;
    let shown = arguments.points.on(face)?;
    let vertical = water.ground_motion.vertical();
    let upwards = vertical.map_or_else(String::new, |vertical| format!(", vertical {}", vertical.source()));
    let source = water.ground_motion.source();
    print(format!("{}: {source}{upwards}, rigid dam on rigid rock", water.title));
    let axes = if vertical.is_some() { 2 } else { 1 };
    let normals = face.normals();
    let ground: Vec<[f64; 2]> = (0..=water.steps).map(|n| water.ground_motion.at(n as f64 * step)).collect();
    let motion = DMatrix::from_fn(face.len() + 2, ground.len(), |row, n| match normals.get(row) {
        Some(normal) => normal[0] * ground[n][0] + normal[1] * ground[n][1],
        None => ground[n][row - face.len()],
    });
    let pressure = pressure_of_record(&water.parameters, &motion, common.threads())?;
    let at = |time: f64, acceleration: [f64; 2], pressure: &[f64]| {
        let acceleration = acceleration[..axes].to_vec();
        let [force, moment] = force_and_moment(face, pressure);
        let shown = shown.iter().map(|point| point.of(pressure)).collect();
        Row { time, acceleration, base: pressure[0], pressure: shown, force, moment }
    };
    let rows: Vec<Row> = ground
        .iter()
        .zip(pressure.column_iter())
        .enumerate()
        .map(|(n, (ground, pressure))| at(n as f64 * step, *ground, pressure.as_slice()))
        .collect();
    let hydrostatic: Vec<f64> =
        face.points().iter().map(|point| density * gravity * (face.depth() - point[1])).collect();
    report(&rows, &at(0.0, [0.0; 2], &hydrostatic));
    let labels: Vec<String> = shown.iter().map(Shown::label).collect();
    let csv = table(&rows, axes, &labels).csv().map_err(undrawn("record.csv"))?;
    let svg = picture(&water.title, &rows, &labels).map_err(undrawn("record.svg"))?;
    common.write(&[("record.csv", csv), ("record.svg", svg)])
}

/// Prints the peaks, also relative to the hydrostatic values.
fn report(rows: &[Row], at_rest: &Row) {
    let say_peaks = |name: &str, unit: &str, value: fn(&Row) -> f64| {
        let peak = |sign: f64| {
            let most = rows.iter().max_by(|a, b| (sign * value(a)).total_cmp(&(sign * value(b))));
            let (row, whole) = (most.unwrap_or(at_rest), value(at_rest));
            let peak = value(row);
            format!("{peak:.4e} {unit} at {:.4} s, {:+.3} of the hydrostatic", row.time, peak / whole)
        };
        print(format!("{name}: at most {}; at least {}", peak(1.0), peak(-1.0)));
    };
    say_peaks("base pressure", "Pa", |row| row.base);
    say_peaks("force", "N/m", |row| row.force);
    say_peaks("overturning moment", "N·m/m", |row| row.moment);
}

fn table(rows: &[Row], axes: usize, labels: &[String]) -> Table {
    let mut headings = vec!["time [s]".to_owned(), "acceleration [m/s2]".to_owned()];
    headings.extend((axes > 1).then(|| "vertical acceleration [m/s2]".to_owned()));
    headings.push("base pressure [Pa]".to_owned());
    headings.extend(labels.iter().map(|label| format!("pressure at {label} [Pa]")));
    headings.extend(["force [N/m]".to_owned(), "overturning moment [N·m/m]".to_owned()]);
    let mut table = Table::new(headings);
    for row in rows {
        // To the picosecond, so that 4.01 is not written as 4.010000000000001.
        let time = (row.time * 1e12).round() / 1e12;
        let acceleration = row.acceleration.iter().copied();
        let cells = std::iter::once(time).chain(acceleration).chain([row.base]);
        let cells = cells.chain(row.pressure.iter().copied());
        table.row(cells.chain([row.force, row.moment]).map(|cell| cell.to_string()));
    }
    table
}

fn picture(
    title: &str,
    rows: &[Row],
    labels: &[String],
) -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    let history = |label: &str, colour: usize, value: &dyn Fn(&Row) -> f64| History {
        label: label.to_owned(),
        colour,
        dashed: false,
        points: rows.iter().map(|row| (row.time, value(row))).collect(),
    };
    let pressures: Vec<History> =
        labels.iter().enumerate().map(|(i, label)| history(label, i, &|row| row.pressure[i])).collect();
    let force = [history("force", labels.len(), &|row| row.force)];
    let title = format!("{title}: rigid dam on rigid rock");
    figure::histories(&title, &pressures, &force, ["pressure, Pa", "force, N/m"])
}
