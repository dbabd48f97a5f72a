use super::Row;
use crate::figure::{Line, svg};
use crate::study::StudyError;
use cofferdam_analysis::picture::{BLUE, FONT, ORANGE};
use plotters::prelude::*;

/// Errors over the length of the paper's windows.
pub fn picture(rows: &[Row]) -> Result<String, StudyError> {
    let crest: Vec<(f64, f64)> =
        rows.iter().filter_map(|row| Some((row.length, 100.0 * row.crest?))).collect();
    let lines: [Line<'_>; 2] = [
        ("base pressure on a rigid dam", BLUE, rows.iter().map(|r| (r.length, 100.0 * r.base)).collect()),
        ("crest displacement, coupled", ORANGE, crest),
    ];
    let most = lines.iter().flat_map(|(.., line)| line).fold(1.0, |most: f64, (_, e)| most.max(*e));
    let (shortest, longest) =
        rows.iter().fold((f64::MAX, f64::MIN), |(a, b), row| (a.min(row.length), b.max(row.length)));
    // A single length has no width.
    let (shortest, longest) = if longest > shortest { (shortest, longest) } else { (0.05, 5.0) };
    svg((760, 420), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Errors of the paper's windows", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d((shortest..longest).log_scale(), 0.0..1.05 * most)?;
        chart.configure_mesh().x_desc("length of a window, s").y_desc("relative L2 error, %").draw()?;
        for (label, color, line) in lines.into_iter().filter(|(.., line)| !line.is_empty()) {
            chart
                .draw_series(LineSeries::new(line, color.stroke_width(2)).point_size(3))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(2)));
        }
        chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw()?;
        Ok(())
    })
}
