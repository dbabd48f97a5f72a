//! Results on a dam that do not depend on the run, computed in the background.

use crate::context::Context;
use crate::flutter;
use cofferdam_assembly::{Assembly, AssemblyError, Equilibrium};
use cofferdam_report::Summary;
use cofferdam_scene::Scene;
use std::panic::resume_unwind;
use std::thread::{Builder, JoinHandle};

/// Natural frequencies with the mass of the water, factors of safety, and vibrations that would grow while blocks slide. Of a mesh of
/// 1.8 m they take half a second of a core.
pub struct Background<'a> {
    scene: &'a Scene,
    /// Number of natural frequencies.
    frequencies: usize,
    /// None where the system gives no thread.
    thread: Option<JoinHandle<Found>>,
}

struct Found {
    frequencies_in_water: Result<Vec<f64>, AssemblyError>,
    equilibria: Result<Vec<(usize, Equilibrium)>, AssemblyError>,
    flutter_warnings: Result<Vec<String>, AssemblyError>,
}

impl<'a> Background<'a> {
    /// Begins to find what is known of the dam of `scene`, with this number of natural `frequencies`.
    pub fn begin(scene: &'a Scene, frequencies: usize) -> Self {
        let own = scene.clone();
        let thread = Builder::new().spawn(move || Found::of(&own, frequencies)).ok();
        Self { scene, frequencies, thread }
    }

    /// Waits until it is found; adds factors of safety and warnings to the summary that `of_frequencies` makes of the frequencies in water. Missing results
    /// do not stop the run.
    pub fn summary(self, context: &Context<'_>, of_frequencies: impl FnOnce(&[f64]) -> Summary) -> Summary {
        let Self { scene, frequencies, thread } = self;
        let Found { frequencies_in_water, equilibria, flutter_warnings } = match thread {
            Some(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
            None => Found::of(scene, frequencies),
        };
        let mut summary = of_frequencies(&frequencies_in_water.unwrap_or_else(|error| {
            context.warning(format!("WARNING: no natural frequencies with the water: {error}"));
            Vec::new()
        }));
        match equilibria {
            Ok(found) => summary.add_equilibria(scene, &found),
            Err(error) => summary.notes.push(format!("WARNING: no factors of safety: {error}")),
        }
        match flutter_warnings {
            Ok(warnings) => summary.notes.extend(warnings.into_iter().map(|said| format!("WARNING: {said}"))),
            Err(error) => {
                summary.notes.push(format!("WARNING: self-excited vibration could not be checked: {error}"))
            }
        }
        summary
    }
}

impl Found {
    fn of(scene: &Scene, frequencies: usize) -> Self {
        let modes = match frequencies {
            0 => Ok(None),
            count => Assembly::of(scene).natural_modes_in_water(count),
        };
        Self {
            frequencies_in_water: modes.map(|modes| modes.map_or_else(Vec::new, |modes| modes.frequencies)),
            equilibria: Assembly::of(scene).equilibria(),
            flutter_warnings: flutter::warnings(scene),
        }
    }
}
