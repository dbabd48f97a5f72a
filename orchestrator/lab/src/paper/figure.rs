//! The pictures.

use super::numbers::Number;
use crate::figure::svg;
use crate::study::StudyError;
use cofferdam_analysis::picture::{self, BLUE, FONT, History, ORANGE};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const WIDTH: u32 = 900;
/// Height of a panel, of a line of text, and of the heading.
const HEIGHTS: [u32; 3] = [250, 16, 28];
/// Characters of a line of text.
const COLUMNS: usize = 165;
/// Least ratio that is drawn; a smaller one is drawn there.
const SMALLEST: f64 = 1e-3;

/// Label of the axis, and the lines above it.
pub type Panel = (String, Vec<History>);

/// Panels one below the other under a heading; below them what must be known to read them.
pub fn histories(title: &str, notes: &[String], panels: &[Panel]) -> Result<String, StudyError> {
    let lines: Vec<_> = notes.iter().flat_map(|note| textwrap::wrap(note, COLUMNS)).collect();
    let [panel, line, heading] = HEIGHTS;
    let of_panels = panel * panels.len() as u32;
    svg((WIDTH, heading + of_panels + line * (lines.len() as u32 + 1)), |area| {
        let area = area.titled(title, (FONT, 16))?;
        let (upper, lower) = area.split_vertically(of_panels);
        for (area, (name, lines)) in upper.split_evenly((panels.len(), 1)).iter().zip(panels) {
            picture::over_time(area, name, lines)?;
        }
        for (row, text) in lines.iter().enumerate() {
            let place = (14, (line as usize * row) as i32 + 4);
            lower.draw(&Text::new(text.clone(), place, (FONT, 12)))?;
        }
        Ok(())
    })
}

/// Ours over the paper's, for each number a dot, and a bar over the open choices, on a logarithmic scale.
pub fn ratios(title: &str, numbers: &[Number]) -> Result<String, StudyError> {
    // The ends of the bar, without a sweep the dot itself.
    let ratios: Vec<[f64; 3]> = numbers
        .iter()
        .map(|number| {
            let [least, most] = number.range.unwrap_or([number.ours; 2]);
            [least, number.ours, most].map(|value| (value / number.paper).max(SMALLEST))
        })
        .collect();
    let (left, right) = ratios
        .iter()
        .flatten()
        .fold((0.5, 2.0), |(a, b): (f64, f64), ratio| (a.min(0.8 * ratio), b.max(1.3 * ratio)));
    let count = numbers.len() as f64;
    svg((WIDTH, 90 + 26 * numbers.len() as u32), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(title, (FONT, 16))
            .margin(12)
            .margin_left(400)
            .x_label_area_size(40)
            .build_cartesian_2d((left..right).log_scale(), count..0.0)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .disable_y_axis()
            .light_line_style(TRANSPARENT)
            .x_desc("ours over the paper's; bars: the open choices")
            .x_label_formatter(&|x| cofferdam_unit::number::plain(*x))
            .draw()?;
        chart.draw_series([PathElement::new([(1.0, 0.0), (1.0, count)], BLACK.stroke_width(1))])?;
        for (row, (number, [least, ours, most])) in numbers.iter().zip(ratios).enumerate() {
            let middle = row as f64 + 0.5;
            let bar = [(least, middle - 0.25), (most, middle + 0.25)];
            chart.draw_series([Rectangle::new(bar, BLUE.mix(0.4).filled())])?;
            chart.draw_series([Circle::new((ours, middle), 4, ORANGE.filled())])?;
            let style = TextStyle::from((FONT, 13)).pos(Pos::new(HPos::Right, VPos::Center));
            let name = EmptyElement::at((left, middle)) + Text::new(number.label(), (-6, 0), style);
            chart.draw_series([name])?;
        }
        Ok(())
    })
}
