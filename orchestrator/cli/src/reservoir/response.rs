//! `cofferdam reservoir response`.

use super::figure::{self, Curve};
use super::points::{Points, Shown, force};
use super::{Common, Failure, Water, undrawn, unfit};
use crate::terminal::{print, warn};
use cofferdam_analysis::closed_form::{Exact, Motion};
use cofferdam_analysis::parallel;
use cofferdam_analysis::table::Table;
use cofferdam_reservoir::{Complex64, ReservoirError, ReservoirParameters, frequency_response};
use nalgebra::DMatrix;
use std::num::NonZeroUsize;

/// Arguments of `cofferdam reservoir response`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,

    /// Motion of the rigid dam and the ground
    #[arg(short, long, value_enum, default_value_t = super::Motion::Horizontal)]
    motion: super::Motion,

    #[command(flatten)]
    points: Points,

    /// First frequency, rad/s (default: 0.01 ω₁, with ω₁ = πc/2h)
    #[arg(long, visible_alias = "from", value_name = "RAD/S")]
    from_omega: Option<f64>,

    /// Last frequency, rad/s (default: 6.99 ω₁)
    #[arg(long, visible_alias = "to", value_name = "RAD/S")]
    to_omega: Option<f64>,

    /// Number of equally spaced frequencies
    #[arg(long, value_name = "N", default_value_t = 350, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,

    /// Growth rate σ of the motion e^{(σ + iω)t}, 1/s; resonances are finite if it is above 0
    #[arg(long, value_name = "1/S", default_value_t = 0.0)]
    sigma: f64,
}

pub const HELP: &str = "\
A rigid dam moves with the ground as e^{iωt}, horizontally (positive
downstream) or vertically (positive up), with an acceleration of 1 m/s². The
pressures at points of the wet face and the horizontal force on the whole face
are complex amplitudes with the same time factor; compression is positive. The
response of water without memory is the same at every frequency.

The columns of response.csv are omega [rad/s]; omega/omega_1 [1], where
ω₁ = πc/2h is the first cut-off frequency over a rigid bed; and the real and
imaginary parts for every point and for the force. Columns named exact contain
the closed-form solution, if there is one: for horizontal motion, a vertical
face and a level bed (Chopra 1967; Fenves and Chopra 1984 for an absorbing bed;
Westergaard's series for water without memory); for vertical motion, a column
of water. response.svg shows amplitudes relative to ρh and ρh², and phases.

A warning lists frequencies that the elements do not resolve with six elements
per wave.

The response is infinite at a cut-off frequency over a rigid bed. Such a
frequency is omitted and reported.

Examples:
  cofferdam reservoir response scenes/koyna-intact --output response
      Base and mid-height, up to seven times the first cut-off frequency.
  cofferdam reservoir response scenes/koyna-intact --at 0 --at 30 \\
    --from-omega 1 --to-omega 60 --count 60 --output response
      Two chosen points, at 1, 2, … 60 rad/s.
  cofferdam reservoir response scenes/koyna-intact \\
    --set reservoir.wave_reflection_coefficient=0.5 --output response
      A bed that absorbs more.

Exit status: 0 completed, 1 results could not be written, 2 the scene or an
option is invalid, 4 the water cannot be computed.";

/// Number of values of response matrices that are kept at a time.
const HELD: usize = 10_000_000;

/// One frequency.
struct Row {
    s: Complex64,
    /// At the shown points (Pa per m/s²), and the force (N/m per m/s²).
    values: Vec<Complex64>,
    /// The same by the closed form.
    exact: Option<Vec<Complex64>>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { common, motion, .. } = arguments;
    let motion = Motion::from(*motion);
    let water = common.load()?;
    let frequencies = arguments.frequencies(water.first_cut_off())?;
    water.warn_of_coarse_elements(frequencies[frequencies.len() - 1].im);
    let face = &water.parameters.wet_face;
    if motion == Motion::Vertical && !water.parameters.fidelity.is_solved() {
        return Err(unfit(
            "an added mass by a formula has no moving bed; choose --motion horizontal, or `reservoir.fidelity` = \
             \"incompressible\" or \"compressible\"",
        ));
    }
    let shown = arguments.points.on(face)?;
    let exact = Exact::of(&water.parameters, motion);
    print(&water.title);
    match &exact {
        Ok(exact) => print(format!("compared with the closed form: {}", exact.source())),
        Err(why) => print(format!("no closed form: {why}")),
    }
    let normals = face.normals();
    let mut rows = Vec::new();
    let mut problems = Vec::new();
    for chunk in frequencies.chunks((HELD / (face.len() * face.len())).clamp(16, 4096)) {
        responses(&water.parameters, chunk, common.threads(), &mut |s, response| {
            let pressure = match response {
                Ok(response) => motion.of_rigid_dam(&response, &normals),
                Err(problem) => {
                    problems.push((s, problem));
                    return Ok(());
                }
            };
            // Per unit acceleration, not velocity.
            let pressure: Vec<Complex64> = pressure.into_iter().map(|p| p / s).collect();
            let mut values: Vec<Complex64> = shown.iter().map(|point| point.of(&pressure)).collect();
            values.push(force(face, &pressure));
            rows.push(Row { s, values, exact: None });
            Ok(())
        })?;
    }
    if rows.is_empty() && !problems.is_empty() {
        return Err(problems.swap_remove(0).1.into());
    }
    for (s, problem) in &problems {
        warn(format!("warning: left out ω = {} rad/s: {problem}", s.im));
    }
    if let Ok(exact) = &exact {
        beside(exact, &shown, &mut rows, common.threads());
    }
    let labels: Vec<String> = shown.iter().map(Shown::label).collect();
    print(format!("{} frequencies from {} to {} rad/s", rows.len(), rows[0].s.im, rows[rows.len() - 1].s.im));
    report(&rows, &labels);
    let table = table(&rows, &labels, water.first_cut_off());
    let csv = table.csv().map_err(undrawn("response.csv"))?;
    let picture = picture(&water, motion, &rows, &labels).map_err(undrawn("response.svg"))?;
    common.write(&[("response.csv", csv), ("response.svg", picture)])
}

impl Arguments {
    fn frequencies(&self, first_cut_off: f64) -> Result<Vec<Complex64>, Failure> {
        let from = self.from_omega.unwrap_or(0.01 * first_cut_off);
        let to = self.to_omega.unwrap_or((6.99 * first_cut_off).max(from));
        if !(from > 0.0 && from <= to && to.is_finite()) {
            return Err(unfit(format!(
                "--from-omega {from} and --to-omega {to} rad/s are no valid range; the first must be above 0 and not above the \
                 second"
            )));
        }
        if !(self.sigma >= 0.0 && self.sigma.is_finite()) {
            return Err(unfit(format!("--sigma is {} 1/s; it must be 0 or more", self.sigma)));
        }
        let apart = if self.count > 1 { (to - from) / f64::from(self.count - 1) } else { 0.0 };
        Ok((0..self.count).map(|i| Complex64::new(self.sigma, from + f64::from(i) * apart)).collect())
    }
}

/// Gives the response at every frequency, or the error, to `take`.
///
/// The library computes all given frequencies or none; after an error each half is computed separately.
fn responses(
    parameters: &ReservoirParameters,
    s: &[Complex64],
    threads: NonZeroUsize,
    take: &mut dyn FnMut(Complex64, Result<DMatrix<Complex64>, ReservoirError>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    match frequency_response(parameters, s, threads) {
        Ok(all) => s.iter().zip(all).try_for_each(|(s, response)| take(*s, Ok(response))),
        Err(problem) if s.len() == 1 => take(s[0], Err(problem)),
        Err(_) => {
            let (first, second) = s.split_at(s.len() / 2);
            responses(parameters, first, threads, take)?;
            responses(parameters, second, threads, take)
        }
    }
}

/// Adds the closed form, which for an absorbing bed costs more than the solver.
fn beside(exact: &Exact, shown: &[Shown], rows: &mut [Row], threads: NonZeroUsize) {
    let elevations: Vec<f64> = shown.iter().map(|point| point.elevation).collect();
    let answers = parallel::map(rows, threads, |row| exact.at(row.s, &elevations));
    for (row, (mut values, force)) in rows.iter_mut().zip(answers) {
        values.push(force);
        row.exact = Some(values);
    }
}

/// Prints the difference of the two, in the mean square over the frequencies.
fn report(rows: &[Row], labels: &[String]) {
    let names = labels.iter().map(|label| format!("pressure at {label}"));
    for (index, name) in names.chain(std::iter::once("force".to_owned())).enumerate() {
        let (mut apart, mut size) = (0.0, 0.0);
        for row in rows {
            let Some(exact) = &row.exact else { return };
            apart += (row.values[index] - exact[index]).norm_sqr();
            size += exact[index].norm_sqr();
        }
        if size > 0.0 {
            let off = 100.0 * (apart / size).sqrt();
            print(format!("{name}: {off:.3} % from the closed form (root mean square over all frequencies)"));
        }
    }
}

fn table(rows: &[Row], labels: &[String], first_cut_off: f64) -> Table {
    let names = labels.iter().map(|label| (format!("pressure at {label}"), "Pa/(m/s2)"));
    let names: Vec<_> = names.chain(std::iter::once(("force".to_owned(), "(N/m)/(m/s2)"))).collect();
    let columns = |of: &'static str| {
        names.iter().flat_map(move |(name, unit)| {
            ["real", "imaginary"].map(|part| format!("{name}{of} {part} [{unit}]"))
        })
    };
    let exact = rows.iter().any(|row| row.exact.is_some());
    let headings = ["omega [rad/s]", "omega/omega_1 [1]"].map(str::to_owned).into_iter().chain(columns(""));
    let mut table = Table::new(headings.chain(columns(" exact").filter(|_| exact)));
    for row in rows {
        let values = row.values.iter().chain(row.exact.iter().flatten()).flat_map(|z| [z.re, z.im]);
        let cells = [row.s.im, row.s.im / first_cut_off].into_iter().chain(values);
        table.row(cells.map(|cell| cell.to_string()));
    }
    table
}

fn picture(
    water: &Water,
    motion: Motion,
    rows: &[Row],
    labels: &[String],
) -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    let (first_cut_off, parameters) = (water.first_cut_off(), &water.parameters);
    let depth = parameters.wet_face.depth();
    // Positive and in phase at low frequencies.
    let sign = if motion == Motion::Horizontal { -1.0 } else { 1.0 };
    let curve = |index: usize, label: &str, exact: bool, scale: f64| {
        let value = |row: &Row| {
            let values = if exact { row.exact.as_ref() } else { Some(&row.values) };
            values.map(|values| (row.s.im / first_cut_off, sign * values[index] / scale))
        };
        let label = if exact { format!("{label}, closed form") } else { label.to_owned() };
        Curve { label, colour: index, dashed: exact, points: rows.iter().filter_map(value).collect() }
    };
    let both = |index: usize, label: &str, scale: f64| {
        [false, true].map(|exact| curve(index, label, exact, scale)).into_iter().filter(Curve::is_there)
    };
    let scale = parameters.density * depth;
    let pressures: Vec<Curve> =
        labels.iter().enumerate().flat_map(|(i, label)| both(i, label, scale)).collect();
    let force: Vec<Curve> = both(labels.len(), "force", scale * depth).collect();
    let direction = match motion {
        Motion::Horizontal => "horizontal",
        Motion::Vertical => "vertical",
    };
    figure::response(&format!("{}: {direction} motion of a rigid dam", water.title), &pressures, &force)
}
