//! Pictures of the response of the water, as SVG.

use crate::cli::picture::{BLUE, Drawing, FONT, GREEN, ORANGE, svg};
use plotters::coord::Shift;
use plotters::prelude::*;
use reservoir::Complex64;
use std::error::Error;

/// A complex amplitude over ω/ω₁.
pub struct Curve {
    pub label: String,
    /// Index of the colour.
    pub colour: usize,
    pub dashed: bool,
    pub points: Vec<(f64, Complex64)>,
}

/// A real value over time.
pub struct History {
    pub label: String,
    /// Index of the colour.
    pub colour: usize,
    pub dashed: bool,
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    pub fn is_there(&self) -> bool {
        !self.points.is_empty()
    }

    fn part(&self, part: impl Fn(Complex64) -> f64) -> History {
        let points = self.points.iter().map(|(x, z)| (*x, part(*z))).collect();
        History { label: self.label.clone(), colour: self.colour, dashed: self.dashed, points }
    }
}

const COLOURS: [RGBColor; 6] =
    [BLUE, ORANGE, GREEN, RGBColor(0xd6, 0x27, 0x28), RGBColor(0x94, 0x67, 0xbd), RGBColor(0x8c, 0x56, 0x4b)];
/// Share of the amplitudes that an axis covers; resonances exceed it.
const SHOWN: f64 = 0.95;

/// Label and range of an axis.
struct Axis<'a> {
    name: &'a str,
    range: std::ops::Range<f64>,
}

type Picture = Result<String, Box<dyn Error + Send + Sync>>;

/// Amplitude above and phase below, of pressures on the left and of the force on the right.
pub fn response(title: &str, pressures: &[Curve], force: &[Curve]) -> Picture {
    svg((1000, 700), |area| {
        let panels = area.titled(title, (FONT, 16))?.split_evenly((2, 2));
        for (column, (curves, name)) in
            [(pressures, "|p| / ρh per m/s²"), (force, "|F| / ρh² per m/s²")].into_iter().enumerate()
        {
            let amplitudes: Vec<History> = curves.iter().map(|c| c.part(|z| z.norm())).collect();
            let phases: Vec<History> = curves.iter().map(|c| c.part(|z| z.arg().to_degrees())).collect();
            let over = || Axis { name: "ω / ω₁", range: across(&amplitudes) };
            let up = Axis { name, range: 0.0..1.1 * typical(&amplitudes) };
            chart(&panels[column], over(), up, &amplitudes, true)?;
            let up = Axis { name: "phase, °", range: -190.0..190.0 };
            chart(&panels[2 + column], over(), up, &phases, false)?;
        }
        Ok(())
    })
}

/// Pressures above, the force below, over time.
pub fn histories(title: &str, pressures: &[History], force: &[History], [p, f]: [&str; 2]) -> Picture {
    svg((900, 700), |area| {
        let panels = area.titled(title, (FONT, 16))?.split_evenly((2, 1));
        for (panel, histories, name) in [(&panels[0], pressures, p), (&panels[1], force, f)] {
            let values = || histories.iter().flat_map(|h| h.points.iter().map(|(_, v)| *v));
            let (least, most) = values().fold((0.0f64, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
            let room = 0.05 * (most - least).max(f64::MIN_POSITIVE);
            let up = Axis { name, range: least - room..most + room };
            chart(panel, Axis { name: "time, s", range: across(histories) }, up, histories, true)?;
        }
        Ok(())
    })
}

/// From the first to the last abscissa.
fn across(histories: &[History]) -> std::ops::Range<f64> {
    let ends = histories.iter().flat_map(|h| h.points.iter().map(|(x, _)| *x));
    let (least, most) = ends.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    // A single point has no width.
    if most > least { least..most } else { least - 0.5..least + 0.5 }
}

/// Bound of most values.
fn typical(histories: &[History]) -> f64 {
    let mut values: Vec<f64> = histories.iter().flat_map(|h| h.points.iter().map(|(_, v)| *v)).collect();
    values.sort_by(f64::total_cmp);
    let index = (SHOWN * values.len() as f64) as usize;
    values.get(index.min(values.len().saturating_sub(1))).copied().unwrap_or(1.0).max(1e-300)
}

fn chart(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    across: Axis<'_>,
    up: Axis<'_>,
    histories: &[History],
    legend: bool,
) -> Drawing {
    let (least, most) = (up.range.start, up.range.end);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(36)
        .y_label_area_size(64)
        .build_cartesian_2d(across.range, up.range)?;
    chart.configure_mesh().x_desc(across.name).y_desc(up.name).light_line_style(TRANSPARENT).draw()?;
    for History { label, colour, dashed, points } in histories {
        let colour = COLOURS[colour % COLOURS.len()];
        // Values beyond the axis are drawn at its end.
        let shown: Vec<(f64, f64)> = points.iter().map(|(x, v)| (*x, v.clamp(least, most))).collect();
        let series = if *dashed {
            chart.draw_series(DashedLineSeries::new(shown, 5, 4, BLACK.stroke_width(1)))?
        } else {
            chart.draw_series(LineSeries::new(shown, colour.stroke_width(2)))?
        };
        let style = if *dashed { BLACK.stroke_width(1) } else { colour.stroke_width(2) };
        if legend {
            series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
    }
    if legend {
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperRight).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
    }
    Ok(())
}
