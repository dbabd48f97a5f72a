//! Runs of a pilot, and how far they are apart.

use super::AccuracyError;
use crate::context::{Context, threads};
use crate::parallel;
use cofferdam_assembly::observer::{HistoriesWriter, LastSecond, Rest};
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_scene::LoadedScene;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Sliding below which errors are taken as shares of this, m.
pub const LEAST_SLIDING: f64 = 1e-3;

/// Quantities by which runs are compared.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Instants, s.
    pub time: Vec<f64>,
    /// Displacement of the crest at these, m.
    pub crest: Vec<f64>,
    /// Sliding of each crack at the end (mean of the last second), m.
    pub sliding: Vec<f64>,
    /// Largest magnitude of sliding and opening of any crack, m.
    pub moved: f64,
    /// Communication steps that stayed above the tolerance, with which the run went on.
    pub unconverged: u64,
    /// Wall time, s.
    pub wall: f64,
}

impl Outcome {
    /// Reads the quantities from histories.
    pub fn of(
        column: impl Fn(&str) -> Vec<f64>,
        last: impl Fn(&str) -> Option<f64>,
        cracks: usize,
        unconverged: u64,
        wall: f64,
    ) -> Self {
        let largest = |name: String| column(&name).iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let moved = (0..cracks)
            .flat_map(|crack| ["sliding", "opening"].map(|what| format!("dam.crack_{what}.{crack}")));
        Self {
            time: column("time"),
            crest: column("dam.crest_displacement.x"),
            sliding: (0..cracks).filter_map(|crack| last(&format!("dam.crack_sliding.{crack}"))).collect(),
            moved: moved.map(largest).fold(0.0, f64::max),
            unconverged,
            wall,
        }
    }

    /// Largest displacement of the crest downstream and upstream, m.
    pub fn extremes(&self) -> [f64; 2] {
        [1.0, -1.0]
            .map(|sign| self.crest.iter().fold(f64::NEG_INFINITY, |most, value| most.max(sign * value)))
    }

    /// The larger magnitude of the two, m.
    pub fn peak(&self) -> f64 {
        self.extremes().into_iter().fold(0.0, |most, value| most.max(value.abs()))
    }

    /// Largest sliding of any crack at the end, m.
    pub fn slid(&self) -> f64 {
        self.sliding.iter().fold(0.0, |most, value| most.max(value.abs()))
    }

    /// Largest difference of the two peaks of the crest, over the larger peak of `exact`.
    pub fn crest_error(&self, exact: &Self) -> f64 {
        let [mine, other] = [self.extremes(), exact.extremes()];
        (0..2).map(|side| (mine[side] - other[side]).abs()).fold(0.0, f64::max)
            / exact.peak().max(f64::MIN_POSITIVE)
    }

    /// Largest difference of the crest at any instant, over the peak of `exact`, which is linear between its instants.
    pub fn history_error(&self, exact: &Self) -> f64 {
        let mut place = 0;
        let apart = self.time.iter().zip(&self.crest).map(|(time, value)| {
            while place + 2 < exact.time.len() && exact.time[place + 1] < *time {
                place += 1;
            }
            let (Some(t0), Some(t1)) = (exact.time.get(place), exact.time.get(place + 1)) else { return 0.0 };
            let share = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
            (value - exact.crest[place] - share * (exact.crest[place + 1] - exact.crest[place])).abs()
        });
        apart.fold(0.0, f64::max) / exact.peak().max(f64::MIN_POSITIVE)
    }

    /// Largest difference of any crack's sliding at the end, over the largest of `exact`, [`LEAST_SLIDING`] at least.
    pub fn sliding_error(&self, exact: &Self) -> f64 {
        let apart = self.sliding.iter().zip(&exact.sliding).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max) / exact.slid().max(LEAST_SLIDING)
    }
}

/// Runs a scene in this process.
///
/// **Errors**: a unit that cannot be made, a run that fails.
pub fn outcome(loaded: &LoadedScene, context: &Context<'_>) -> Result<Outcome, AccuracyError> {
    let began = Instant::now();
    let scene = &loaded.scene;
    let wrong = |cause| AccuracyError::Run { what: scene.title.clone(), cause: Box::new(cause) };
    let graph = Assembly::with(scene, context.making(NonZeroUsize::MIN)).graph()?;
    let mut simulation = simulation_of(scene, &loaded.ground_motion, graph).map_err(wrong)?;
    let (mut histories, mut rest) = (HistoriesWriter::in_memory(), Rest::new(&scene.time));
    let (ending, failure) = simulation.run(&mut [&mut histories, &mut rest], &AtomicBool::new(false));
    if let Some(cause) = failure {
        return Err(wrong(cause));
    }
    let histories = histories.histories;
    let cracks = scene.dam.as_ref().map_or(0, |dam| dam.cracks.len());
    let column = |name: &str| histories.column(name).map_or_else(Vec::new, <[f64]>::to_vec);
    let last = |name: &str| LastSecond::of(&histories, name).map(|last| last.sliding);
    let wall = began.elapsed().as_secs_f64();
    Ok(Outcome::of(column, last, cracks, ending.statistics.unconverged, wall))
}

/// Runs `scene` once with each of these lists of settings, as many at once as there are cores.
///
/// **Errors**: the first one.
pub fn run(scene: &Path, runs: &[Vec<String>], context: &Context<'_>) -> Result<Vec<Outcome>, AccuracyError> {
    let loaded = runs.iter().map(|settings| read_scene(scene, settings)).collect::<Result<Vec<_>, _>>()?;
    parallel::try_map(&loaded, threads(None), |loaded| outcome(loaded, context))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(frequency: f64, height: f64, step: f64, slid: f64) -> Outcome {
        let time: Vec<f64> = (0..(10.0 / step) as usize).map(|i| i as f64 * step).collect();
        let crest = time.iter().map(|t| height * (frequency * t).sin()).collect();
        Outcome { time, crest, sliding: vec![slid], ..Outcome::default() }
    }

    #[test]
    fn errors_are_shares_of_the_peak_whatever_the_steps() {
        let exact = swing(1.0, 0.2, 0.001, 0.1);
        // The same motion in other steps; a twentieth more of it; one that runs ahead by 1 % has turned by 0.1 rad after 10 s.
        assert!(swing(1.0, 0.2, 0.01, 0.1).history_error(&exact) < 1e-4);
        let larger = swing(1.0, 0.21, 0.002, 0.11);
        assert!((larger.crest_error(&exact) - 0.05).abs() < 1e-5, "{}", larger.crest_error(&exact));
        assert!((larger.sliding_error(&exact) - 0.1).abs() < 1e-9);
        let ahead = swing(1.01, 0.2, 0.001, 0.1);
        assert!(ahead.crest_error(&exact) < 1e-5 && (0.07..0.11).contains(&ahead.history_error(&exact)));
        // Next to no sliding is compared with a millimetre.
        assert!((swing(1.0, 0.2, 0.01, 2e-4).sliding_error(&swing(1.0, 0.2, 0.01, 1e-4)) - 0.1).abs() < 1e-9);
    }
}
