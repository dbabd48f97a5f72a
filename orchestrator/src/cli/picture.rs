//! What all pictures have in common.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;

/// Whether a picture could be drawn.
pub type Drawing = Result<(), Box<dyn Error + Send + Sync>>;

pub const BLUE: RGBColor = RGBColor(0x1f, 0x77, 0xb4);
pub const ORANGE: RGBColor = RGBColor(0xff, 0x7f, 0x0e);
pub const GREEN: RGBColor = RGBColor(0x2c, 0xa0, 0x2c);
pub const FONT: &str = "sans-serif";

/// An SVG of `size` that `draw` fills.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawing,
) -> Result<String, Box<dyn Error + Send + Sync>> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE)?;
        draw(&area)?;
        area.present()?;
    }
    Ok(text)
}
