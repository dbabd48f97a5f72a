use super::{Point, SHAPES, name};
use crate::figure::{decades, svg};
use crate::study::StudyError;
use cofferdam_analysis::picture::FONT;
use plotters::prelude::*;

/// Errors over the number of elements, a line for each wavenumber and shape.
pub fn picture(points: &[Point]) -> Result<String, StudyError> {
    let mut wavenumbers: Vec<f64> = points.iter().map(|p| p.wavenumber).collect();
    wavenumbers.sort_by(f64::total_cmp);
    wavenumbers.dedup();
    let across = decades(points.iter().map(|p| p.elements as f64));
    let up = decades(points.iter().map(|p| p.error));
    svg((860, 520), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Nodal forces on the face against the closed form", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(across.log_scale(), up.log_scale())?;
        chart
            .configure_mesh()
            .x_desc("elements on the face")
            .y_desc("relative error")
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .draw()?;
        for (order, width) in SHAPES.into_iter().zip(1..) {
            for (index, wavenumber) in wavenumbers.iter().enumerate() {
                let colour = Palette99::pick(index).to_rgba();
                let style = colour.stroke_width(width);
                let line = points.iter().filter(|p| p.order == order && p.wavenumber == *wavenumber);
                chart
                    .draw_series(
                        LineSeries::new(line.map(|p| (p.elements as f64, p.error)), style).point_size(3),
                    )?
                    .label(format!("{}, kh = {wavenumber}", name(order)))
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
            }
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerLeft).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
}
