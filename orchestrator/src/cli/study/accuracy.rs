//! `cofferdam study accuracy`.

use super::{Arguments, StudyError};
use crate::cli::accuracy::pilot::{self, Outcome};
use crate::cli::accuracy::table::{ErrorTable, LevelError, TABLE};
use crate::cli::accuracy::{self, CREST, HISTORY, Ladder, SLIDING, apart};
use crate::cli::say;
use crate::cli::table::Table;
use orchestrator::ground_motion::STANDARD_GRAVITY;
use orchestrator::registry;
use orchestrator::scene::{DamFidelityScene, LoadedScene};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub const HELP: &str = "\
Measures the errors of all levels of numerics against the reference (every element and contact, the finest elements, half the
communication step, Radau IIA, a tolerance of 1e-8), for scenes with both polarities of their records; then runs each as
`run --accuracy` would at 10, 5 and 1 %, and says what was promised, what was true, and what it cost beside the reference.
A reference costs some minutes.

Writes accuracy.md, accuracy.csv (the knob), levels.csv and table.toml: put the latter into orchestrator/src/cli/accuracy to have
`run --accuracy` and `plan` read it. With --coarse the reference is a level of the ladder, only to try the study.

Example:
  cofferdam study accuracy scenes/koyna-intact scenes/koyna-northridge-1994 scenes/pine-flat-taft --output studies/accuracy

Exit status: 0, 1 results could not be written, 2 a scene is wrong or does not fit, 3 a run failed, 4 a unit cannot be made.";

/// Arguments of the study.
#[derive(clap::Args)]
pub struct AccuracyArguments {
    /// Folders that hold scene.toml, or .toml files
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    /// Change a value of every scene; may be given several times
    #[arg(short, long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Folder for tables; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// A level as reference, and 5 % alone
    #[arg(long)]
    coarse: bool,
}

/// What is asked of the knob.
const ASKED: [f64; 3] = [0.1, 0.05, 0.01];
/// Width of a class of intensity, g.
const INTENSITY: f64 = 0.25;

/// One scene with one polarity.
struct Case {
    path: PathBuf,
    settings: Vec<String>,
    loaded: LoadedScene,
    cracked: bool,
    /// The cheap level of its dam.
    fidelity: DamFidelityScene,
    /// Largest acceleration of the ground, g.
    intensity: f64,
    label: String,
}

pub fn run(arguments: &AccuracyArguments) -> Result<(), StudyError> {
    let AccuracyArguments { scenes, set, output, coarse } = arguments;
    let mut cases = Vec::new();
    for path in scenes {
        let scale = registry::read(path, set)?.scene.ground_motion.record.map_or(1, |record| record.polarity);
        for polarity in [scale, -scale] {
            cases.push(case(path, set, polarity)?);
        }
    }
    let rest =
        Arguments { scene: scenes[0].clone(), set: set.clone(), output: output.clone(), coarse: *coarse };
    rest.load()?;
    let mut knob = Table::new([
        "case",
        "asked",
        "verdict",
        "chosen elements, m",
        "expected: crest, history, sliding",
        "true: crest, history, sliding",
        "within",
        "pilot and run, s",
        "reference, s",
        "cost over that of the reference",
    ]);
    let mut levels: Vec<(usize, LevelError)> = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        let ladder = Ladder::of(&case.loaded.scene);
        let with = |further: Vec<String>| case.settings.iter().cloned().chain(further).collect::<Vec<_>>();
        let own = match coarse {
            true => ladder.settings(&case.loaded.scene, 1, case.fidelity),
            false => ladder.reference(&case.loaded.scene),
        };
        let reference = pilot::run(&case.path, &[with(own)])?.remove(0);
        say(format!(
            "{}: reference in {:.1} s, crest {:.2} mm, sliding {:.2} mm",
            case.label,
            reference.wall,
            1e3 * reference.peak(),
            1e3 * reference.slid()
        ));
        let rungs = if *coarse { 1 } else { Ladder::RUNGS };
        let runs: Vec<_> =
            (0..rungs).map(|rung| with(ladder.settings(&case.loaded.scene, rung, case.fidelity))).collect();
        for (rung, outcome) in pilot::run(&case.path, &runs)?.iter().enumerate() {
            for quantity in quantities(case.cracked) {
                let bias = signed(quantity, outcome, &reference);
                let (cracked, fidelity) = (case.cracked, case.fidelity);
                let row = LevelError {
                    cracked,
                    fidelity,
                    rung,
                    quantity: (*quantity).to_owned(),
                    intensity: case.intensity,
                    bias,
                    spread: 0.0,
                    cases: 1,
                };
                levels.push((number, row));
            }
        }
        for asked in if *coarse { &ASKED[1..2] } else { &ASKED[..] } {
            row(case, *asked, &reference, &mut knob)?;
        }
    }
    let mut of_levels =
        Table::new(["case", "cracked", "dam", "rung", "quantity", "peak acceleration, g", "error"]);
    for (number, row) in &levels {
        of_levels.row([
            cases[*number].label.clone(),
            row.cracked.to_string(),
            row.fidelity.word(),
            row.rung.to_string(),
            row.quantity.clone(),
            format!("{:.3}", row.intensity),
            format!("{:.5}", row.bias),
        ]);
    }
    let table = ErrorTable {
        version: TABLE.version + 1,
        levels: gathered(levels.into_iter().map(|(_, row)| row).collect()),
    };
    let text = format!("{}\n{}", knob.markdown(), shown(&table).markdown());
    say(&text);
    rest.write("accuracy.md", &text)?;
    rest.write_table("accuracy.csv", &knob)?;
    rest.write_table("levels.csv", &of_levels)?;
    let failed =
        |cause: toml::ser::Error| StudyError::File { path: output.join("table.toml"), cause: cause.into() };
    rest.write("table.toml", &toml::to_string(&table).map_err(failed)?)
}

fn case(path: &Path, set: &[String], polarity: i64) -> Result<Case, StudyError> {
    let mut settings = set.to_vec();
    settings.push(format!("ground_motion.record.polarity={polarity}"));
    let loaded = registry::read(path, &settings)?;
    let dam = loaded.scene.dam.as_ref();
    let cracked = dam.is_some_and(|dam| !dam.cracks.is_empty() && dam.fidelity != DamFidelityScene::Intact);
    let fidelity = if cracked { DamFidelityScene::Reduced } else { DamFidelityScene::Intact };
    let intensity = loaded.ground_motion.peak().0.abs() / STANDARD_GRAVITY;
    let label = format!("{}, {}, {polarity:+}", loaded.name, loaded.ground_motion.source());
    Ok(Case { path: path.to_owned(), settings, loaded, cracked, fidelity, intensity, label })
}

/// The quantities of a dam.
fn quantities(cracked: bool) -> &'static [&'static str] {
    if cracked { &[CREST, HISTORY, SLIDING] } else { &[CREST, HISTORY] }
}

/// An error with its sign, where it has one.
fn signed(quantity: &str, run: &Outcome, exact: &Outcome) -> f64 {
    let error = apart(quantity, run, exact);
    let less = match quantity {
        CREST => run.peak() < exact.peak(),
        SLIDING => run.slid() < exact.slid(),
        _ => false,
    };
    if less { -error } else { error }
}

/// Runs a case as `run --accuracy` does, and adds what came of it.
fn row(case: &Case, share: f64, reference: &Outcome, table: &mut Table) -> Result<(), StudyError> {
    let began = Instant::now();
    let all = accuracy::asked(&share.to_string()).unwrap_or_default();
    let promise = accuracy::promise(&case.path, &case.settings, &case.loaded, &all)?;
    let settings: Vec<String> = case.settings.iter().chain(&promise.record.chosen).cloned().collect();
    let run = pilot::run(&case.path, &[settings])?.remove(0);
    let taken = began.elapsed().as_secs_f64();
    let found = |quantity: &str| apart(quantity, &run, reference);
    let list = |value: &dyn Fn(&str) -> Option<f64>| {
        let each = [CREST, HISTORY, SLIDING].map(|quantity| {
            value(quantity).map_or_else(|| "–".to_owned(), |v| format!("{:.2} %", 100.0 * v))
        });
        each.join(", ")
    };
    let asked = &promise.record.asked;
    let within = asked.iter().all(|(quantity, asked)| found(quantity) <= *asked);
    let size =
        promise.record.chosen.iter().find_map(|key| key.strip_prefix("dam.element_size=")).unwrap_or("");
    table.row([
        case.label.clone(),
        format!("{} %", 100.0 * share),
        promise.record.verdict.clone(),
        size.to_owned(),
        list(&|quantity| promise.record.expected.get(quantity).copied()),
        list(&|quantity| quantities(case.cracked).contains(&quantity).then(|| found(quantity))),
        if within { "yes" } else { "no" }.to_owned(),
        format!("{taken:.1}"),
        format!("{:.1}", reference.wall),
        format!("{:.3}", taken / reference.wall),
    ]);
    Ok(())
}

/// Means and standard deviations of rows of the same level, quantity and class of intensity.
fn gathered(rows: Vec<LevelError>) -> Vec<LevelError> {
    let class = |row: &LevelError| (row.intensity / INTENSITY).floor();
    let same = |a: &LevelError, b: &LevelError| {
        (a.cracked, a.fidelity, a.rung, &a.quantity) == (b.cracked, b.fidelity, b.rung, &b.quantity)
            && class(a) == class(b)
    };
    let mut found: Vec<LevelError> = Vec::new();
    for row in &rows {
        if found.iter().any(|other| same(row, other)) {
            continue;
        }
        let errors: Vec<&LevelError> = rows.iter().filter(|other| same(row, other)).collect();
        let [bias, spread] = super::moments(errors.iter().map(|row| row.bias));
        let intensity = errors.iter().map(|row| row.intensity).fold(0.0, f64::max);
        found.push(LevelError { intensity, bias, spread, cases: errors.len(), ..row.clone() });
    }
    found
}

/// The table as it is printed.
fn shown(table: &ErrorTable) -> Table {
    let mut shown = Table::new(["cracks", "dam", "rung", "quantity", "up to, g", "bias", "spread", "cases"]);
    for row in &table.levels {
        let percent = |share: f64| format!("{:+.2} %", 100.0 * share);
        shown.row([
            if row.cracked { "yes" } else { "no" }.to_owned(),
            row.fidelity.word(),
            row.rung.to_string(),
            row.quantity.clone(),
            format!("{:.2}", row.intensity),
            percent(row.bias),
            percent(row.spread),
            row.cases.to_string(),
        ]);
    }
    shown
}
