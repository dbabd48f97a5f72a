//! Results of a run in the quantities and units of the paper.

use crate::study::{Outcome, SLIDING, relative};
use cofferdam_analysis::picture::History;
use cofferdam_assembly::observer::LastSecond;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_report::page::kept;
use cofferdam_scene::{LoadedScene, Side};

/// Number of parts of a drawn line; the extremes of each part are kept.
const PARTS: usize = 400;
/// Time that is drawn, s; nothing slides later in the shipped records.
const DRAWN: f64 = 20.0;
/// Share of the largest displacement downstream that makes a displacement large.
const LARGE: f64 = 0.5;

/// A quantity of the paper's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Hydrodynamic over hydrostatic pressure at the base.
    BasePressure,
    /// Acceleration of the block below the crack, g.
    Below,
    /// Of the block above, g.
    Above,
    /// Of the crest, g.
    Crest,
    /// Displacement of the crest downstream, mm.
    Downstream,
    /// Upwards, mm.
    Upwards,
    /// Sliding of the block above the crack, mm.
    Sliding,
    /// Its rotation, mrad.
    Rotation,
}

impl Quantity {
    pub const ALL: [Self; 8] = [
        Self::BasePressure,
        Self::Below,
        Self::Above,
        Self::Crest,
        Self::Downstream,
        Self::Upwards,
        Self::Sliding,
        Self::Rotation,
    ];

    /// The column of the histories and the factor from SI units; that of the pressure is 1 over the hydrostatic one.
    fn column(self) -> (&'static str, f64) {
        let g = 1.0 / STANDARD_GRAVITY;
        match self {
            Self::BasePressure => ("reservoir.base_pressure", 1.0),
            Self::Below => ("dam.crack_acceleration_below.0", g),
            Self::Above => ("dam.crack_acceleration_above.0", g),
            Self::Crest => ("dam.crest_acceleration.x", g),
            Self::Downstream => ("dam.crest_displacement.x", 1e3),
            Self::Upwards => ("dam.crest_displacement.y", 1e3),
            Self::Sliding => (SLIDING, 1e3),
            Self::Rotation => ("dam.crack_rotation.0", 1e3),
        }
    }

    /// Label of the axis.
    pub fn axis(self) -> &'static str {
        match self {
            Self::BasePressure => "p / ρgh at the base",
            Self::Below => "below the crack, g",
            Self::Above => "above the crack, g",
            Self::Crest => "crest, g",
            Self::Downstream => "crest downstream, mm",
            Self::Upwards => "crest upwards, mm",
            Self::Sliding => "sliding, mm",
            Self::Rotation => "rotation, mrad",
        }
    }
}

/// The histories of a run that the figures need; those that the run does not have are empty.
#[derive(Clone, Debug, Default)]
pub struct Response {
    time: Vec<f64>,
    columns: [Vec<f64>; Quantity::ALL.len()],
    /// Residual sliding as `run` gives it, mm: mean of the last second.
    pub residual: f64,
    /// Steps of the coupling that stayed above the tolerance.
    pub unconverged: u64,
}

impl Response {
    pub fn of(loaded: &LoadedScene, outcome: &Outcome) -> Self {
        let hydrostatic = loaded.scene.hydrostatic_base_pressure(Side::Upstream);
        let columns = Quantity::ALL.map(|quantity| {
            let (name, factor) = quantity.column();
            let factor = if quantity == Quantity::BasePressure { 1.0 / hydrostatic } else { factor };
            outcome.column(name).iter().map(|value| factor * value).collect()
        });
        let residual = LastSecond::of(&outcome.histories, SLIDING).map_or(0.0, |last| 1e3 * last.sliding);
        let unconverged = outcome.ending.statistics.unconverged;
        Self { time: outcome.column("time").to_vec(), columns, residual, unconverged }
    }

    pub fn time(&self) -> &[f64] {
        &self.time
    }

    pub fn column(&self, quantity: Quantity) -> &[f64] {
        &self.columns[quantity as usize]
    }

    /// Largest absolute value.
    pub fn peak(&self, quantity: Quantity) -> f64 {
        self.column(quantity).iter().fold(0.0, |most, value| most.max(value.abs()))
    }

    /// Relative difference from another run in the mean square over time.
    pub fn apart(&self, other: &Self, quantity: Quantity) -> f64 {
        relative(self.column(quantity), other.column(quantity))
    }

    /// The first large displacement of the crest downstream (mm) and its time (s): the first maximum of at least half the largest
    /// value; zeros if the crest never moves downstream.
    pub fn first_swing(&self) -> [f64; 2] {
        let values = self.column(Quantity::Downstream);
        let most = values.iter().copied().fold(0.0, f64::max);
        let Some(from) = values.iter().position(|value| *value > 0.0 && *value >= LARGE * most) else {
            return [0.0; 2];
        };
        let climbs = values[from..].windows(2).take_while(|pair| pair[1] >= pair[0]).count();
        [values[from + climbs], self.time[from + climbs]]
    }

    /// The line of a quantity, times `factor`.
    pub fn line(&self, label: &str, colour: usize, quantity: Quantity, factor: f64) -> History {
        let values = self.column(quantity);
        let rows = values.len().min(self.time.partition_point(|time| *time <= DRAWN));
        let rows = kept(rows, &[values], PARTS);
        let points = rows.into_iter().map(|row| (self.time[row], factor * values[row])).collect();
        History { label: label.to_owned(), colour, dashed: false, points }
    }
}

/// Dashed lines at `values`, as long as the other `lines`; the legend has `label` once.
pub fn levels(label: &str, values: &[f64], lines: &[History]) -> Vec<History> {
    let ends = lines.iter().filter_map(|line| Some((line.points.first()?.0, line.points.last()?.0)));
    let (from, to) = ends.fold((f64::MAX, f64::MIN), |(a, b), (first, last)| (a.min(first), b.max(last)));
    let of = |(index, value): (usize, &f64)| {
        let label = if index == 0 { label.to_owned() } else { String::new() };
        History { label, colour: 0, dashed: true, points: vec![(from, *value), (to, *value)] }
    };
    values.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(values: &[f64]) -> Response {
        let mut response =
            Response { time: (0..values.len()).map(|n| n as f64).collect(), ..Response::default() };
        response.columns[Quantity::Downstream as usize] = values.to_vec();
        response
    }

    #[test]
    fn the_first_swing_is_the_first_maximum_that_is_large() {
        assert_eq!(moved(&[0.0, 3.0, 1.0, 4.0, 6.0, 2.0, 10.0, 9.0]).first_swing(), [6.0, 4.0]);
        assert_eq!(moved(&[0.0, 3.0, 1.0, 10.0, 20.0]).first_swing(), [20.0, 4.0]);
        assert_eq!(moved(&[0.0, -3.0]).first_swing(), [0.0, 0.0]);
        assert_eq!(moved(&[]).first_swing(), [0.0, 0.0]);
    }

    #[test]
    fn a_drawn_line_keeps_its_extremes_and_ends_with_what_is_drawn() {
        let values: Vec<f64> = (0..8000).map(|n| if n == 1234 { 7.0 } else { 0.0 }).collect();
        let mut response = moved(&values);
        response.time.iter_mut().for_each(|time| *time *= 0.005);
        let points = response.line("", 0, Quantity::Downstream, 2.0).points;
        assert!(points.len() < 2 * PARTS + 2 && points.last().is_some_and(|point| point.0 <= DRAWN));
        assert!(points.iter().any(|point| point.1 == 14.0), "{points:?}");
    }
}
