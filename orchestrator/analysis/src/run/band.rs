//! The band of a run: results of perturbed replicates.

use crate::context::{Context, threads};
use crate::ensemble::{EnsembleError, sample};
use crate::parallel;
use crate::statistics::quantile;
use cofferdam_report::{Summary, has_both_directions};
use cofferdam_scene::{DamFidelityScene, LoadedScene};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};

/// Root mean square of the noise, as a share of the motion's.
pub const NOISE: f64 = 0.01;
/// Minimum number of replicates for a band.
const LEAST: usize = 3;

/// Runs this number of replicates of a run in this process, with the reduced dam if the run has the full dam, and gives the quantities of its
/// `summary` their band: 16 %, median, 84 %.
///
/// **Errors**: a replicate that cannot be run, or an interruption by the user, as text.
pub fn add(
    loaded: &LoadedScene,
    count: u16,
    context: &Context<'_>,
    interrupted: &AtomicBool,
    summary: &mut Summary,
) -> Result<(), String> {
    let mut twin = loaded.clone();
    let mut model = "the same model";
    if let Some(dam) = &mut twin.scene.dam
        && dam.fidelity.has_elements()
        && !dam.cracks.is_empty()
    {
        (dam.fidelity, model) = (DamFidelityScene::Reduced, "the reduced model");
    }
    context.line(format!(
        "\n{count} perturbed replicates ({} % noise on the motion), with {model}",
        100.0 * NOISE
    ));
    let seeds: Vec<u64> = (0..u64::from(count)).collect();
    let runs = parallel::try_map(&seeds, threads(None), |seed| {
        let mut own = twin.clone();
        own.ground_motion = own.ground_motion.with_noise(NOISE, *seed);
        sample::run(&own, context, NonZeroUsize::MIN, None, interrupted)
    });
    let runs = runs.map_err(|error: EnsembleError| error.to_string())?;
    if interrupted.load(Ordering::Relaxed) {
        return Err("its replicates were interrupted".to_owned());
    }
    let complete: Vec<_> = runs.iter().filter(|run| run.is_complete()).collect();
    for quantity in &mut summary.quantities {
        let values = complete.iter().map(|run| run.value(&quantity.name));
        let values: Vec<f64> = values.filter(|value| !value.is_nan()).collect();
        if values.len() >= LEAST {
            quantity.band = Some(band(&quantity.name, quantity.value, values));
        }
    }
    summary.notes.push(format!(
        "replicates: 16 %, median and 84 % of {} perturbed replicates ({} % noise on the motion), with {model}: what the shaking alone leaves \
         open. Damping model, mesh and direction of the record are those of the run; `cofferdam range` varies them, too",
        complete.len(),
        100.0 * NOISE
    ));
    if complete.len() < runs.len() {
        summary.notes.push(format!("WARNING: {} of {count} replicates failed", runs.len() - complete.len()));
    }
    Ok(())
}

/// 16 %, median and 84 % of the replicates' `values`; of a peak [in both directions](has_both_directions) those of its magnitude, in the direction of
/// the run's `value`.
fn band(name: &str, value: f64, mut values: Vec<f64>) -> [f64; 3] {
    if has_both_directions(name, values.iter().copied()) {
        values.iter_mut().for_each(|of_twin| *of_twin = of_twin.abs().copysign(value));
    }
    values.sort_by(f64::total_cmp);
    [0.16, 0.5, 0.84].map(|share| quantile(&values, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_in_both_directions_are_magnitudes_in_that_of_the_run() {
        let of = |name: &str, value| band(name, value, vec![-10.0, 9.0, -11.0, 12.0, 10.0]);
        let [low, median, high] = of("peak crest acceleration", -9.5);
        assert!(median == -10.0 && (-12.0..-10.0).contains(&low) && (-10.0..=-9.0).contains(&high));
        assert_eq!(of("peak crest acceleration", 9.5), [-high, -median, -low]);
        // Quantities other than peaks, such as the residual sliding, keep their sign.
        assert_eq!(of("residual sliding", 1.0)[1], 9.0);
    }
}
