use super::Point;
use crate::cli::picture::{BLUE, FONT, ORANGE};
use crate::cli::study::StudyError;
use crate::cli::study::figure::svg;
use plotters::prelude::*;

/// Sliding at the end over the factor on the shaking, for either polarity.
pub fn picture(series: &[(i64, Vec<Point>)]) -> Result<String, StudyError> {
    let all = || series.iter().flat_map(|(_, points)| points);
    let range = |index: usize| {
        all().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
            [low.min(point[index]), high.max(point[index])]
        })
    };
    let ([left, right], [low, high]) = (range(0), range(2));
    let (low, high) = (low.min(0.0), high.max(1.0));
    svg((900, 480), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Sliding at the end", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(left..right, low * 1.05..high * 1.05)?;
        chart.configure_mesh().x_desc("factor on the shaking").y_desc("sliding, mm").draw()?;
        for ((polarity, points), colour) in series.iter().zip([BLUE, ORANGE]) {
            let dots = points.iter().map(|point| Circle::new((point[0], point[2]), 3, colour.filled()));
            chart
                .draw_series(dots)?
                .label(format!("polarity {polarity}"))
                .legend(move |(x, y)| Circle::new((x + 10, y), 3, colour.filled()));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperLeft).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
}
