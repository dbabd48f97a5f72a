//! `cofferdam study sensitivity`.

use cofferdam_assembly::{Assembly, read_scene};
mod figure;

use super::Arguments;
use crate::context::context;
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::study::{CREST, Outcome, SLIDING, StudyError, quoted, run_scene, unfit};
use cofferdam_analysis::table::Table;
use cofferdam_scene::{DamFidelityScene, DampingModel, LoadedScene, OnFailure};

pub const HELP: &str = "\
Runs the scene with one change at a time and tabulates the effect on crest
motion, rotation and sliding. The first group has changes that should not
matter: mesh, time steps, contact points, the reduced model, and 0.1 % of the
shaking. The second group has modelling choices: joint stiffness, plane
condition, friction, damping model and polarity. Rotation and sliding are those
of the lowest crack.

Writes sensitivity.md, sensitivity.csv and sensitivity.svg.

Example:
  cofferdam study sensitivity scenes/koyna-northridge-1994 \\
    --output studies/sensitivity

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// A change of the scene.
struct Change {
    what: String,
    /// Whether the result should stay the same.
    numerical: bool,
    sets: Vec<String>,
}

const ROTATION: &str = "dam.crack_rotation.0";

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let scene = &loaded.scene;
    let Some(dam) = scene.dam.as_ref().filter(|dam| !dam.cracks.is_empty()) else {
        return Err(unfit("the study needs a dam with a crack"));
    };
    if scene.ground_motion.record.is_none() {
        return Err(unfit("the study needs a record as ground motion"));
    }
    let elements = dam.fidelity.has_elements();
    if !elements && dam.fidelity != DamFidelityScene::Reduced {
        return Err(unfit("the study needs `dam.fidelity` = \"dem\" or \"reduced\""));
    }
    let change =
        |what: &str, numerical: bool, sets: Vec<String>| Change { what: what.to_owned(), numerical, sets };
    let of_joints = |factor: f64| -> Vec<String> {
        let stiffnesses = dam.cracks.iter().flat_map(|crack| {
            let i = crack.number;
            let both =
                [("normal_stiffness", crack.normal_stiffness), ("shear_stiffness", crack.shear_stiffness)];
            both.map(|(name, value)| format!("dam.cracks.{i}.{name}={:e}", factor * value))
        });
        stiffnesses.collect()
    };
    let of_friction = |factor: f64| -> Vec<String> {
        let coefficients = dam.cracks.iter().flat_map(|crack| {
            let i = crack.number;
            let set = |name: &str, value: f64| format!("dam.cracks.{i}.{name}={}", factor * value);
            let residual =
                crack.residual_friction_coefficient.map(|mu| set("residual_friction_coefficient", mu));
            [set("friction_coefficient", crack.friction_coefficient)].into_iter().chain(residual)
        });
        coefficients.collect()
    };
    let scale = |factor: f64| scene.ground_motion.scaled(factor);
    let mut changes = vec![
        change(
            "elements 0.7 times as long",
            true,
            vec![format!("dam.element_size={}", 0.7 * dam.element_size)],
        ),
        change(
            "time step of the dam halved",
            true,
            vec![format!("dam.time_step_safety={}", Assembly::of(scene).safety_of_part(2.0)?)],
        ),
        change("contacts at Gauss points", true, gauss(dam.cracks.len())),
        change("shaking + 0.1 %", true, scale(1.001)),
        change("polarity reversed", false, scene.ground_motion.reversed()),
    ];
    match (elements, dam.modes) {
        (true, _) => {
            changes.push(change("reduced blocks", true, vec!["dam.fidelity=\"reduced\"".to_owned()]))
        }
        (false, None) => {
            changes.push(change("elements, not modes", true, vec!["dam.fidelity=\"dem\"".to_owned()]))
        }
        // A number of modes requires a model with modes.
        (false, Some(_)) => {}
    }
    if !arguments.coarse {
        let step = scene.time.communication_step;
        changes.splice(
            2..2,
            [
                change(
                    "elements half as long",
                    true,
                    vec![format!("dam.element_size={}", 0.5 * dam.element_size)],
                ),
                change(
                    "communication step halved",
                    true,
                    vec![format!("time.communication_step={}", step / 2.0)],
                ),
            ],
        );
        changes.extend([
            change("shaking − 0.1 %", true, scale(0.999)),
            change("shaking + 1 %", false, scale(1.01)),
            change("shaking − 1 %", false, scale(0.99)),
            change("small rotations", false, vec!["dam.kinematics=\"small\"".to_owned()]),
            change("joints twice as stiff", false, of_joints(2.0)),
            change("joints half as stiff", false, of_joints(0.5)),
            change("friction + 5 %", false, of_friction(1.05)),
            change("friction − 5 %", false, of_friction(0.95)),
            change("plane strain", false, vec!["dam.material.plane=\"strain\"".to_owned()]),
        ]);
        if dam.damping.model == DampingModel::Rayleigh && dam.damping.ratio > 0.0 {
            let models =
                ["mass", "stiffness", "local"].into_iter().filter(|model| elements || *model != "local");
            changes.extend(models.map(|model| {
                change(&format!("damping: {model}"), false, vec![format!("dam.damping.model=\"{model}\"")])
            }));
        }
    }
    changes.sort_by_key(|change| !change.numerical);

    // All scenes are checked before anything is computed.
    let mut runs = Vec::new();
    for change in changes {
        let sets: Vec<String> = arguments.set.iter().chain(&change.sets).cloned().collect();
        runs.push((read_scene(&arguments.scene, &sets)?, change));
    }

    let mut unconverged = Vec::new();
    let mut solve = |loaded: &LoadedScene, what: &str| -> Result<[f64; 4], StudyError> {
        let mut scene = loaded.scene.clone();
        // A step that stays above its tolerance must not end the study; the text gives their number.
        scene.coupling.on_failure = OnFailure::Continue;
        let outcome = run_scene(&scene, &loaded.ground_motion, threads(None), &context())?.completed(what)?;
        let (found, wall) = (measures(&outcome), outcome.ending.wall.total.as_secs_f64());
        if let count @ 1.. = outcome.ending.statistics.unconverged {
            unconverged.push(format!("{count} ({what})"));
        }
        print(format!("{what}: sliding {:.2} mm, {wall:.1} s", 1e3 * found[3]));
        Ok(found)
    };
    let base = solve(&loaded, "as it is")?;
    let header = ["", "crest", "rotation", "largest sliding", "sliding at the end"];
    let mut table = Table::new(header);
    table.row([
        "as it is".to_owned(),
        format!("{:.2} mm", 1e3 * base[0]),
        format!("{:.3} mrad", 1e3 * base[1]),
        format!("{:.2} mm", 1e3 * base[2]),
        format!("{:.2} mm", 1e3 * base[3]),
    ]);
    let (mut worst, mut rows) = ([0.0f64; 4], Vec::new());
    for (changed, Change { what, numerical, .. }) in runs {
        let found = solve(&changed, &what)?;
        let relative = [0, 1, 2, 3].map(|i| found[i] / base[i] - 1.0);
        if numerical {
            worst = [0, 1, 2, 3].map(|i| worst[i].max(relative[i].abs()));
        }
        let name = format!("{what}{}", if numerical { "" } else { "*" });
        let cells = relative.map(|change| format!("{:+.1} %", 100.0 * change));
        table.row([name.clone()].into_iter().chain(cells));
        rows.push((name, relative.map(|change| 100.0 * change)));
    }
    let unconverged = if unconverged.is_empty() { "none".to_owned() } else { unconverged.join(", ") };
    let text = format!(
        "`cofferdam study sensitivity {}{}`: one thing changed, against the scene as it is\n\n{}\n\
         \\* a choice of the model. What should not matter changes the crest by {:.1} %, the rotation by {:.1} %, the largest \
         sliding by {:.1} % and that at the end by {:.1} % at most: no more digits than that are to be trusted. Communication steps \
         that rest above the tolerance: {unconverged}.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
        100.0 * worst[0],
        100.0 * worst[1],
        100.0 * worst[2],
        100.0 * worst[3],
    );
    print(&text);
    arguments.write("sensitivity.md", &text)?;
    arguments.write_table("sensitivity.csv", &table)?;
    arguments.write("sensitivity.svg", &figure::picture(&rows)?)
}

/// Largest crest motion (m), rotation (rad), sliding (m), and sliding at the end (m), of the lowest crack.
fn measures(outcome: &Outcome) -> [f64; 4] {
    let end = outcome.last(SLIDING).abs();
    [outcome.peak(CREST), outcome.peak(ROTATION), outcome.peak(SLIDING), end]
}

fn gauss(cracks: usize) -> Vec<String> {
    (0..cracks).map(|i| format!("dam.cracks.{i}.integration=\"gauss\"")).collect()
}
