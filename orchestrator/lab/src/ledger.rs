//! `cofferdam-lab ledger`.

use crate::study::{Arguments, StudyError, quoted, run_all, unfit};
use crate::terminal::print;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_scene::LoadedScene;

pub const HELP: &str = "\
Measures how the error of the dam's energy balance decreases with its time
step, for every kind of damping and of crack: the largest error relative to the
peak kinetic energy, at the time step of the scene and at a half, a quarter and
an eighth of it.

Writes ledger.md and ledger.csv.

Example:
  cofferdam-lab ledger scenes/koyna-coarse --output studies/ledger \\
    --set time.duration=7

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// Changes of the scene.
const VARIANTS: [(&str, &[&str]); 10] = [
    ("as the scene is", &[]),
    ("reduced blocks", &["dam.fidelity=\"reduced\""]),
    ("mass damping", &["dam.damping.model=\"mass\""]),
    ("stiffness damping", &["dam.damping.model=\"stiffness\""]),
    ("local damping", &["dam.damping.model=\"local\""]),
    ("no damping", &["dam.damping.ratio=0"]),
    ("bonded crack", &["dam.cracks.0.cohesion=3e5", "dam.cracks.0.tensile_strength=3e5"]),
    ("dilating crack", &["dam.cracks.0.dilation=0.1", "dam.cracks.0.dilation_slip=0.05"]),
    ("contacts at Gauss points", &["dam.cracks.0.integration=\"gauss\""]),
    ("added mass", &["coupling.scheme=\"added-mass\"", "reservoir.fidelity=\"incompressible\""]),
];
const PARTS: [u32; 4] = [1, 2, 4, 8];

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    if loaded.scene.dam.as_ref().is_none_or(|dam| dam.cracks.is_empty()) {
        return Err(unfit("the study needs a dam with a crack"));
    }
    let (variants, parts) =
        if arguments.coarse { (&VARIANTS[..2], &PARTS[..3]) } else { (&VARIANTS[..], &PARTS[..]) };
    // All scenes are checked before anything is computed.
    let mut scenes = Vec::new();
    for (_, changes) in variants {
        let sets: Vec<String> =
            arguments.set.iter().cloned().chain(changes.iter().map(ToString::to_string)).collect();
        let LoadedScene { scene, .. } = read_scene(&arguments.scene, &sets)?;
        if scene.dam.is_none() {
            continue;
        }
        for &part in parts {
            let safety = Assembly::of(&scene).safety_of_part(f64::from(part))?;
            let sets = [&sets[..], &[format!("dam.time_step_safety={safety}")]].concat();
            scenes.push(read_scene(&arguments.scene, &sets)?);
        }
    }
    let outcomes = run_all(&scenes)?;
    let headings =
        parts.iter().map(|part| if *part == 1 { "the time step".to_owned() } else { format!("1/{part}") });
    let mut table = Table::new(["".to_owned()].into_iter().chain(headings).chain(["order".to_owned()]));
    let mut outcomes = outcomes.into_iter();
    for (name, _) in variants {
        let mut errors = Vec::new();
        for outcome in outcomes.by_ref().take(parts.len()) {
            let outcome = outcome.completed(name)?;
            errors.push(outcome.peak("dam.energy_balance_error") / outcome.peak("dam.kinetic_energy"));
        }
        let order = (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64;
        let cells = errors.iter().map(|error| format!("{error:.1e}"));
        table.row([name.to_string()].into_iter().chain(cells).chain([format!("{order:.1}")]));
    }
    let text = format!(
        "`cofferdam-lab ledger {}{}`: largest error of the energy balance over the peak kinetic energy\n\n{}",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
    );
    print(&text);
    arguments.write("ledger.md", &text)?;
    arguments.write_table("ledger.csv", &table)
}
