use crate::observer::Histories;

/// The part of a run at its end, s, over which means are taken.
pub const AVERAGED: f64 = 1.0;
/// Speed of sliding, m/s, and share of the peak kinetic energy, both means over that part, above which a block is not at
/// rest.
pub const STILL_SLIDES: f64 = 1e-4;
pub const STILL_MOVES: f64 = 1e-2;

/// How the block above a crack moves in the last second of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastSecond {
    /// Mean sliding, m.
    pub sliding: f64,
    /// Mean speed of sliding, m/s.
    pub speed: f64,
    /// Mean kinetic energy of the dam over its peak.
    pub kinetic_share: f64,
}

impl LastSecond {
    /// Of the histories with this `column` of sliding; none without it.
    pub fn of(histories: &Histories, column: &str) -> Option<Self> {
        let (time, sliding) = (histories.column("time")?, histories.column(column)?);
        let from = time.partition_point(|t| *t < time.last().copied().unwrap_or(0.0) - AVERAGED);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let last = &sliding[from..];
        let (first_half, second_half) = last.split_at(last.len() / 2);
        let kinetic = histories.column("dam.kinetic_energy").unwrap_or(&[]);
        let peak = kinetic.iter().copied().fold(0.0, f64::max);
        Some(Self {
            sliding: mean(last),
            speed: (mean(second_half) - mean(first_half)) / (AVERAGED / 2.0),
            kinetic_share: if peak > 0.0 { mean(kinetic.get(from..).unwrap_or(&[])) / peak } else { 0.0 },
        })
    }

    /// Whether the block is at rest.
    pub fn is_rest(&self) -> bool {
        self.speed.abs() <= STILL_SLIDES && self.kinetic_share <= STILL_MOVES
    }
}
