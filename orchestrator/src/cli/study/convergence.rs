//! `cofferdam study convergence`.

mod figure;

use super::{Arguments, CREST, Outcome, SLIDING, StudyError, moments, quoted, run_all, unfit};
use crate::cli::say;
use crate::cli::table::Table;
use orchestrator::registry;

pub const HELP: &str = "\
How far results of a scene are from those of fine elements, beside how far they scatter: its elements refined to a quarter,
contacts at nodes and at Gauss points, each with five factors on the shaking from 0.98 to 1.02. The mean over the factors
shows the bias of a mesh, which refinement removes; the scatter about it is the block's own and remains. Sliding is that of
the lowest crack.

Writes convergence.md, convergence.csv and convergence.svg.

Example:
  cofferdam study convergence scenes/koyna-northridge-1994 --output studies/convergence

Exit status: 0, 1 results could not be written, 2 the scene is wrong or does not fit, 3 a run failed, 4 a unit cannot be
made.";

/// Lengths of the elements, over that of the scene.
const LENGTHS: [f64; 5] = [1.0, 0.7, 0.5, 0.36, 0.25];
const FACTORS: [f64; 5] = [0.98, 0.99, 1.0, 1.01, 1.02];
const CONTACTS: [&str; 2] = ["nodal", "gauss"];

/// The runs of a mesh with contacts of one kind.
struct Ensemble {
    contacts: &'static str,
    /// Length of the elements, m.
    length: f64,
    /// Crest motion and sliding, mm: mean and standard deviation over the factors.
    crest: [f64; 2],
    sliding: [f64; 2],
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let Some(dam) = loaded.scene.dam.as_ref().filter(|dam| !dam.cracks.is_empty()) else {
        return Err(unfit("the study needs a dam with a crack"));
    };
    let Some(record) = &loaded.scene.ground_motion.record else {
        return Err(unfit("the study needs a record as ground motion"));
    };
    let (lengths, factors) =
        if arguments.coarse { (&LENGTHS[..2], &FACTORS[1..3]) } else { (&LENGTHS[..], &FACTORS[..]) };
    let ensembles: Vec<(&str, f64)> = CONTACTS
        .into_iter()
        .flat_map(|contacts| lengths.iter().map(move |part| (contacts, part * dam.element_size)))
        .collect();
    // All scenes are checked before anything is computed.
    let mut scenes = Vec::new();
    for (contacts, length) in &ensembles {
        for factor in factors {
            let mut sets = arguments.set.clone();
            sets.push(format!("dam.element_size={length}"));
            sets.push(format!("ground_motion.record.scale={}", factor * record.scale));
            sets.extend((0..dam.cracks.len()).map(|i| format!("dam.cracks.{i}.integration=\"{contacts}\"")));
            scenes.push(registry::read(&arguments.scene, &sets)?);
        }
    }
    let mut outcomes = run_all(&scenes)?.into_iter();
    let mut measured = Vec::new();
    for (contacts, length) in ensembles {
        let of_mesh: Vec<Outcome> = outcomes
            .by_ref()
            .take(factors.len())
            .map(|outcome| outcome.completed(&format!("{length} m, {contacts}")))
            .collect::<Result<_, _>>()?;
        let over = |measure: fn(&Outcome) -> f64| moments(of_mesh.iter().map(|run| 1e3 * measure(run)));
        let (crest, sliding) = (over(|run| run.peak(CREST)), over(|run| run.last(SLIDING)));
        measured.push(Ensemble { contacts, length, crest, sliding });
    }
    let (text, table) = report(arguments, factors, &measured);
    say(&text);
    arguments.write("convergence.md", &text)?;
    arguments.write_table("convergence.csv", &table)?;
    arguments.write("convergence.svg", &figure::picture(&measured)?)
}

fn report(arguments: &Arguments, factors: &[f64], measured: &[Ensemble]) -> (String, Table) {
    let mut table = Table::new([
        "contacts",
        "elements, m",
        "crest, mm",
        "scatter of the crest",
        "against the finest",
        "sliding, mm",
        "scatter of sliding",
        "against the finest",
    ]);
    for Ensemble { contacts, length, crest, sliding } in measured {
        let finest = measured.iter().rfind(|other| other.contacts == *contacts);
        let percent = |part: f64| format!("{:.1} %", 100.0 * part);
        let cells = |[mean, deviation]: [f64; 2], of_finest: Option<f64>| {
            let bias = of_finest.map_or(0.0, |finest| mean / finest - 1.0);
            [format!("{mean:.1}"), percent(deviation / mean.abs()), format!("{:+.1} %", 100.0 * bias)]
        };
        let crest = cells(*crest, finest.map(|finest| finest.crest[0]));
        let sliding = cells(*sliding, finest.map(|finest| finest.sliding[0]));
        let name = [(*contacts).to_owned(), format!("{length:.2}")];
        table.row(name.into_iter().chain(crest).chain(sliding));
    }
    let text = format!(
        "`cofferdam study convergence {}{}`: means over {} factors on the shaking from {} to {}\n\n{}\n\
         Scatter: standard deviation over the factors, over the mean. Against the finest: the mean over that of the finest elements \
         with the same contacts, less 1; what remains of a mean's scatter, over the root of the number of factors, is no bias.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        factors.len(),
        factors[0],
        factors[factors.len() - 1],
        table.markdown(),
    );
    (text, table)
}
