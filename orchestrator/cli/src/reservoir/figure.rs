//! Pictures of the response of the water, as SVG.

use cofferdam_analysis::picture::{Axis, FONT, History, across, chart, over_time, svg};
use cofferdam_reservoir::Complex64;
use std::error::Error;

/// A complex amplitude over ω/ω₁.
pub struct Curve {
    pub label: String,
    /// Index of the colour.
    pub colour: usize,
    pub dashed: bool,
    pub points: Vec<(f64, Complex64)>,
}

impl Curve {
    pub fn is_there(&self) -> bool {
        !self.points.is_empty()
    }

    fn part(&self, part: impl Fn(Complex64) -> f64) -> History {
        let points = self.points.iter().map(|(x, z)| (*x, part(*z))).collect();
        History { label: self.label.clone(), colour: self.colour, dashed: self.dashed, points }
    }
}

/// Share of the amplitudes that an axis covers; resonances exceed it.
const SHOWN: f64 = 0.95;

type Picture = Result<String, Box<dyn Error + Send + Sync>>;

/// Amplitude above and phase below, of pressures on the left and of the force on the right.
pub fn response(title: &str, pressures: &[Curve], force: &[Curve]) -> Picture {
    svg((1000, 700), |area| {
        let panels = area.titled(title, (FONT, 16))?.split_evenly((2, 2));
        for (column, (curves, name)) in
            [(pressures, "|p| / ρh per m/s²"), (force, "|F| / ρh² per m/s²")].into_iter().enumerate()
        {
            let amplitudes: Vec<History> = curves.iter().map(|c| c.part(|z| z.norm())).collect();
            let phases: Vec<History> = curves.iter().map(|c| c.part(|z| z.arg().to_degrees())).collect();
            let over = || Axis { name: "ω / ω₁", range: across(&amplitudes) };
            let up = Axis { name, range: 0.0..1.1 * typical(&amplitudes) };
            chart(&panels[column], over(), up, &amplitudes, true)?;
            let up = Axis { name: "phase, °", range: -190.0..190.0 };
            chart(&panels[2 + column], over(), up, &phases, false)?;
        }
        Ok(())
    })
}

/// Pressures above, the force below, over time.
pub fn histories(title: &str, pressures: &[History], force: &[History], [p, f]: [&str; 2]) -> Picture {
    svg((900, 700), |area| {
        let panels = area.titled(title, (FONT, 16))?.split_evenly((2, 1));
        for (panel, histories, name) in [(&panels[0], pressures, p), (&panels[1], force, f)] {
            over_time(panel, name, histories)?;
        }
        Ok(())
    })
}

/// Bound of most values.
fn typical(histories: &[History]) -> f64 {
    let mut values: Vec<f64> = histories.iter().flat_map(|h| h.points.iter().map(|(_, v)| *v)).collect();
    values.sort_by(f64::total_cmp);
    let index = (SHOWN * values.len() as f64) as usize;
    values.get(index.min(values.len().saturating_sub(1))).copied().unwrap_or(1.0).max(1e-300)
}
