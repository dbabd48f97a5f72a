//! Estimate of time and disk space of a run before it starts.

use crate::context::Context;
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::participant::{Occasion, Participant, ParticipantError};
use cofferdam_log::LoggedExchanges;
use cofferdam_scene::LoadedScene;
use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

/// Time (s) and disk (bytes) of a run without snapshots on this machine: within a factor of two, if nothing else runs on it.
pub struct Estimate {
    /// Making the reservoir.
    pub preparation: f64,
    /// The steps.
    pub run: f64,
    /// Log and histories.
    pub disk: f64,
}

/// A unit that fails at its first steps, or cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    /// A unit that cannot be made.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A dam that fails at its first steps.
    #[error(transparent)]
    Dam(#[from] ParticipantError),
}

/// Dam steps per communication step of the default scheme, as in the main scene.
const ITERATIONS: f64 = 2.3;
/// Time of an exchange over shared memory with its entries in the log, s.
const EXCHANGE: f64 = 5e-5;
/// Time of the convolution in a step for each pair of points, s.
const CONVOLUTION: f64 = 9e-8;
/// Bytes of a number in the log and in the histories, as compressed and as written on average.
const LOGGED: f64 = 8.0;
const WRITTEN: f64 = 18.0;
/// The dam is timed for this long, or for this number of steps.
const SAMPLE: Duration = Duration::from_millis(200);
const MOST_STEPS: u32 = 50;

/// Estimates the run of `loaded` from some steps of its `dam`, initialised with `inputs`, and one frequency of its water.
///
/// **Errors**: those of the units.
pub fn of(
    loaded: &LoadedScene,
    dam: &mut dyn Participant,
    inputs: &[f64],
    threads: NonZeroUsize,
    context: &Context<'_>,
) -> Result<Estimate, EstimateError> {
    let scene = &loaded.scene;
    let (steps, communication_step) = (loaded.steps() as f64, scene.time.communication_step);
    let mut outputs = vec![0.0; dam.description().outputs.size()];
    let (began, mut taken) = (Instant::now(), 0_u32);
    // A unit may refuse steps beyond the end of the run.
    let most = u64::from(MOST_STEPS).min(loaded.steps());
    while taken == 0 || (began.elapsed() < SAMPLE && u64::from(taken) < most) {
        let time = f64::from(taken) * communication_step;
        taken += 1;
        let occasion = Occasion { step: taken.into(), iteration: 1, attempt: 1, time, communication_step };
        dam.step(&occasion, inputs, &mut outputs)?;
    }
    let dam_step = began.elapsed().as_secs_f64() / f64::from(taken);
    let mut faces = Vec::new();
    for (side, _) in scene.waters() {
        faces.push(Assembly::of(scene).water_face(side)?.len() as f64);
    }
    let (points, pairs) =
        (faces.iter().sum::<f64>(), faces.iter().map(|points| points * points).sum::<f64>());
    let preparation = Assembly::with(scene, context.making(threads)).preparation_time()?;
    let iterations = if scene.coupling.scheme.unwrap_or_default().is_implicit() { ITERATIONS } else { 1.0 };
    let water_step = if preparation.is_some() { CONVOLUTION * pairs } else { 0.0 };
    let logged = match scene.log.exchanges {
        LoggedExchanges::Every => iterations,
        LoggedExchanges::Accepted => 1.0,
        LoggedExchanges::None => 0.0,
    };
    let numbers = (inputs.len() + outputs.len()) as f64 + 3.0 * points;
    Ok(Estimate {
        preparation: preparation.unwrap_or(0.0),
        run: steps * (iterations * (dam_step + (1 + faces.len()) as f64 * EXCHANGE) + water_step),
        disk: steps * (logged * numbers * LOGGED + (outputs.len() as f64 + points) * WRITTEN),
    })
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { preparation, run, disk } = self;
        let time = preparation + run;
        let time = if time < 100.0 { format!("{time:.0} s") } else { format!("{:.0} min", time / 60.0) };
        let disk =
            if *disk < 1e9 { format!("{:.0} MB", disk / 1e6) } else { format!("{:.1} GB", disk / 1e9) };
        write!(
            f,
            "a run takes about {time} on this machine, {preparation:.0} s of it to prepare the water, and {disk} of disk"
        )
    }
}
