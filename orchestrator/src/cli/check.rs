//! `cofferdam check`.

use super::{Check, complain, say};
use orchestrator::registry;
use orchestrator::scene::{SceneError, SceneWarning};
use std::path::Path;
use std::process::ExitCode;

/// Says of each scene what is wrong with it, or what a run of it would be.
pub fn check(arguments: &Check) -> ExitCode {
    let mut status = ExitCode::SUCCESS;
    for path in &arguments.scenes {
        if let Err(error) = examine(path, &arguments.set) {
            complain(format!("{:?}", miette::Report::new(error)));
            status = ExitCode::from(2);
        }
    }
    status
}

fn examine(path: &Path, overrides: &[String]) -> Result<(), SceneError> {
    let loaded = registry::read(path, overrides)?;
    warn(&loaded.warnings);
    let time = &loaded.scene.time;
    let (steps, step, duration) = (loaded.steps(), time.communication_step, time.duration.unwrap_or(0.0));
    let warnings = match loaded.warnings.len() {
        1 => "1 warning".to_owned(),
        number => format!("{number} warnings"),
    };
    // The sum of decimal numbers, without what binary ones add to it.
    let duration = (duration * 1e9).round() / 1e9;
    let steps = match time.adaptive {
        Some(adaptive) => format!("communication steps of {} to {} s", adaptive.shortest, adaptive.longest),
        None => format!("{steps} communication steps of {step} s"),
    };
    say(format!("{} can be run: {steps}, {duration} s; {warnings}", loaded.path.display()));
    Ok(())
}

/// Shows what is doubtful about a scene.
pub fn warn(warnings: &[SceneWarning]) {
    for warning in warnings {
        complain(format!("{:?}", miette::Report::new(warning.clone())));
    }
}
