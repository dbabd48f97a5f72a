use crate::figure::{decades, svg};
use crate::study::StudyError;
use cofferdam_analysis::picture::{BLUE, FONT};
use plotters::prelude::*;

/// A water: seconds for its set-up and all of its steps, and its error.
pub struct Priced {
    pub name: String,
    pub cost: f64,
    pub error: f64,
}

/// Waters by cost and error.
pub fn picture(points: &[Priced]) -> Result<String, StudyError> {
    let (across, up) = (decades(points.iter().map(|p| p.cost)), decades(points.iter().map(|p| p.error)));
    svg((900, 520), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Cost of the water models and error against the reference", (FONT, 16))
            .margin(12)
            .margin_right(160)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(across.log_scale(), up.log_scale())?;
        chart
            .configure_mesh()
            .x_desc("reservoir's set-up and all of its steps, s")
            .y_desc("crest displacement, relative L2")
            .x_label_formatter(&|x| format!("{x:.0e}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .draw()?;
        chart.draw_series(points.iter().map(|p| Circle::new((p.cost, p.error), 4, BLUE.filled())))?;
        chart.draw_series(
            points.iter().map(|p| {
                EmptyElement::at((p.cost, p.error)) + Text::new(p.name.clone(), (7, -6), (FONT, 12))
            }),
        )?;
        Ok(())
    })
}
