use super::Ensemble;
use crate::cli::picture::{BLUE, FONT, ORANGE};
use crate::cli::study::StudyError;
use crate::cli::study::figure::svg;
use plotters::prelude::*;

/// Mean sliding at the end with a bar of one standard deviation to either side, over the length of the elements.
pub fn picture(measured: &[Ensemble]) -> Result<String, StudyError> {
    let longest = measured.iter().fold(0.0f64, |most, ensemble| most.max(ensemble.length));
    let (low, high) =
        measured.iter().fold((0.0f64, 1.0f64), |(low, high), Ensemble { sliding: [mean, deviation], .. }| {
            (low.min(mean - deviation), high.max(mean + deviation))
        });
    svg((900, 480), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Sliding at the end", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..1.1 * longest, 1.05 * low..1.05 * high)?;
        chart.configure_mesh().x_desc("length of the elements, m").y_desc("sliding, mm").draw()?;
        for (contacts, colour, aside) in
            [("nodal", BLUE, -0.004 * longest), ("gauss", ORANGE, 0.004 * longest)]
        {
            let of_kind = || measured.iter().filter(move |ensemble| ensemble.contacts == contacts);
            chart.draw_series(of_kind().map(|Ensemble { length, sliding: [mean, deviation], .. }| {
                let at = length + aside;
                PathElement::new([(at, mean - deviation), (at, mean + deviation)], colour.stroke_width(2))
            }))?;
            let means = of_kind().map(|ensemble| (ensemble.length + aside, ensemble.sliding[0]));
            chart
                .draw_series(LineSeries::new(means, colour.stroke_width(2)))?
                .label(format!("contacts: {contacts}"))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerRight).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
}
