//! Descriptions of self-excited vibrations of sliding blocks.

use cofferdam_assembly::{Assembly, AssemblyError, Flutter};
use cofferdam_scene::{CrackScene, Scene};
use std::f64::consts::TAU;

/// Warnings of vibrations that grow while blocks of the scene slide.
///
/// **Errors**: those of the dam.
pub fn warnings(scene: &Scene) -> Result<Vec<String>, AssemblyError> {
    let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    let growing = Assembly::of(scene).flutter()?.into_iter().filter(|(vibration, _)| vibration.growth > 0.0);
    Ok(growing
        .map(|(vibration, cures)| describe(&vibration, &cracks[vibration.crack]) + &advise(&cures))
        .collect())
}

/// A vibration of the block above a crack: direction of sliding, frequency, growth.
pub fn describe(vibration: &Flutter, crack: &CrackScene) -> String {
    let Flutter { downstream, frequency, growth, .. } = *vibration;
    let above = if crack.name.is_some() { crack.phrase() } else { crack.label() };
    format!(
        "while the block above {above} slides {}: vibration at {:.1} Hz {} by {:.3} 1/s",
        if downstream { "downstream" } else { "upstream" },
        frequency / TAU,
        if growth > 0.0 { "grows" } else { "decays" },
        growth.abs(),
    )
}

/// The effect of a growing vibration and its remedies.
pub fn advise(cures: &[String]) -> String {
    let remedy = match cures {
        [] => {
            "none of the damping models tried makes it decay: its causes are the shape of the block and the friction; radiation \
             into the rock, which is not modelled, would damp it (docs/decisions/flutter.md)"
                .to_owned()
        }
        cures => format!("the vibration would decay with {}", cures.join(", or with ")),
    };
    format!(
        ": once the block slides, the vibration is self-excited, and a thrust below the frictional strength may sustain the sliding; {remedy}"
    )
}
