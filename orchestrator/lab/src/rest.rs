//! `cofferdam-lab rest`.

use crate::study::{Arguments, SLIDING, StudyError, quoted, run_all, unfit};
use crate::terminal::print;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::observer::LastSecond;
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_scene::{DamScene, LoadedScene};
use std::f64::consts::TAU;

pub const HELP: &str = "\
Compares the motion of the block after the ground has stopped with the
eigenvalues of the sliding dam: the section of the scene at heights of 30, 60
and 103 m with its crack at 1 m, at half the height and at the neck, friction
from 0.3 to 1, two depths of water, several kinds of damping, and two meshes.
The blocks are reduced, so that a row takes seconds.

Writes rest.md and rest.csv.

Example:
  cofferdam-lab rest scenes/koyna-coarse --output studies/rest \\
    --set ground_motion.record.start=4 --set ground_motion.record.end=9 \\
    --set time.quiet=8

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 4 a unit cannot be created.";

/// One row: height and elevation of the crack (m), friction, depth over height, damping, elements per height.
#[derive(Clone, Copy)]
struct Row {
    height: f64,
    crack: f64,
    friction: f64,
    depth: f64,
    damping: &'static str,
    elements: f64,
}

const HEIGHTS: [f64; 3] = [30.0, 60.0, 103.0];
const FRICTIONS: [f64; 4] = [0.3, 0.45, 0.6, 1.0];
/// Depth of the water over the height of the dam: full, and with half the thrust.
const DEPTHS: [f64; 2] = [0.9, 0.636];

fn rows(neck: Option<f64>, coarse: bool) -> Vec<Row> {
    let usual = Row {
        height: 0.0,
        crack: 1.0,
        friction: 0.45,
        depth: DEPTHS[0],
        damping: "rayleigh",
        elements: 20.0,
    };
    let cracks =
        |height: f64| [Some(1.0), Some(0.5 * height), neck.map(|neck| neck * height)].into_iter().flatten();
    let places = HEIGHTS
        .into_iter()
        .flat_map(|height| cracks(height).map(move |crack| Row { height, crack, ..usual }));
    if coarse {
        let few = HEIGHTS.map(|height| Row { height, ..usual });
        return [few[0], few[2], Row { friction: 0.3, ..few[0] }, Row { damping: "stiffness", ..few[0] }]
            .to_vec();
    }
    let mut all = Vec::new();
    for place in places {
        all.extend(FRICTIONS.map(|friction| Row { friction, ..place }));
        all.push(Row { depth: DEPTHS[1], ..place });
        all.extend(["mass", "stiffness"].map(|damping| Row { damping, ..place }));
        all.push(Row { elements: 40.0, ..place });
    }
    all
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let Some(dam) = loaded.scene.dam.as_ref().filter(|dam| dam.cracks.len() == 1) else {
        return Err(unfit("the study needs a dam with one crack"));
    };
    if loaded.ground_motion.rest_from().is_none() {
        return Err(unfit("the study needs a ground motion that ends"));
    }
    let (height, neck) = shape(dam);
    let rows = rows(neck, arguments.coarse);
    let scenes: Vec<Option<LoadedScene>> = rows
        .iter()
        .map(|row| read_scene(&arguments.scene, &[&arguments.set[..], &sets(dam, height, row)].concat()).ok())
        .collect();
    let (indices, valid): (Vec<usize>, Vec<LoadedScene>) =
        scenes.into_iter().enumerate().filter_map(|(index, scene)| Some((index, scene?))).unzip();
    let outcomes = run_all(&valid)?;
    let mut table = Table::new([
        "height, m",
        "crack at, m",
        "friction",
        "depth/height",
        "damping",
        "element, m",
        "factor of safety",
        "growth, 1/s",
        "at, Hz",
        "speed at the end, mm/s",
        "kinetic energy over its peak",
        "residual sliding, mm",
        "verdict",
    ]);
    for (index, row) in rows.iter().enumerate() {
        let mut cells = vec![
            row.height.to_string(),
            format!("{:.1}", row.crack),
            row.friction.to_string(),
            row.depth.to_string(),
            row.damping.to_owned(),
            format!("{:.2}", row.height / row.elements),
        ];
        match indices.iter().position(|valid| *valid == index) {
            None => cells.extend(["", "", "", "", "", "", "cannot stand"].map(str::to_owned)),
            Some(at) => {
                let scene = &valid[at].scene;
                let safety = Assembly::of(scene)
                    .limit_equilibria()?
                    .first()
                    .map_or(f64::INFINITY, |limit| limit.sliding);
                cells.push(format!("{safety:.2}"));
                let downstream =
                    Assembly::of(scene).flutter()?.into_iter().find(|(vibration, _)| vibration.downstream);
                cells.extend(match downstream {
                    Some((vibration, _)) => {
                        [format!("{:.2}", vibration.growth), format!("{:.1}", vibration.frequency / TAU)]
                    }
                    None => ["tips over".to_owned(), String::new()],
                });
                let outcome = &outcomes[at];
                let last = LastSecond::of(&outcome.histories, SLIDING);
                cells.extend(match (&outcome.failure, last) {
                    (None, Some(last)) => [
                        format!("{:.3}", 1e3 * last.speed),
                        format!("{:.1e}", last.kinetic_share),
                        if last.is_rest() { format!("{:.1}", 1e3 * last.sliding) } else { String::new() },
                        if last.is_rest() { "at rest" } else { "moves" }.to_owned(),
                    ],
                    _ => ["", "", "", "failed"].map(str::to_owned),
                });
            }
        }
        table.row(cells);
    }
    let failures: Vec<String> =
        outcomes.iter().filter_map(|outcome| Some(outcome.failure.as_ref()?.to_string())).collect();
    let text = format!(
        "`cofferdam-lab rest {}{}`\n\n{}\nRuns that did not reach their end: {}.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
        if failures.is_empty() { "none".to_owned() } else { failures.join("; ") },
    );
    print(&text);
    arguments.write("rest.md", &text)?;
    arguments.write_table("rest.csv", &table)
}

/// Height of the scene's section (m), and the lowest kink of its downstream face over it.
fn shape(dam: &DamScene) -> (f64, Option<f64>) {
    let downstream = &dam.section.downstream;
    let height = downstream.last().map_or(1.0, |crest| crest[1]);
    let neck = downstream.get(1..downstream.len() - 1).and_then(|kinks| kinks.first());
    (height, neck.map(|kink| kink[1] / height))
}

/// The keys of a row.
fn sets(dam: &DamScene, height: f64, row: &Row) -> Vec<String> {
    let face = |points: &[[f64; 2]]| {
        let scaled = points.iter().map(|point| point.map(|x| x * row.height / height));
        format!("{:?}", scaled.collect::<Vec<_>>())
    };
    vec![
        format!(
            "dam.section={{upstream = {}, downstream = {}}}",
            face(&dam.section.upstream),
            face(&dam.section.downstream)
        ),
        format!("reservoir.depth={}", row.depth * row.height),
        format!("dam.cracks.0.elevation={}", row.crack),
        format!("dam.cracks.0.friction_coefficient={}", row.friction),
        format!("dam.damping.model=\"{}\"", row.damping),
        format!("dam.element_size={}", row.height / row.elements),
        "dam.fidelity=\"reduced\"".to_owned(),
    ]
}
