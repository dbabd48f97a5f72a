//! What a run does not model.

use cofferdam_scene::Scene;

/// What `scene` leaves out, each in a sentence; only what concerns it.
pub fn not_modelled(scene: &Scene) -> Vec<String> {
    let mut said: Vec<&str> = vec![
        "The ground is rigid and moves horizontally only: no vertical shaking, no waves radiated into the rock.",
        "The section is plane: neighbouring monoliths and abutments do not help or hinder.",
    ];
    let filled = scene.has_water();
    match &scene.dam {
        None => said.push("The dam is prescribed: it is rigid and moves with the ground."),
        Some(dam) if dam.fidelity.is_foreign() => {
            said.push("The dam belongs to another program: what it models is not known here.");
        }
        Some(dam) => {
            let intact = dam.fidelity.is_intact();
            let cracks = if intact { &[][..] } else { &dam.cracks };
            let joint = cracks.iter().any(|crack| crack.elevation == Some(0.0));
            said.push(if dam.fidelity.is_rigid() {
                "The blocks do not deform: the dam's own amplification is missing, and sliding comes out too small."
            } else {
                "Concrete is linear elastic: it does not crack or crush, whatever the stress."
            });
            if !joint {
                said.push("The base is fixed to the ground: the dam neither slides nor lifts on it.");
            }
            if !cracks.is_empty() {
                said.push("Cracks divide the section and exist from the beginning; none grows.");
            }
            if intact && !dam.cracks.is_empty() {
                said.push("The cracks of the scene are left out: the dam is intact.");
            }
            if filled {
                said.push(
                    "No water enters cracks or the base: there is no uplift, neither from a reservoir nor from a tailwater.",
                );
            }
        }
    }
    if filled {
        said.push("Water is linear: it does not cavitate, however low the pressure falls.");
        said.push("There is no silt before the dam.");
        if scene.waters().any(|(_, water)| water.fidelity.is_memoryless()) {
            said.push("Water is incompressible: no waves in it, and no energy that they carry away.");
        }
        if scene.has_foreign_water() {
            said.push(
                "A reservoir belongs to another program or an earlier run: what it models is not known here.",
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
        let [uplift, fixed, cavitates] = ["there is no uplift", "The base is fixed", "does not cavitate"];
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
        assert!(intact.contains("left out") && intact.contains("incompressible"), "{intact}");
        assert!(!intact.contains("Cracks divide"), "{intact}");
    }
}
