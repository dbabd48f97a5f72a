use cofferdam_analysis::picture::{BLUE, FONT, ORANGE};
use cofferdam_analysis::study::StudyError;
use cofferdam_analysis::study::svg;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Changes of crest and sliding (per cent), a pair of bars for each of the named changes of the scene.
pub fn picture(rows: &[(String, [f64; 4])]) -> Result<String, StudyError> {
    let kinds = [("crest", 0, BLUE, 0.15), ("sliding at the end", 3, ORANGE, 0.5)];
    let most =
        rows.iter().flat_map(|(_, changes)| kinds.map(|(_, i, ..)| changes[i].abs())).fold(1.0, f64::max);
    let (count, width) = (rows.len() as f64, 1.1 * most);
    svg((900, 60 + 34 * (rows.len() as u32 + 2)), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("What one change does", (FONT, 16))
            .margin(12)
            .margin_left(220)
            .x_label_area_size(40)
            .build_cartesian_2d(-width..width, count..0.0)?;
        chart.configure_mesh().disable_y_mesh().disable_y_axis().x_desc("change, %").draw()?;
        for (label, index, colour, from) in kinds {
            let bars = rows.iter().enumerate().map(|(row, (_, changes))| {
                let top = row as f64 + from;
                Rectangle::new([(0.0, top), (changes[index], top + 0.35)], colour.filled())
            });
            let legend = move |(x, y)| Rectangle::new([(x, y - 5), (x + 20, y + 5)], colour.filled());
            chart.draw_series(bars)?.label(label).legend(legend);
        }
        let names = rows.iter().enumerate().map(|(row, (name, _))| {
            let style = TextStyle::from((FONT, 13)).pos(Pos::new(HPos::Right, VPos::Center));
            EmptyElement::at((-width, row as f64 + 0.5)) + Text::new(name.clone(), (-6, 0), style)
        });
        chart.draw_series(names)?;
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerRight).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
}
