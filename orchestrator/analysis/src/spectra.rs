//! Response spectra of a run, written next to its histories.

use crate::picture::{BLUE, Drawing, FONT, ORANGE, svg};
use cofferdam_assembly::observer::Histories;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_report::RunSpectra;
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Writes `response_spectra.csv` and `.svg` of the ground and of the crest (horizontal, total acceleration) into
/// `folder`; writes nothing for a run without a dam or without a step.
///
/// **Errors**: of the system or the drawing.
pub fn write(folder: &Path, histories: &Histories) -> Result<(), Box<dyn Error + Send + Sync>> {
    let Some(RunSpectra { periods, ground, crest }) = RunSpectra::of(histories) else { return Ok(()) };
    let mut text = String::from("period [s],ground [m/s2],crest [m/s2]\n");
    for ((period, ground), crest) in periods.iter().zip(&ground).zip(&crest) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{period},{ground},{crest}");
    }
    std::fs::write(folder.join("response_spectra.csv"), text)?;
    let picture =
        svg((760, 420), |area| draw(area, &periods, [("crest", BLUE, &crest), ("ground", ORANGE, &ground)]))?;
    Ok(std::fs::write(folder.join("response_spectra.svg"), picture)?)
}

fn draw(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    periods: &[f64],
    spectra: [(&str, RGBColor, &Vec<f64>); 2],
) -> Drawing {
    let most = spectra.iter().flat_map(|(_, _, values)| values.iter()).fold(0.0f64, |most, a| most.max(*a));
    let most = (1.05 * most / STANDARD_GRAVITY).max(1e-6);
    let (shortest, longest) = (periods[0], periods[periods.len() - 1]);
    let mut chart = ChartBuilder::on(area)
        .caption("Pseudo-acceleration, 5 % damping", (FONT, 16))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d((shortest..longest).log_scale(), 0.0..most)?;
    chart.configure_mesh().x_desc("period, s").y_desc("g").draw()?;
    for (name, colour, values) in spectra {
        let points = periods.iter().zip(values).map(|(period, a)| (*period, a / STANDARD_GRAVITY));
        chart
            .draw_series(LineSeries::new(points, colour))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
    }
    Ok(chart.configure_series_labels().background_style(WHITE).border_style(BLACK).draw()?)
}
