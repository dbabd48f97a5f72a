//! `cofferdam log plot`.

use super::Failure;
use super::error::write_new;
use crate::terminal::print;
use cofferdam_analysis::picture::{BLUE, Drawing, FONT, svg};
use cofferdam_log::{AcceptedSteps, Log, Quantity};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::PathBuf;

/// Arguments of `cofferdam log plot`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Variables to plot, one panel each
    #[arg(required = true, value_name = "VARIABLE")]
    variables: Vec<String>,
    /// Start of the plot, s
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = seconds, allow_hyphen_values = true)]
    from: f64,
    /// End of the plot, s (default: end of the run)
    #[arg(long, value_name = "T", value_parser = seconds, allow_hyphen_values = true)]
    until: Option<f64>,
    /// SVG file to write (default: standard output)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| "expected a number of seconds".to_owned())
}

pub const HELP: &str = "\
Plots the accepted values at the ends of the steps. Variables have the same
names as in histories.csv: those of the coupling (iterations, converged,
residual.pressure, interpolation_error, lowest_pressure; also
communication_step and attempt) and those of the units. A suffix `.x`, `.y`,
`.0` or `[0]` selects a value of an array; without one, the norm is plotted.

Examples:
  cofferdam log plot runs/koyna dam.crest_displacement.x \\
    reservoir.total_force iterations --output koyna.svg
  cofferdam log plot runs/koyna 'reservoir.interface_pressure[3]' \\
    --from 4 --until 6 > pressure.svg

Exit status: 0, also for a log that is cut short; 1 if it cannot be read or is
damaged, or the plot cannot be written; 2 a variable is unknown or no step ends
in the interval.";

/// Width of the picture and height of a panel, pixels.
const SIZE: (u32, u32) = (960, 230);

/// Time and value at the ends of steps.
type Points = Vec<(f64, f64)>;

/// Draws histories.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    let unknown = |cause| Failure::Variable { path: log.path().to_owned(), cause };
    let named = |name: &String| Quantity::named(log.head(), name).map_err(unknown);
    let quantities = arguments.variables.iter().map(named).collect::<Result<Vec<_>, _>>()?;
    if let Some(path) = arguments.output.as_ref().filter(|path| path.exists()) {
        return Err(Failure::Exists { path: path.clone() });
    }
    let until = arguments.until.unwrap_or(f64::INFINITY);
    let mut panels: Vec<Points> = vec![Vec::new(); quantities.len()];
    let mut end = 0.0;
    let mut damage = None;
    for step in AcceptedSteps::of(&log)? {
        let step = match step {
            Ok(step) => step,
            Err(error) => {
                damage = Some(error);
                break;
            }
        };
        end = step.step.occasion.end();
        if (arguments.from..=until).contains(&end) {
            for (points, quantity) in panels.iter_mut().zip(&quantities) {
                points.push((end, quantity.value(&step)));
            }
        }
    }
    if panels[0].is_empty() {
        let path = log.path().to_owned();
        return Err(damage.map_or(Failure::Span { path, from: arguments.from, until, end }, Failure::Log));
    }
    let shown: Vec<_> = quantities.iter().zip(&panels).collect();
    let path = arguments.output.clone().unwrap_or_else(|| "picture".into());
    let picture = svg((SIZE.0, SIZE.1 * panels.len() as u32), |area| draw(area, &shown))
        .map_err(|cause| Failure::Write { path: path.clone(), cause })?;
    match &arguments.output {
        None => print(picture.trim_end()),
        Some(path) => {
            write_new(path, &picture)?;
            print(format!("{}: {} steps to t = {end:.4} s", path.display(), panels[0].len()));
        }
    }
    damage.map_or(Ok(()), |error| Err(error.into()))
}

/// A panel below another, all over the same time.
fn draw(area: &DrawingArea<SVGBackend<'_>, Shift>, shown: &[(&Quantity, &Points)]) -> Drawing {
    for (panel, (quantity, points)) in area.split_evenly((shown.len(), 1)).iter().zip(shown) {
        let finite = || points.iter().map(|(_, value)| *value).filter(|value| value.is_finite());
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        // A constant value lies in the middle.
        let margin = if high > low { 0.05 * (high - low) } else { (0.1 * high.abs()).max(1e-300) };
        let (first, last) = (points[0].0, points[points.len() - 1].0);
        let last = if last > first { last } else { first + 1e-3 };
        let title =
            if quantity.is_norm() { format!("norm of {}", quantity.name) } else { quantity.name.clone() };
        let mut chart = ChartBuilder::on(panel)
            .caption(title, (FONT, 14))
            .margin(10)
            .x_label_area_size(34)
            .y_label_area_size(90)
            .build_cartesian_2d(first..last, low - margin..high + margin)?;
        let number = |value: &f64| if *value == 0.0 { "0".to_owned() } else { format!("{value:.3e}") };
        chart
            .configure_mesh()
            .y_label_formatter(&number)
            .x_desc("t, s")
            .y_desc(if quantity.unit == "1" { "" } else { &quantity.unit })
            .draw()?;
        chart.draw_series(LineSeries::new(thinned(points, SIZE.0 as usize), BLUE))?;
    }
    Ok(())
}

/// Of all points that fall into one of `columns` the first, least, largest and last: what a line through all would show.
fn thinned(points: &[(f64, f64)], columns: usize) -> Points {
    let length = points.len().div_ceil(columns);
    if length <= 4 {
        return points.to_vec();
    }
    let mut kept = Points::new();
    for group in points.chunks(length) {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let extremes =
            [group.first(), group.iter().min_by(by_value), group.iter().max_by(by_value), group.last()];
        let mut of_group: Points = extremes.into_iter().flatten().copied().collect();
        of_group.sort_by(|a, b| a.0.total_cmp(&b.0));
        of_group.dedup();
        kept.extend(of_group);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_points_keep_extremes_and_ends() {
        let points: Points = (0..100_000).map(|i| (f64::from(i), f64::from((i * 7919) % 1000))).collect();
        let kept = thinned(&points, 100);
        assert!(kept.len() <= 400 && kept.is_sorted_by(|a, b| a.0 < b.0), "{}", kept.len());
        assert_eq!([kept[0], kept[kept.len() - 1]], [points[0], points[points.len() - 1]]);
        let extremes =
            |of: &Points| of.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
        assert_eq!(extremes(&kept), extremes(&points));
        assert_eq!(thinned(&points[..300], 100), points[..300]);
    }
}
