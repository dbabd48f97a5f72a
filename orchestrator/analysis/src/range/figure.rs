//! The tornado chart of a quantity.

use super::results::finite;
use crate::picture::{BLUE, Drawing, FONT, GREEN, ORANGE};
use cofferdam_report::{FactorKind, RangeQuantity};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Colour of a kind of spread.
fn colour(kind: FactorKind) -> RGBColor {
    match kind {
        FactorKind::Numerics => RGBColor(0x7f, 0x7f, 0x7f),
        FactorKind::Motion => ORANGE,
        FactorKind::Model => BLUE,
        FactorKind::Records => GREEN,
    }
}

/// Size of the chart.
pub fn size(quantity: &RangeQuantity) -> (u32, u32) {
    (900, 130 + 30 * quantity.swings.len().max(3) as u32)
}

/// Bars from the lowest to the highest value with each factor, the largest above, around the scene as it is; behind them the combined
/// interval.
pub fn draw(area: &DrawingArea<SVGBackend<'_>, Shift>, quantity: &RangeQuantity) -> Drawing {
    let RangeQuantity { name, unit, as_it_is, swings, combined, .. } = quantity;
    let bars = swings.iter().map(|swing| swing.interval(*as_it_is));
    let all = bars.chain(combined.iter().map(|combined| combined.interval)).flatten().chain([*as_it_is]);
    let [low, high] = finite(all).unwrap_or([0.0; 2]);
    let room = match high - low {
        spread if spread > 0.0 => 0.06 * spread,
        _ => 0.05 * low.abs().max(1.0),
    };
    let (left, right, count) = (low - room, high + room, swings.len().max(1) as f64);
    // Where a joint slides away, bars reach the edge.
    let within = |value: f64| value.clamp(left, right);
    let title = match combined {
        Some(all) => {
            format!("{name}: {} in 90 % of the runs with all factors", quantity.shown_interval(all.interval))
        }
        None => format!("{name}, one factor at a time"),
    };
    let label = if unit == "1" { name.clone() } else { format!("{name}, {unit}") };
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 16))
        .margin(12)
        .margin_left(220)
        .x_label_area_size(44)
        .build_cartesian_2d(left..right, count..0.0)?;
    let mut mesh = chart.configure_mesh();
    mesh.disable_y_mesh().disable_y_axis().x_desc(label).light_line_style(TRANSPARENT).draw()?;
    if let Some(all) = combined {
        let [low, high] = all.interval.map(within);
        let style = BLACK.mix(0.1).filled();
        let behind = [Rectangle::new([(low, 0.0), (high, count)], style)];
        let legend = move |(x, y)| Rectangle::new([(x, y - 5), (x + 20, y + 5)], style);
        chart.draw_series(behind)?.label("all together, 5 to 95 %").legend(legend);
    }
    for kind in FactorKind::ALL {
        let of_kind = swings.iter().enumerate().filter(|(_, swing)| swing.kind == kind);
        let bars: Vec<_> = of_kind
            .map(|(row, swing)| {
                let ([low, high], top) = (swing.interval(*as_it_is).map(within), row as f64 + 0.2);
                Rectangle::new([(low, top), (high, top + 0.6)], colour(kind).filled())
            })
            .collect();
        if !bars.is_empty() {
            let legend = move |(x, y)| Rectangle::new([(x, y - 5), (x + 20, y + 5)], colour(kind).filled());
            chart.draw_series(bars)?.label(kind.label()).legend(legend);
        }
    }
    let place = within(*as_it_is);
    let line = PathElement::new([(place, 0.0), (place, count)], BLACK.stroke_width(1));
    let as_it_is = format!("as it is: {}", quantity.shown(*as_it_is));
    let legend = |(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.stroke_width(1));
    chart.draw_series([line])?.label(as_it_is).legend(legend);
    let names = swings.iter().enumerate().map(|(row, swing)| {
        let style = TextStyle::from((FONT, 13)).pos(Pos::new(HPos::Right, VPos::Center));
        EmptyElement::at((left, row as f64 + 0.5)) + Text::new(swing.factor.clone(), (-6, 0), style)
    });
    chart.draw_series(names)?;
    let mut labels = chart.configure_series_labels();
    labels.position(SeriesLabelPosition::LowerRight).background_style(WHITE.mix(0.8));
    labels.border_style(BLACK).draw()?;
    Ok(())
}
