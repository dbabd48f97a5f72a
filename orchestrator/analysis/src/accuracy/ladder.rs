//! The levels of numerics.

use cofferdam_coupling::convergence::Tolerance;
use cofferdam_scene::{DamFidelityScene, FidelityScene, Scene};

/// The lengths of elements, m, from the coarsest.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    /// Each of them, m.
    pub sizes: [f64; Ladder::RUNGS],
}

impl Ladder {
    /// Number of levels.
    pub const RUNGS: usize = 5;

    /// 5 to 1.25 m, and in proportion for dams that are lower than 103 m.
    pub fn of(scene: &Scene) -> Self {
        let part = (scene.height() / 103.0).min(1.0);
        Self { sizes: [5.0, 3.3, 2.5, 1.8, 1.25].map(|size| size * part) }
    }

    /// The settings of a rung: elements, the water's points, `fidelity` of the dam.
    pub fn settings(&self, scene: &Scene, rung: usize, fidelity: DamFidelityScene) -> Vec<String> {
        let size = self.sizes[rung];
        let mut settings =
            vec![format!("dam.element_size={size}"), format!("dam.fidelity=\"{}\"", fidelity.word())];
        // Points of the water closer than those cost its preparation and change nothing (docs/measurements/accuracy.md).
        let points = if fidelity == DamFidelityScene::Intact { self.sizes[0] } else { self.sizes[2] };
        for (side, water) in scene.waters().filter(|(_, water)| !water.is_empty()) {
            let depth = scene.depth_of(side);
            if water.interface_size.is_none()
                && size < points
                && points < depth
                && water.fidelity.has_memory()
            {
                settings.push(format!("{}={points}", side.key("interface_size")));
            }
            if water.fidelity == FidelityScene::Compressible {
                settings.push(format!("{}=\"automatic\"", side.key("method")));
            }
        }
        if matches!(scene.coupling.tolerance, Tolerance::Relative(tolerance) if tolerance > 1e-3) {
            settings.push("coupling.tolerance=\"balanced\"".to_owned());
        }
        settings
    }

    /// The settings of the reference. A step that stays above the strict tolerance does not end it: it is counted.
    pub fn reference(&self, scene: &Scene) -> Vec<String> {
        let mut settings = vec![
            format!("dam.element_size={}", self.sizes[Self::RUNGS - 1]),
            "dam.fidelity=\"dem\"".to_owned(),
            "coupling.tolerance=1e-8".to_owned(),
            "coupling.on_failure=\"continue\"".to_owned(),
            format!("time.communication_step={}", scene.time.communication_step / 2.0),
        ];
        for (side, water) in scene.waters().filter(|(_, water)| water.fidelity == FidelityScene::Compressible)
        {
            settings.push(format!("{}=\"radau2\"", side.key("method")));
            if water.interface_size.is_none() && self.sizes[2] < scene.depth_of(side) {
                settings.push(format!("{}={}", side.key("interface_size"), self.sizes[2]));
            }
        }
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_assembly::read_scene;
    use cofferdam_scene::OnFailure;
    use std::path::Path;

    #[test]
    fn the_reference_is_the_strictest_run_and_goes_on_with_steps_above_its_tolerance() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/koyna-coarse");
        let scene = read_scene(&path, &[]).expect("a scene").scene;
        let settings = Ladder::of(&scene).reference(&scene);
        let reference = read_scene(&path, &settings).expect("a scene").scene;
        assert_eq!(reference.coupling.tolerance, Tolerance::Relative(1e-8));
        assert_eq!(reference.coupling.on_failure, OnFailure::Continue);
        assert_eq!(2.0 * reference.time.communication_step, scene.time.communication_step);
        let dam = reference.dam.expect("a dam");
        assert_eq!((dam.fidelity, dam.element_size), (DamFidelityScene::Dem, 1.25));
    }
}
