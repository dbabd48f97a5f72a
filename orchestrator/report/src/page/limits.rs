//! Limitations of the model.

use cofferdam_scene::{CrackScene, Scene, UpliftRuleScene};

/// Limitations of the model that concern `scene`, one sentence each.
pub fn not_modelled(scene: &Scene) -> Vec<String> {
    let mut said: Vec<&str> = vec![
        if scene.ground_motion.has_vertical() {
            "The ground is rigid and moves as a whole: radiation damping in the rock is neglected."
        } else {
            "The ground is rigid and moves horizontally: vertical motion and radiation damping in the rock are neglected."
        },
        "The model is a plane section: interaction with neighbouring monoliths and abutments is neglected.",
    ];
    let filled = scene.has_water();
    match &scene.dam {
        None => said.push("The dam is prescribed: it is rigid and moves with the ground."),
        Some(dam) if dam.fidelity.is_foreign() => {
            said.push("The dam is simulated by another program; its assumptions are not known here.");
        }
        Some(dam) => {
            let intact = dam.fidelity.is_intact();
            let cracks = if intact { &[][..] } else { &dam.cracks };
            let joint = cracks.iter().any(|crack| crack.elevation == Some(0.0));
            said.push(if dam.fidelity.is_rigid() {
                "The blocks are rigid: amplification by the dam is not modelled, and sliding is underestimated."
            } else {
                "Concrete is linear elastic: it neither cracks nor crushes at any stress."
            });
            if !joint {
                said.push("The base is fixed to the ground: the dam neither slides on it nor lifts off.");
            }
            if !cracks.is_empty() {
                said.push("Cracks divide the section from the start; crack growth is not modelled.");
            }
            if intact && !dam.cracks.is_empty() {
                said.push("The cracks of the scene are omitted: the dam is intact.");
            }
            let wet = |crack: &CrackScene| crack.uplift_rule(dam.uplift) != UpliftRuleScene::None;
            if filled && !cracks.is_empty() && !cracks.iter().all(wet) {
                said.push("No water enters the cracks with uplift \"none\": there is no uplift in them.");
            }
        }
    }
    if filled {
        said.push("Water is linear: it does not cavitate at any pressure.");
        if scene.loads.silt.is_none() {
            said.push("There is no silt at the upstream face.");
        }
        if scene.waters().any(|(_, water)| water.fidelity.is_memoryless()) {
            said.push("Water is incompressible: it has no pressure waves and radiates no energy.");
        }
        if scene.has_foreign_water() {
            said.push(
                "A reservoir is simulated by another program or replayed from a log; its assumptions are not known here.",
            );
        }
    }
    said.into_iter().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn of(shipped: &str, overrides: &[&str]) -> String {
        let file =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(shipped).join("scene.toml");
        let text = std::fs::read_to_string(&file).expect("a shipped scene");
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        not_modelled(&Scene::resolved(&text, &overrides, &file).expect("a scene")).join("\n")
    }

    #[test]
    fn only_what_concerns_a_scene_is_said() {
        let [uplift, fixed, cavitates] =
            ["there is no uplift in them", "The base is fixed", "does not cavitate"];
        let main = of("koyna-coarse", &[]);
        assert!([uplift, fixed, cavitates].iter().all(|words| main.contains(words)), "{main}");
        assert!(!main.contains("incompressible") && !main.contains("prescribed"), "{main}");
        let joint = of("koyna-base-joint", &[]);
        assert!(joint.contains(uplift) && !joint.contains(fixed), "{joint}");
        let empty = of("koyna-coarse", &["reservoir.fidelity=none"]);
        assert!(!empty.contains(uplift) && !empty.contains(cavitates) && !empty.contains("silt"), "{empty}");
        let rigid = of("rigid-dam-ramp", &[]);
        assert!(rigid.contains("prescribed") && !rigid.contains("Concrete"), "{rigid}");
        let intact = of("koyna-coarse", &["dam.fidelity=intact", "reservoir.fidelity=westergaard"]);
        assert!(intact.contains("omitted") && intact.contains("incompressible"), "{intact}");
        assert!(!intact.contains("Cracks divide"), "{intact}");
        let neglected = "vertical motion and";
        assert!(main.contains(neglected) && rigid.contains(neglected), "{main}");
        let upwards = of("rigid-dam-ramp", &["ground_motion.ramp.vertical_acceleration=1"]);
        assert!(!upwards.contains("vertical motion") && upwards.contains("radiation damping"), "{upwards}");
    }
}
