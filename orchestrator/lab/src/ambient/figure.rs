use crate::figure::svg;
use crate::study::{Outcome, StudyError};
use cofferdam_analysis::picture::{BLUE, FONT, GREEN, ORANGE};
use plotters::prelude::*;

/// Stored energy, error of the balance, and energy produced by the coupling, over time.
pub fn picture(outcome: &Outcome, stored: &[f64]) -> Result<String, StudyError> {
    let time = outcome.column("time");
    let magnitudes = |values: &[f64]| -> Vec<(f64, f64)> {
        let every = (time.len() / 1500).max(1);
        time.chunks(every)
            .zip(values.chunks(every))
            .map(|(t, values)| (t[0], values.iter().fold(1e-12, |a: f64, b| a.max(b.abs()))))
            .collect()
    };
    let lines = [
        ("stored energy", BLUE, magnitudes(stored)),
        ("damped", GREEN, magnitudes(outcome.column("dam.damping_work"))),
        ("missed by the dam's balance", ORANGE, magnitudes(outcome.column("dam.energy_balance_error"))),
        ("produced by the coupling", BLACK, magnitudes(outcome.column("interface_energy_produced"))),
    ];
    let end = time.last().copied().unwrap_or(1.0);
    let most = lines.iter().flat_map(|(.., line)| line).fold(1.0, |most: f64, (_, e)| most.max(*e));
    svg((860, 460), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Energy under ambient vibration", (FONT, 16))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(0.0..end, (most * 1e-9..most * 3.0).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("time, s")
            .y_desc("J per metre of dam, absolute")
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .draw()?;
        for (label, color, line) in lines {
            let shown = line.into_iter().map(|(t, e)| (t, e.max(most * 1e-9)));
            chart
                .draw_series(LineSeries::new(shown, color.stroke_width(1)))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(2)));
        }
        chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw()?;
        Ok(())
    })
}
