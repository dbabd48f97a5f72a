//! `cofferdam-lab meshes`.

use crate::study::{Arguments, CREST, Outcome, SLIDING, StudyError, moments, quoted, run_all, unfit};
use crate::terminal::print;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_scene::{CrackScene, Integration, LoadedScene};

pub const HELP: &str = "\
Runs the scene with its lowest crack, a horizontal one, in five meshes with
elements of equal length along the crack, and with contacts at nodes and at
Gauss points. For comparison, runs the same crack in the mesh of the scene with
the shaking scaled by up to 1 %. The differences between the five meshes are to
be compared with the effect of the shaking.

Writes meshes.md and meshes.csv.

Example:
  cofferdam-lab meshes scenes/koyna-coarse --output studies/meshes

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// Factors on the shaking of the scene's own mesh.
const FACTORS: [f64; 4] = [0.99, 0.995, 1.005, 1.01];

/// A mesh: its name, its crack, and the length of its other elements, m.
type Variant = (&'static str, CrackScene, f64);

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let variants = variants(&loaded)?;
    let count = if arguments.coarse { 2 } else { variants.len() };
    let mut scenes: Vec<(String, LoadedScene)> = Vec::new();
    let contacts = [("nodal", Integration::Nodal), ("gauss", Integration::Gauss)];
    for (kind, integration) in contacts {
        for (name, crack, element_size) in &variants[..count] {
            let mut changed = loaded.clone();
            if let Some(dam) = &mut changed.scene.dam {
                dam.element_size = *element_size;
                dam.cracks[0] = CrackScene { integration, ..crack.clone() };
            }
            scenes.push((format!("{name}, {kind}"), changed));
        }
    }
    let scale = loaded.scene.ground_motion.record.as_ref().map_or(1.0, |record| record.scale);
    for factor in if arguments.coarse { &FACTORS[1..3] } else { &FACTORS[..] } {
        let sets = [&arguments.set[..], &[format!("ground_motion.record.scale={}", factor * scale)]].concat();
        let name = format!("{}, nodal, shaking {:+.1} %", variants[0].0, 100.0 * (factor - 1.0));
        scenes.push((name, read_scene(&arguments.scene, &sets)?));
    }
    let (names, scenes): (Vec<String>, Vec<LoadedScene>) = scenes.into_iter().unzip();
    let cells = scenes
        .iter()
        .map(|loaded| Ok(Assembly::of(&loaded.scene).dam_mesh()?.map_or(0, |mesh| mesh.cells.len())));
    let cells = cells.collect::<Result<Vec<usize>, StudyError>>()?;
    let outcomes: Vec<Outcome> = run_all(&scenes)?
        .into_iter()
        .zip(&names)
        .map(|(outcome, name)| outcome.completed(name))
        .collect::<Result<_, _>>()?;
    let found: Vec<[f64; 2]> =
        outcomes.iter().map(|run| [1e3 * run.peak(CREST), 1e3 * run.last(SLIDING)]).collect();
    let mut table = Table::new(["mesh, contacts", "cells", "crest, mm", "residual sliding, mm"]);
    for ((name, cells), [crest, sliding]) in names.iter().zip(cells).zip(&found) {
        table.row([name.clone(), cells.to_string(), format!("{crest:.1}"), format!("{sliding:.1}")]);
    }
    let shaken = || std::iter::once(found[0]).chain(found[2 * count..].iter().copied());
    for (what, of) in [
        ("meshes, contacts at nodes", found[..count].to_vec()),
        ("meshes, contacts at Gauss points", found[count..2 * count].to_vec()),
        ("the scene's mesh, shaking", shaken().collect()),
    ] {
        let cell = |i: usize| {
            let [mean, deviation] = moments(of.iter().map(|run| run[i]));
            format!("{mean:.1} ± {:.1} %", 100.0 * deviation / mean.abs())
        };
        table.row([format!("mean and scatter: {what}"), String::new(), cell(0), cell(1)]);
    }
    let text = format!(
        "`cofferdam-lab meshes {}{}`: one crack in {count} meshes, compared with the effect of the shaking\n\n{}\n\
         Scatter: standard deviation over the mean.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
    );
    print(&text);
    arguments.write("meshes.md", &text)?;
    arguments.write_table("meshes.csv", &table)
}

/// The scene's own mesh and four others with as many elements along the crack.
fn variants(loaded: &LoadedScene) -> Result<[Variant; 5], StudyError> {
    let scene = &loaded.scene;
    let dam = scene.dam.as_ref().filter(|dam| !dam.cracks.is_empty() && dam.cracks[0].elevation.is_some());
    let (Some(dam), Some(mesh), true) =
        (dam, Assembly::of(scene).dam_mesh()?, scene.ground_motion.record.is_some())
    else {
        return Err(unfit("the study needs a record, and a dam whose first crack has an `elevation`"));
    };
    let own = &dam.cracks[0];
    let lowest = dam.cracks.iter().all(|crack| crack.mean_elevation() >= own.mean_elevation());
    let Some(seam) = mesh.seams.iter().find(|seam| seam.crack == 0).filter(|_| lowest) else {
        return Err(unfit("the study needs a dam whose first crack is the lowest"));
    };
    let [from, to] = [seam.upper[0], seam.upper[seam.upper.len() - 1]].map(|node| mesh.nodes[node]);
    let along = Some((to[0] - from[0]) / (seam.upper.len() - 1) as f64);
    let without_rows = CrackScene { element_size: along, ..own.clone() };
    let line = |points: &[[f64; 2]]| CrackScene {
        elevation: None,
        polyline: Some(points.to_vec()),
        ..without_rows.clone()
    };
    let third = [from[0] + 0.36 * (to[0] - from[0]), from[1]];
    let size = dam.element_size;
    Ok([
        ("the scene's own", own.clone(), size),
        ("without rows", without_rows.clone(), size),
        ("without rows, smaller elsewhere", without_rows.clone(), 0.8 * size),
        ("a polyline with a point on it", line(&[from, third, to]), size),
        ("a polyline drawn upstream, larger elsewhere", line(&[to, from]), 1.15 * size),
    ])
}
