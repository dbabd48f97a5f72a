//! Pictures of an ensemble.

use super::EnsembleError;
use super::runs::{LimitResult, Runs, SHOWN};
use super::target::Scaled;
use crate::picture::{BLUE, FONT, GREEN, ORANGE, svg};
use crate::statistics::{Curve, quantile};
use cofferdam_motion::STANDARD_GRAVITY;
use plotters::prelude::*;

const SIZE: (u32, u32) = (900, 520);
/// Grid lines of an axis, at most.
const GRID: usize = 6;

/// Intensity over a quantity: a thin line for each motion, thick ones for 16, 50 and 84 % of the runs of a level.
pub fn analysis(
    measure: &str,
    label: &str,
    lines: &[Vec<(f64, f64)>],
    summary: &[(f64, [f64; 3])],
) -> Result<String, EnsembleError> {
    let most = |of: fn(&(f64, f64)) -> f64| lines.iter().flatten().map(of).fold(0.0, f64::max).max(1e-9);
    let (right, top) = (1.05 * most(|point| point.0), 1.05 * most(|point| point.1));
    svg(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Incremental dynamic analysis", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..right, 0.0..top)?;
        let mut mesh = chart.configure_mesh();
        mesh.x_labels(GRID).y_labels(GRID.min(levels_of(summary))).max_light_lines(0);
        mesh.x_desc(label).y_desc(format!("{measure}, g")).draw()?;
        let grey = RGBColor(0x80, 0x80, 0x80).mix(0.5);
        for line in lines {
            let from_rest = std::iter::once((0.0, 0.0)).chain(line.iter().copied());
            chart.draw_series(LineSeries::new(from_rest, grey.stroke_width(1)))?;
        }
        for (index, (name, colour)) in
            [("16 %", GREEN), ("median", BLUE), ("84 %", ORANGE)].into_iter().enumerate()
        {
            let points = summary.iter().map(move |(intensity, values)| (values[index], *intensity));
            let from_rest = std::iter::once((0.0, 0.0)).chain(points);
            chart
                .draw_series(LineSeries::new(from_rest, colour.stroke_width(3)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerRight).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
    .map_err(EnsembleError::Format)
}

/// The scaled spectra of the records, their geometric mean, and the target.
pub fn spectra(scaled: &Scaled) -> Result<String, EnsembleError> {
    let in_gravity = |spectrum: &[f64]| -> Vec<(f64, f64)> {
        scaled.periods.iter().zip(spectrum).map(|(period, sa)| (*period, sa / STANDARD_GRAVITY)).collect()
    };
    let lines: Vec<Vec<(f64, f64)>> = scaled.spectra.iter().map(|spectrum| in_gravity(spectrum)).collect();
    let target = in_gravity(&scaled.target);
    let mean = |i: usize| {
        let logarithms = lines.iter().map(|line| line[i].1.ln());
        (scaled.periods[i], (logarithms.sum::<f64>() / lines.len() as f64).exp())
    };
    let mean: Vec<(f64, f64)> = (0..scaled.periods.len()).map(mean).collect();
    let all = || lines.iter().flatten().chain(&target).map(|point| point.1);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let [from, to] = [mean.first(), mean.last()].map(|point| point.map_or(1.0, |point| point.0));
    svg(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Records scaled to the target spectrum, 5 % damping", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d((from..to).log_scale(), (0.9 * low..1.1 * high).log_scale())?;
        let mut mesh = chart.configure_mesh();
        mesh.x_labels(GRID).y_labels(GRID).max_light_lines(0);
        mesh.x_desc("period, s").y_desc("spectral acceleration, g").draw()?;
        let grey = RGBColor(0x80, 0x80, 0x80).mix(0.5);
        for line in &lines {
            chart.draw_series(LineSeries::new(line.iter().copied(), grey.stroke_width(1)))?;
        }
        for (line, name, colour) in [(&mean, "geometric mean", BLUE), (&target, "target", ORANGE)] {
            chart
                .draw_series(LineSeries::new(line.iter().copied(), colour.stroke_width(3)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerLeft).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
    .map_err(EnsembleError::Format)
}

/// Number of grid lines over so many levels: no more than there are levels, but enough to read values.
fn levels_of<T>(levels: &[T]) -> usize {
    levels.len().max(3)
}

/// Share of the runs of each level that exceed each limit, with its exact interval; a curve with its band where the runs support one between the
/// weakest and the strongest shaking, a dashed one where they are separated.
pub fn fragility(
    measure: &str,
    intensities: &[f64],
    limits: &[LimitResult],
) -> Result<String, EnsembleError> {
    let right = 1.05 * intensities.last().copied().unwrap_or(1.0);
    let tested = limits.iter().map(|limit| limit.evidence.levels.len()).max().unwrap_or(0);
    svg(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Probability of exceeding a limit: runs with exact 95 % intervals", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..right, 0.0..1.0)?;
        let mut mesh = chart.configure_mesh();
        mesh.x_labels(GRID.min(tested.max(3))).y_labels(GRID).max_light_lines(0);
        mesh.x_desc(format!("{measure}, g")).y_desc("probability").draw()?;
        for (number, (limit, colour)) in
            limits.iter().zip([BLUE, ORANGE, GREEN, BLACK].into_iter().cycle()).enumerate()
        {
            let name = match &limit.evidence.curve {
                Curve::Supported(_) => limit.name(),
                Curve::Separated { .. } => format!("{}: penalised, no interval", limit.name()),
                Curve::None(_) => format!("{}: no curve", limit.name()),
            };
            if let Curve::Supported(fitted) = &limit.evidence.curve {
                let band: Vec<(f64, [f64; 2])> =
                    intensities.iter().map(|x| (*x, fitted.probability(*x).1)).collect();
                let bound = |end: usize| band.iter().map(move |(x, interval)| (*x, interval[end]));
                let outline: Vec<(f64, f64)> = bound(0).chain(bound(1).rev()).collect();
                chart.draw_series([Polygon::new(outline, colour.mix(0.15))])?;
                let curve = intensities.iter().map(|x| (*x, fitted.probability(*x).0));
                chart.draw_series(LineSeries::new(curve, colour.stroke_width(2)))?;
            } else if let Some(estimate) = limit.evidence.estimate() {
                let curve = intensities.iter().map(|x| (*x, estimate.probability(*x)));
                chart.draw_series(DashedLineSeries::new(curve, 6, 5, colour.stroke_width(1)))?;
            }
            // Points of several limits next to each other.
            let aside = 0.006 * right * (number as f64 - (limits.len() as f64 - 1.0) / 2.0);
            let levels = || limit.evidence.levels.iter().map(|level| (level.intensity + aside, level));
            chart.draw_series(levels().map(|(x, level)| {
                PathElement::new(level.interval.map(|p| (x, p)), colour.stroke_width(1))
            }))?;
            let points = levels().map(|(x, level)| Circle::new((x, level.share), 4, colour.filled()));
            chart
                .draw_series(points)?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperLeft).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
    .map_err(EnsembleError::Format)
}

impl Runs<'_> {
    /// The picture of the first limit's quantity, else of the first one that is shown, over intensity; none of one level.
    pub fn analysis(&self) -> Result<Option<String>, EnsembleError> {
        let of_limit = self.ensemble.plan.limits.first().map(|limit| limit.quantity.clone());
        let shown = self.quantities.iter().map(|(name, _)| name.clone());
        let mut shown = shown.filter(|name| SHOWN[1..].iter().any(|shown| name.starts_with(shown)));
        let Some(name) = of_limit.or_else(|| shown.next()) else { return Ok(None) };
        let levels = self.levels();
        if levels.len() < 2 {
            return Ok(None);
        }
        let unit = self.quantities.iter().find(|(other, _)| *other == name);
        let label = format!("{name}, {}", unit.map_or("", |(_, unit)| unit));
        // Runs of one motion and dam lie one after the other.
        let of_motion = (0..self.kept.len()).collect::<Vec<_>>();
        let lines = of_motion.chunks(levels.len()).map(|runs| {
            let complete = runs.iter().filter(|index| self.kept[**index].is_complete());
            let points =
                complete.map(|i| (self.kept[*i].value(&name).abs(), self.ensemble.samples[*i].intensity));
            points.filter(|(value, _)| !value.is_nan()).collect()
        });
        let of_level = |runs: &Vec<usize>| {
            let mut values: Vec<f64> = runs
                .iter()
                .map(|i| self.kept[*i].value(&name).abs())
                .filter(|value| !value.is_nan())
                .collect();
            values.sort_by(f64::total_cmp);
            let intensity =
                runs.iter().map(|i| self.ensemble.samples[*i].intensity).sum::<f64>() / runs.len() as f64;
            (!values.is_empty()).then(|| (intensity, [0.16, 0.5, 0.84].map(|share| quantile(&values, share))))
        };
        let summary: Vec<(f64, [f64; 3])> = levels.iter().filter_map(|(_, runs)| of_level(runs)).collect();
        analysis(&self.ensemble.measure, &label, &lines.collect::<Vec<_>>(), &summary).map(Some)
    }
}
