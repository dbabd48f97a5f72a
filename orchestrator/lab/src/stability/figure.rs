use super::{Case, Grid, Verdict, name, water};
use crate::figure::svg;
use crate::study::StudyError;
use cofferdam_analysis::picture::FONT;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

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
pub fn picture(grid: &Grid, judged: &[(Case, Verdict)]) -> Result<String, StudyError> {
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
        let legend = "up: density of the water over the concrete's; right: communication step in s; in the cells: dam steps per communication step, D diverges, S stagnates, L iteration limit, R refused";
        Ok(area.draw_text(legend, &small, (20, size.1 as i32 - 18))?)
    })
}
