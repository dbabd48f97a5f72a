//! Pictures of studies, as SVG.

use super::resolution::{Point, SHAPES, name as shape};
use super::stability::{Case, Grid, Verdict, name, water};
use super::tolerance::Series;
use super::windows;
use super::{Outcome, StudyError};
use crate::cli::picture::{self, BLUE, Drawing, FONT, GREEN, ORANGE};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Label, colour, points.
type Line<'a> = (&'a str, RGBColor, Vec<(f64, f64)>);

/// An SVG of `size` that `draw` fills.
fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Drawing,
) -> Result<String, StudyError> {
    picture::svg(size, draw).map_err(|cause| StudyError::File { path: "picture".into(), cause })
}

/// A colour from few iterations (light green) to a hundred (dark); red where it does not converge.
fn colour(verdict: &Verdict) -> RGBColor {
    match verdict {
        Verdict::Converges(mean, _) => {
            let share = (mean.max(1.0).log10() / 2.0).min(1.0);
            let mix = |light: f64, dark: f64| (light + share * (dark - light)) as u8;
            RGBColor(mix(229.0, 0.0), mix(245.0, 90.0), mix(224.0, 50.0))
        }
        Verdict::Diverges => RGBColor(0xcb, 0x18, 0x1d),
        Verdict::Stagnates => RGBColor(0xfb, 0x6a, 0x4a),
        Verdict::Limit => RGBColor(0xfc, 0xae, 0x91),
        Verdict::Refused(_) => RGBColor(0xd9, 0xd9, 0xd9),
    }
}

/// A panel for every water, mesh and acceleration: densities upwards, communication steps to the right.
pub fn stability(grid: &Grid, judged: &[(Case, Verdict)]) -> Result<String, StudyError> {
    let (rows, columns) = (grid.density_ratios.len(), grid.communication_steps.len());
    let accelerations = judged.len() / (rows * columns * grid.meshes.len() * grid.waters.len());
    let (cell, left, top) = (38, 70, 60);
    let (wide, high) = ((columns * cell + left) as i32, (rows * cell + top + 20) as i32);
    let size = (
        (accelerations as i32 * wide + 20) as u32,
        ((judged.len() / (rows * columns * accelerations)) as i32 * high + 30) as u32,
    );
    svg(size, |area| {
        let small = (FONT, 11).into_font().color(&BLACK);
        let middle = small.pos(Pos::new(HPos::Center, VPos::Center));
        for (index, panel) in judged.chunks(rows * columns).enumerate() {
            let (x, y) = ((index % accelerations) as i32 * wide, (index / accelerations) as i32 * high);
            let Case { water: of, mesh, acceleration, .. } = panel[0].0;
            let title = format!("{} water, {mesh} m, {}", water(of), name(acceleration));
            area.draw_text(&title, &(FONT, 13).into_font().color(&BLACK), (x + left as i32 - 40, y + 20))?;
            for (i, (case, verdict)) in panel.iter().enumerate() {
                let (row, column) = ((rows - 1 - i / columns) as i32, (i % columns) as i32);
                let (x0, y0) = (x + left as i32 + column * cell as i32, y + 40 + row * cell as i32);
                let corners = [(x0, y0), (x0 + cell as i32 - 2, y0 + cell as i32 - 2)];
                area.draw(&Rectangle::new(corners, colour(verdict).filled()))?;
                area.draw_text(
                    &verdict.cell(),
                    &middle,
                    (x0 + cell as i32 / 2 - 1, y0 + cell as i32 / 2 - 1),
                )?;
                if column == 0 {
                    area.draw_text(
                        &case.density_ratio.to_string(),
                        &middle,
                        (x0 - 18, y0 + cell as i32 / 2),
                    )?;
                }
                if row == rows as i32 - 1 {
                    let below = (x0 + cell as i32 / 2, y0 + cell as i32 + 8);
                    area.draw_text(&format!("{:e}", case.communication_step), &middle, below)?;
                }
            }
        }
        let legend = "up: density of the water over the concrete's; right: communication step in s; in the cells: dam steps a communication step, D diverges, S stagnates, L iteration limit, R refused";
        Ok(area.draw_text(legend, &small, (20, size.1 as i32 - 18))?)
    })
}

/// Errors and iterations over the tolerance, with the error of the communication step as a line.
pub fn tolerance(series: &Series) -> Result<String, StudyError> {
    let Series { points, of_step } = series;
    svg((760, 460), |area| {
        let (tightest, loosest) =
            points.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.tolerance), b.max(p.tolerance)));
        let most = points.iter().map(|p| p.iterations).fold(1.0, f64::max).ceil();
        let mut chart = ChartBuilder::on(area)
            .caption("What a tolerance buys and costs", (FONT, 16))
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
        chart.configure_secondary_axes().y_desc("dam steps a communication step").draw()?;
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
            .label("dam steps a communication step")
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

/// Stored energy, what the balance misses, and what the coupling produced, over time.
pub fn ambient(outcome: &Outcome, stored: &[f64]) -> Result<String, StudyError> {
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

/// A water: seconds for its set-up and all of its steps, and its error.
pub struct Priced {
    pub name: String,
    pub cost: f64,
    pub error: f64,
}

/// Waters by cost and error.
pub fn fidelity(points: &[Priced]) -> Result<String, StudyError> {
    let (across, up) = (decades(points.iter().map(|p| p.cost)), decades(points.iter().map(|p| p.error)));
    svg((900, 520), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("What the water costs and how far it is off the best", (FONT, 16))
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

/// Changes of crest and sliding (per cent), a pair of bars for each of the named changes of the scene.
pub fn sensitivity(rows: &[(String, [f64; 4])]) -> Result<String, StudyError> {
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

/// Errors over the number of elements, a line for each wavenumber and shape.
pub fn resolution(points: &[Point]) -> Result<String, StudyError> {
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
                    .label(format!("{}, kh = {wavenumber}", shape(order)))
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
            }
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerLeft).background_style(WHITE.mix(0.8));
        labels.border_style(BLACK).draw()?;
        Ok(())
    })
}

/// From the power of ten below all values above 0 to the one above.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let logarithms = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
    let (least, most) = logarithms.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    if least > most { 0.1..1.0 } else { 10f64.powf(least.floor())..10f64.powf(most.floor() + 1.0) }
}

/// Errors over the length of the paper's windows.
pub fn windows(rows: &[windows::Row]) -> Result<String, StudyError> {
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
            .caption("What the paper's windows cost", (FONT, 16))
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
