use super::Series;
use crate::figure::{Line, svg};
use crate::study::StudyError;
use cofferdam_analysis::picture::{BLUE, FONT, GREEN, ORANGE};
use plotters::prelude::*;

/// Errors and iterations over the tolerance, with the error of the communication step as a line.
pub fn picture(series: &Series) -> Result<String, StudyError> {
    let Series { points, of_step } = series;
    svg((760, 460), |area| {
        let (tightest, loosest) =
            points.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.tolerance), b.max(p.tolerance)));
        let most = points.iter().map(|p| p.iterations).fold(1.0, f64::max).ceil();
        let mut chart = ChartBuilder::on(area)
            .caption("Accuracy and cost of the tolerance", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .right_y_label_area_size(50)
            .build_cartesian_2d((loosest..tightest).log_scale(), (1e-14..1.0).log_scale())?
            .set_secondary_coord((loosest..tightest).log_scale(), 0.0..most + 1.0);
        chart
            .configure_mesh()
            .x_desc("tolerance ε")
            .y_desc("largest difference over largest value")
            .x_label_formatter(&|x| format!("{x:.0e}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .draw()?;
        chart.configure_secondary_axes().y_desc("dam steps per communication step").draw()?;
        let lines: [Line<'_>; 2] = [
            ("crest displacement", BLUE, points.iter().map(|p| (p.tolerance, p.crest.max(1e-14))).collect()),
            ("sliding", ORANGE, points.iter().map(|p| (p.tolerance, p.sliding.max(1e-14))).collect()),
        ];
        for ((label, color, line), error) in lines.into_iter().zip(of_step) {
            chart
                .draw_series(LineSeries::new(line, color.stroke_width(2)).point_size(3))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(2)));
            if *error > 0.0 {
                let dashed = [(loosest, *error), (tightest, *error)];
                chart
                    .draw_series(DashedLineSeries::new(dashed, 6, 4, color.stroke_width(1)))?
                    .label(format!("{label}: error of the communication step"))
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(1)));
            }
        }
        let iterations = points.iter().map(|p| (p.tolerance, p.iterations));
        chart
            .draw_secondary_series(LineSeries::new(iterations, GREEN.stroke_width(2)).point_size(3))?
            .label("dam steps per communication step")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], GREEN.stroke_width(2)));
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK)
            .draw()?;
        Ok(())
    })
}
