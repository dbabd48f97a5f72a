//! `cofferdam check`.

use super::{Check, complain, estimate, known, say, threads};
use miette::Diagnostic;
use orchestrator::ground_motion::{GroundMotion, STANDARD_GRAVITY};
use orchestrator::participant::ParticipantError;
use orchestrator::registry::{self, Flutter, LimitEquilibrium, RegistryError};
use orchestrator::scene::{SceneError, SceneWarning};
use orchestrator::scheme::UnitId;
use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;

/// Why a scene cannot be run.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum CheckError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Unit(#[from] RegistryError),
    #[error(transparent)]
    Dam(#[from] ParticipantError),
    #[error(transparent)]
    Estimate(#[from] estimate::EstimateError),
}

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

fn examine(path: &Path, overrides: &[String]) -> Result<(), CheckError> {
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
    // The dam is made and brought to rest as a run would; only the water's preparation remains.
    let mut dam = registry::unit(UnitId::DAM, &loaded.scene, threads(None))?;
    let [mut inputs, mut outputs] =
        [&dam.description().inputs, &dam.description().outputs].map(|layout| vec![0.0; layout.size()]);
    if let Some(range) = dam.description().inputs.range("hydrostatic_pressure") {
        inputs[range].copy_from_slice(&registry::hydrostatic_pressure(&loaded.scene)?);
    }
    dam.initialise(0.0, &inputs, &mut outputs)?;
    let frequencies = known(dam.read("natural_frequency"))?;
    say(format!("{} can be run: {steps}, {duration} s; {warnings}", loaded.path.display()));
    say(format!("  dam: {}", dam.description().solver));
    if loaded.ground_motion.file().is_some() {
        say(format!("  {}", strength(&loaded.ground_motion)));
    }
    if !frequencies.is_empty() {
        let frequencies: Vec<String> = frequencies.iter().map(|f| format!("{f:.2}")).collect();
        say(format!("  natural frequencies of the dam, intact and empty: {} rad/s", frequencies.join(", ")));
    }
    say(format!("  {}", estimate::of(&loaded, &mut *dam, &inputs, threads(None))?));
    for LimitEquilibrium { elevation, sliding, overturning } in registry::limit_equilibria(&loaded.scene)? {
        say(format!(
            "  factor of safety of the crack at {elevation} m before the ground moves: sliding {sliding:.2}, overturning \
             {overturning:.2}"
        ));
    }
    for (vibration, cures) in registry::flutter(&loaded.scene)? {
        say(format!("  {}", describe(&vibration)));
        if vibration.growth > 0.0 {
            complain(format!("WARNING: {}{}", describe(&vibration), advise(&cures)));
        }
    }
    Ok(())
}

/// How strong a record is.
fn strength(motion: &GroundMotion) -> String {
    let peak = motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    let [velocity, displacement] = motion.drift().map(|drift| drift.peak);
    let (intensity, duration) = motion.arias_intensity();
    format!(
        "ground: {}, {:.2} s: at most {:.3} g, {velocity:.3} m/s, {displacement:.3} m; Arias intensity {intensity:.3} m/s, 5 to 95 % \
         of it within {duration:.2} s",
        motion.source(),
        motion.duration(),
        peak / STANDARD_GRAVITY,
    )
}

fn describe(vibration: &Flutter) -> String {
    let Flutter { elevation, downstream, frequency, growth } = *vibration;
    format!(
        "while the block above {elevation} m slides {}: vibration at {:.1} Hz {} by {:.3} 1/s",
        if downstream { "downstream" } else { "upstream" },
        frequency / TAU,
        if growth > 0.0 { "grows" } else { "decays" },
        growth.abs(),
    )
}

/// What a growing vibration means, and what cures it.
fn advise(cures: &[String]) -> String {
    let remedy = match cures {
        [] => {
            "no other damping that was tried makes it decay; look at the shape of the block and its friction"
                .to_owned()
        }
        cures => format!("it would decay with {}", cures.join(", or with ")),
    };
    format!(
        ": once it slides, the block shakes itself, and a thrust below its frictional strength may keep it sliding; {remedy}"
    )
}

/// Shows what is doubtful about a scene.
pub fn warn(warnings: &[SceneWarning]) {
    for warning in warnings {
        complain(format!("{:?}", miette::Report::new(warning.clone())));
    }
}
