//! `cofferdam-lab variants`.

use crate::study::{Arguments, CREST, Outcome, SLIDING, StudyError, quoted, run_all, unfit};
use crate::terminal::print;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::read_scene;
use cofferdam_coupling::observer::Status;

pub const HELP: &str = "\
Runs the scene as it is and once for each --case, and compares crest
displacement, sliding and rotation of the lowest crack, base shear and energy
balance. Changes are relative to the first row. One run is a single
realisation: where the shaking decides, a difference of two runs is no error.

Writes variants.md and variants.csv.

Example:
  cofferdam-lab variants scenes/koyna-coarse --output studies/levels \\
    --case dam.fidelity=reduced --case 'dam.element_size=2.5 time.quiet=0'

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid, 3 a run cannot begin, 4 a unit cannot be created.";

/// Arguments of the study.
#[derive(clap::Args)]
pub struct VariantArguments {
    #[command(flatten)]
    arguments: Arguments,

    /// Changes of one further run, separated by spaces (repeatable)
    #[arg(long = "case", required = true, value_name = "KEY=VALUE…")]
    cases: Vec<String>,
}

pub fn run(VariantArguments { arguments, cases }: &VariantArguments) -> Result<(), StudyError> {
    let as_it_is = arguments.load()?;
    if as_it_is.scene.dam.is_none() {
        return Err(unfit("the study needs a dam that is computed"));
    }
    // All scenes are checked before anything is computed.
    let mut scenes = vec![as_it_is];
    for case in cases {
        let changes = case.split_whitespace().map(str::to_owned);
        let sets: Vec<String> = arguments.set.iter().cloned().chain(changes).collect();
        scenes.push(read_scene(&arguments.scene, &sets)?);
    }
    let outcomes = run_all(&scenes)?;
    let mut table = Table::new([
        "case",
        "dam steps per communication step",
        "crest down-, upstream, mm",
        "change",
        "residual sliding, mm",
        "change",
        "largest rotation, mrad",
        "base shear, MN/m",
        "balance error, %",
    ]);
    let names = std::iter::once("as it is".to_owned()).chain(cases.iter().map(|case| format!("`{case}`")));
    for (name, outcome) in names.zip(&outcomes) {
        table.row(std::iter::once(name).chain(cells(outcome, &outcomes[0])));
    }
    let set: String = arguments.set.iter().map(|set| format!(" --set {set}")).collect();
    let text = format!("`{}{set}`, one run per row\n\n{}", quoted(&arguments.scene), table.markdown());
    print(&text);
    arguments.write("variants.md", &text)?;
    arguments.write_table("variants.csv", &table)
}

/// What a run found, compared with the run of the first row.
fn cells(outcome: &Outcome, first: &Outcome) -> [String; 8] {
    let none = || "–".to_owned();
    let steps = format!("{:.2}", outcome.iterations(1));
    let ends = match outcome.ending.status {
        Status::Completed => None,
        Status::Failed(_) => Some("fails"),
        Status::Stopped(_) | Status::Interrupted => Some("stops"),
    };
    if let Some(ends) = ends {
        let at = outcome.column("time").last().copied().unwrap_or(0.0);
        let mut cells = [(); 8].map(|()| none());
        (cells[0], cells[1]) = (steps, format!("{ends} at {at:.1} s"));
        return cells;
    }
    let is_alone = std::ptr::eq(outcome, first) || first.ending.status != Status::Completed;
    // Nothing is compared with a value that is zero or was never found.
    let change = |value: f64, base: f64| {
        if is_alone || base.abs() < 1e-9 { none() } else { format!("{:+.1} %", 100.0 * (value / base - 1.0)) }
    };
    let crest = outcome.column(CREST);
    let [downstream, upstream] = [
        crest.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        crest.iter().copied().fold(f64::INFINITY, f64::min),
    ];
    let has_crack = !outcome.column(SLIDING).is_empty();
    let of_crack = |text: String| if has_crack { text } else { none() };
    let rotation = outcome
        .column("dam.crack_rotation.0")
        .iter()
        .fold(0.0, |a: f64, b| if b.abs() > a.abs() { *b } else { a });
    let balance = outcome.peak("dam.energy_balance_error") / outcome.peak("dam.kinetic_energy");
    [
        steps,
        format!("{:.1}, {:.1}", 1e3 * downstream, 1e3 * upstream),
        change(outcome.peak(CREST), first.peak(CREST)),
        of_crack(format!("{:.1}", 1e3 * outcome.last(SLIDING))),
        of_crack(change(outcome.last(SLIDING), first.last(SLIDING))),
        of_crack(format!("{:.2}", 1e3 * rotation)),
        format!("{:.1}", 1e-6 * outcome.peak("dam.base_shear")),
        if balance.is_finite() { format!("{:.2e}", 100.0 * balance) } else { none() },
    ]
}
