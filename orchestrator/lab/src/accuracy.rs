//! `cofferdam-lab accuracy`.

use crate::context::context;
use crate::study::seconds;
use crate::study::{Arguments, StudyError, moments};
use crate::terminal::print;
use cofferdam_analysis::accuracy::pilot::{self, Outcome};
use cofferdam_analysis::accuracy::table::{ErrorTable, LevelError, TABLE};
use cofferdam_analysis::accuracy::{self, CREST, HISTORY, Ladder, MORE_OR_LESS, SLIDING, apart};
use cofferdam_analysis::table::Table;
use cofferdam_assembly::read_scene;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::{DamFidelityScene, LoadedScene};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub const HELP: &str = "\
Measures the errors of all levels of numerics against the reference, for scenes
with both polarities of their records. The reference has every element and
contact, the finest elements, half the communication step, Radau IIA and a
tolerance of 1e-8; steps that remain above this tolerance are counted. Then
runs each scene as `run --accuracy` would at 10, 5 and 1 %, and reports the
expected and the true errors and the cost relative to the reference.

The effect of a change of 1 % in the shaking is measured with every element and
contact in the finest mesh. If it is above 10 %, the difference of two runs is
a random realisation; it is then listed in levels.csv, but excluded from the
table of biases. A reference run takes some minutes.

Writes accuracy.md, accuracy.csv (results of `run --accuracy`), levels.csv and
table.toml. To make `run --accuracy` and `plan` use table.toml, copy it to
orchestrator/analysis/src/accuracy. With --coarse, the reference is a level of
the ladder; this serves only to try the study.

Examples:
  cofferdam-lab accuracy scenes/koyna-intact scenes/koyna-northridge-1994 \\
    scenes/pine-flat-taft --output studies/accuracy
  cofferdam-lab accuracy scenes/koyna-northridge-1994 \\
    --record scenes/records/*.csv --strongest 10 --output studies/accuracy
      Each of these records instead of that of the scene; of each, the ten
      seconds with most of its energy.

Exit status: 0 completed, 1 results could not be written, 2 a scene is invalid
or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// Arguments of the study.
#[derive(clap::Args)]
pub struct AccuracyArguments {
    /// Folders with a scene.toml, or .toml files
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    /// Change a value of every scene (repeatable)
    #[arg(short, long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Run every scene with each of these records instead of its own
    #[arg(short, long, value_name = "FILE", num_args = 1..)]
    record: Vec<PathBuf>,

    /// Use only the part of this length of every record, s, with the largest ∫ a² dt
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    strongest: Option<f64>,

    /// Folder for tables; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Use a level as the reference, and an accuracy of 5 % only
    #[arg(long)]
    coarse: bool,
}

/// Requested accuracies.
const ASKED: [f64; 3] = [0.1, 0.05, 0.01];
/// Width of a class of intensity, g.
const INTENSITY: f64 = 0.25;
/// Change with 1 % of shaking above which a result is not defined to any requested accuracy: the difference of two
/// runs is then a random realisation, and gives no information on the bias of a level.
const UNDEFINED: f64 = ASKED[0];

/// The error of a level in one case.
struct Measured {
    /// Number of the case.
    case: usize,
    row: LevelError,
    /// Effect of 1 % of shaking on the history of the crest, with all elements; `None` for dams without cracks.
    change: Option<f64>,
}

impl Measured {
    /// Whether it tells of the level.
    fn is_defined(&self) -> bool {
        self.change.is_none_or(|change| change <= UNDEFINED)
    }
}

/// One scene with one polarity.
struct Case {
    path: PathBuf,
    settings: Vec<String>,
    loaded: LoadedScene,
    cracked: bool,
    /// The low-fidelity level of its dam.
    fidelity: DamFidelityScene,
    /// Largest acceleration of the ground, g.
    intensity: f64,
    label: String,
}

pub fn run(arguments: &AccuracyArguments) -> Result<(), StudyError> {
    let AccuracyArguments { scenes, set, record, strongest, output, coarse } = arguments;
    let mut cases = Vec::new();
    for path in scenes {
        let own = if record.is_empty() { vec![Vec::new()] } else { named(record)? };
        for record in own {
            let mut settings: Vec<String> = record.into_iter().chain(set.iter().cloned()).collect();
            let loaded = read_scene(path, &settings)?;
            if let Some(length) = strongest {
                settings.extend(strongest_part(&loaded, *length));
            }
            let polarity = loaded.scene.ground_motion.record.map_or(1, |record| record.polarity);
            for polarity in [polarity, -polarity] {
                cases.push(case(path, &settings, polarity)?);
            }
        }
    }
    let rest =
        Arguments { scene: scenes[0].clone(), set: set.clone(), output: output.clone(), coarse: *coarse };
    rest.load()?;
    let mut knob = Table::new([
        "case",
        "requested",
        "verdict",
        "chosen dam and elements, m",
        "expected: crest, history, sliding",
        "true: crest, history, sliding",
        "within",
        "1 % of shaking changes: crest, sliding",
        "pilot and run, s",
        "reference, s",
        "cost relative to the reference",
        "steps of the reference above its tolerance",
    ]);
    let mut levels: Vec<Measured> = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        let ladder = Ladder::of(&case.loaded.scene);
        let with = |further: Vec<String>| case.settings.iter().cloned().chain(further).collect::<Vec<_>>();
        let last = if *coarse { 0 } else { Ladder::RUNGS - 1 };
        let own = match coarse {
            true => ladder.settings(&case.loaded.scene, 1, case.fidelity),
            false => ladder.reference(&case.loaded.scene),
        };
        let mut levels_of_case: Vec<_> = (0..=last).map(|rung| (rung, case.fidelity)).collect();
        if case.cracked {
            levels_of_case.push((last, DamFidelityScene::Dem));
        }
        // The reference first, then the most expensive level and the effect of 1 % of shaking on it: the longest runs begin first.
        let mut runs = vec![with(own)];
        for (rung, fidelity) in levels_of_case.iter().rev() {
            let level = with(ladder.settings(&case.loaded.scene, *rung, *fidelity));
            if *fidelity == DamFidelityScene::Dem {
                runs.extend(
                    [1.0 - MORE_OR_LESS, 1.0 + MORE_OR_LESS].map(|factor| case.shaken(&level, factor)),
                );
            }
            runs.push(level);
        }
        let mut outcomes = pilot::run(&case.path, &runs, &context())?;
        let reference = outcomes.remove(0);
        print(format!(
            "{}: reference in {:.1} s, crest {:.2} mm, sliding {:.2} mm",
            case.label,
            reference.wall,
            1e3 * reference.peak(),
            1e3 * reference.slid()
        ));
        let twins: Vec<_> = outcomes.drain(..if case.cracked { 2 } else { 0 }).collect();
        let finest = &outcomes[0];
        let change = |quantity: &str| twins.iter().map(|twin| apart(quantity, twin, finest)).reduce(f64::max);
        for ((rung, fidelity), outcome) in levels_of_case.iter().rev().zip(&outcomes) {
            for quantity in quantities(case.cracked) {
                let row = LevelError {
                    cracked: case.cracked,
                    fidelity: *fidelity,
                    rung: *rung,
                    quantity: (*quantity).to_owned(),
                    intensity: case.intensity,
                    bias: signed(quantity, outcome, &reference),
                    spread: 0.0,
                    cases: 1,
                };
                let of = if *quantity == HISTORY { CREST } else { quantity };
                levels.push(Measured { case: number, row, change: change(of) });
            }
        }
        for asked in if *coarse { &ASKED[1..2] } else { &ASKED[..] } {
            row(case, *asked, &reference, &change, &mut knob)?;
        }
        // A study that is interrupted keeps the cases that it has done.
        write(&rest, &cases, &levels, &knob)?;
    }
    print(format!("{}\n{}", knob.markdown(), shown(&of_cases(&levels)).markdown()));
    Ok(())
}

/// The next table, from all cases with a defined result.
fn of_cases(levels: &[Measured]) -> ErrorTable {
    let defined = levels.iter().filter(|level| level.is_defined());
    let levels = gathered(defined.map(|level| level.row.clone()).collect());
    ErrorTable { version: TABLE.version + 1, levels }
}

/// Writes what the cases so far say.
fn write(rest: &Arguments, cases: &[Case], levels: &[Measured], knob: &Table) -> Result<(), StudyError> {
    let mut of_levels = Table::new([
        "case",
        "cracked",
        "dam",
        "rung",
        "quantity",
        "peak acceleration, g",
        "error",
        "1 % of shaking changes",
    ]);
    for Measured { case, row, change } in levels {
        of_levels.row([
            cases[*case].label.clone(),
            row.cracked.to_string(),
            row.fidelity.word(),
            row.rung.to_string(),
            row.quantity.clone(),
            format!("{:.3}", row.intensity),
            format!("{:.5}", row.bias),
            change.map_or_else(String::new, |change| format!("{change:.5}")),
        ]);
    }
    let table = of_cases(levels);
    rest.write("accuracy.md", &format!("{}\n{}", knob.markdown(), shown(&table).markdown()))?;
    rest.write_table("accuracy.csv", knob)?;
    rest.write_table("levels.csv", &of_levels)?;
    let failed = |cause: toml::ser::Error| StudyError::File {
        path: rest.output.join("table.toml"),
        cause: cause.into(),
    };
    rest.write("table.toml", &toml::to_string(&table).map_err(failed)?)
}

impl Case {
    /// These settings with `factor` times the shaking.
    fn shaken(&self, settings: &[String], factor: f64) -> Vec<String> {
        let scale = self.loaded.scene.ground_motion.record.as_ref().map_or(1.0, |record| record.scale);
        let scale = format!("ground_motion.record.scale={}", factor * scale);
        settings.iter().cloned().chain([scale]).collect()
    }
}

fn case(path: &Path, set: &[String], polarity: i64) -> Result<Case, StudyError> {
    let mut settings = set.to_vec();
    settings.push(format!("ground_motion.record.polarity={polarity}"));
    let loaded = read_scene(path, &settings)?;
    let dam = loaded.scene.dam.as_ref();
    let cracked = dam.is_some_and(|dam| !dam.cracks.is_empty() && !dam.fidelity.is_intact());
    let fidelity = if cracked { DamFidelityScene::Reduced } else { DamFidelityScene::Intact };
    let intensity = loaded.ground_motion.peak().0.abs() / STANDARD_GRAVITY;
    let label = format!("{}, {}, {polarity:+}", loaded.name, loaded.ground_motion.source());
    Ok(Case { path: path.to_owned(), settings, loaded, cracked, fidelity, intensity, label })
}

/// The settings of records, each from where the command runs.
fn named(records: &[PathBuf]) -> Result<Vec<Vec<String>>, StudyError> {
    let each = records.iter().map(|record| {
        let path = std::path::absolute(record)
            .map_err(|cause| StudyError::File { path: record.clone(), cause: cause.into() })?;
        // The whole table: what a scene says of its own record holds for no other.
        Ok(vec![format!("ground_motion.record={{file={:?}}}", path.display().to_string())])
    });
    each.collect()
}

/// The settings that leave `length` (s) of a record, where ∫ a² dt is largest.
fn strongest_part(loaded: &LoadedScene, length: f64) -> Vec<String> {
    let motion = &loaded.ground_motion;
    let Some(record) = &loaded.scene.ground_motion.record else { return Vec::new() };
    let samples = ((length / motion.interval()).round() as usize).max(1);
    let energy = |window: &[f64]| window.iter().map(|a| a * a).sum::<f64>();
    let windows = motion.acceleration().windows(samples).map(energy).enumerate();
    let Some((first, _)) = windows.max_by(|a, b| a.1.total_cmp(&b.1)) else { return Vec::new() };
    let start = record.start + first as f64 * motion.interval();
    vec![
        format!("ground_motion.record.start={start}"),
        format!("ground_motion.record.end={}", start + (samples - 1) as f64 * motion.interval()),
    ]
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
fn row(
    case: &Case,
    share: f64,
    reference: &Outcome,
    change: &dyn Fn(&str) -> Option<f64>,
    table: &mut Table,
) -> Result<(), StudyError> {
    let began = Instant::now();
    let all = share.to_string().parse().unwrap_or_default();
    let promise = accuracy::promise(&case.path, &case.settings, &case.loaded, &all, &context())?;
    let settings: Vec<String> = case.settings.iter().chain(&promise.record.chosen).cloned().collect();
    let run = pilot::run(&case.path, &[settings], &context())?.remove(0);
    let taken = began.elapsed().as_secs_f64();
    let found = |quantity: &str| apart(quantity, &run, reference);
    let percent =
        |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{:.2} %", 100.0 * v));
    let list =
        |value: &dyn Fn(&str) -> Option<f64>| [CREST, HISTORY, SLIDING].map(|q| percent(value(q))).join(", ");
    let asked = &promise.record.asked;
    let within = asked.iter().all(|(quantity, asked)| found(quantity) <= *asked);
    let chosen = |key: &str| {
        let mut values = promise.record.chosen.iter().filter_map(|chosen| chosen.strip_prefix(key));
        values.next_back().unwrap_or("").trim_matches('"').to_owned()
    };
    table.row([
        case.label.clone(),
        format!("{} %", 100.0 * share),
        promise.record.verdict.clone(),
        format!("{} {}", chosen("dam.fidelity="), chosen("dam.element_size=")),
        list(&|quantity| promise.record.expected.get(quantity).copied()),
        list(&|quantity| quantities(case.cracked).contains(&quantity).then(|| found(quantity))),
        if within { "yes" } else { "no" }.to_owned(),
        [CREST, SLIDING].map(|quantity| percent(change(quantity))).join(", "),
        format!("{taken:.1}"),
        format!("{:.1}", reference.wall),
        format!("{:.3}", taken / reference.wall),
        reference.unconverged.to_string(),
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
        let cases = errors.len();
        let [bias, spread] = moments(errors.iter().map(|row| row.bias));
        // of a sample, which these cases are
        let spread = spread * (cases as f64 / (cases - 1).max(1) as f64).sqrt();
        let intensity = errors.iter().map(|row| row.intensity).fold(0.0, f64::max);
        found.push(LevelError { intensity, bias, spread, cases, ..row.clone() });
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
