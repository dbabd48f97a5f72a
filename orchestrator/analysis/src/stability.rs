//! What a run did to the joints of its dam.

use cofferdam_assembly::observer::Histories;
use cofferdam_assembly::{Assembly, AssemblyError, JointStability, UpliftRule};
use cofferdam_report::page::RunFolder;
use cofferdam_report::stability::Shaken;
use cofferdam_scene::LoadedScene;

/// Share of the shear strength from which a joint slides as a whole.
const SLIDES: f64 = 1.0 - 1e-6;

/// The joints of a scene, without a run.
///
/// **Errors**: those of the dam.
pub fn of_scene(
    loaded: &LoadedScene,
    rules: &[Option<UpliftRule>],
) -> Result<Vec<JointStability>, AssemblyError> {
    Assembly::of(&loaded.scene).stability(peak(loaded), None, rules)
}

/// The joints of a run: what happened to them, and their stability with the cracks that it left.
///
/// **Errors**: those of the dam.
pub fn of_run(
    run: &RunFolder,
    rules: &[Option<UpliftRule>],
) -> Result<(Vec<JointStability>, Vec<Shaken>), AssemblyError> {
    let scene = &run.loaded.scene;
    let joints = Assembly::of(scene).stability(peak(&run.loaded), None, rules)?;
    let count = scene.dam.as_ref().map_or(0, |dam| dam.cracks.len());
    let length =
        |crack: usize| joints.iter().find(|joint| joint.crack == crack).map_or(0.0, |joint| joint.length);
    let shaken: Vec<Shaken> = (0..count).map(|crack| shaken(&run.histories, crack, length(crack))).collect();
    let opened: Vec<f64> = shaken.iter().map(|shaken| shaken.opened).collect();
    Ok((Assembly::of(scene).stability(peak(&run.loaded), Some(&opened), rules)?, shaken))
}

fn peak(loaded: &LoadedScene) -> f64 {
    loaded.ground_motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()))
}

fn shaken(histories: &Histories, crack: usize, length: f64) -> Shaken {
    let column = |name: &str| histories.column(&format!("dam.crack_{name}.{crack}")).unwrap_or(&[]);
    let time = histories.column("time").unwrap_or(&[]);
    let utilisation = column("shear_utilisation");
    let largest = utilisation.iter().zip(time).max_by(|(a, _), (b, _)| a.total_cmp(b));
    let steps = time.windows(2).zip(utilisation.iter().skip(1));
    Shaken {
        least_factor: largest.filter(|(share, _)| **share > 0.0).map(|(share, _)| 1.0 / share),
        time: largest.map_or(0.0, |(_, time)| *time),
        sliding_time: steps.filter(|(_, share)| **share >= SLIDES).map(|(pair, _)| pair[1] - pair[0]).sum(),
        opened: length * column("open_share").iter().fold(0.0, |most: f64, share| most.max(*share)),
        residual: column("sliding").last().copied().unwrap_or(0.0),
    }
}
