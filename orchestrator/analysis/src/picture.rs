//! Common parts of all pictures.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;

/// Result of drawing a picture.
pub type Drawing = Result<(), Box<dyn Error + Send + Sync>>;

/// Colour of the first line.
pub const BLUE: RGBColor = RGBColor(0x1f, 0x77, 0xb4);
/// Colour of the second line.
pub const ORANGE: RGBColor = RGBColor(0xff, 0x7f, 0x0e);
/// Colour of the third line.
pub const GREEN: RGBColor = RGBColor(0x2c, 0xa0, 0x2c);
/// Font of all texts.
pub const FONT: &str = "sans-serif";
/// Colours of lines.
const COLOURS: [RGBColor; 6] =
    [BLUE, ORANGE, GREEN, RGBColor(0xd6, 0x27, 0x28), RGBColor(0x94, 0x67, 0xbd), RGBColor(0x8c, 0x56, 0x4b)];

/// A real value over time.
pub struct History {
    /// Name in the legend; empty for none.
    pub label: String,
    /// Index of the colour.
    pub colour: usize,
    /// Whether it is drawn black and dashed.
    pub dashed: bool,
    /// Abscissa and value.
    pub points: Vec<(f64, f64)>,
}

/// Label and range of an axis.
pub struct Axis<'a> {
    /// Label, with the unit.
    pub name: &'a str,
    /// From the left or bottom end to the other.
    pub range: std::ops::Range<f64>,
}

/// An SVG of `size` that `draw` fills.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawing,
) -> Result<String, Box<dyn Error + Send + Sync>> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE)?;
        draw(&area)?;
        area.present()?;
    }
    Ok(text)
}

/// Histories over time in one chart that shows all of them, with zero.
pub fn over_time(area: &DrawingArea<SVGBackend<'_>, Shift>, name: &str, histories: &[History]) -> Drawing {
    let values = || histories.iter().flat_map(|h| h.points.iter().map(|(_, v)| *v));
    let (least, most) = values().fold((0.0f64, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    let room = 0.05 * (most - least).max(f64::MIN_POSITIVE);
    let up = Axis { name, range: least - room..most + room };
    chart(area, Axis { name: "time, s", range: across(histories) }, up, histories, true)
}

/// From the first to the last abscissa.
pub fn across(histories: &[History]) -> std::ops::Range<f64> {
    let ends = histories.iter().flat_map(|h| h.points.iter().map(|(x, _)| *x));
    let (least, most) = ends.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    // A single point has no width.
    if most > least { least..most } else { least - 0.5..least + 0.5 }
}

/// Histories in one chart; values beyond an axis are drawn at its end.
pub fn chart(
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
        let shown: Vec<(f64, f64)> = points.iter().map(|(x, v)| (*x, v.clamp(least, most))).collect();
        let series = if *dashed {
            chart.draw_series(DashedLineSeries::new(shown, 5, 4, BLACK.stroke_width(1)))?
        } else {
            chart.draw_series(LineSeries::new(shown, colour.stroke_width(2)))?
        };
        let style = if *dashed { BLACK.stroke_width(1) } else { colour.stroke_width(2) };
        if legend && !label.is_empty() {
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
