//! The numerics of a run from the accuracy that is asked for: a pilot of cheap twins, then the cheapest level whose error is expected
//! to be small enough.
//!
//! Levels form a ladder: five lengths of elements, the dam by modes where nothing slides and by reduced blocks where it may, the
//! recursion, and the communication step. Errors are meant against the *reference*: every element and contact, the finest elements of
//! the ladder, half the communication step, Radau IIA and a tolerance of 1e-8.

pub mod pilot;
pub mod table;

use super::say;
use cofferdam_analysis::statistics::quantile;
use cofferdam_assembly::AssemblyError;
use cofferdam_coupling::convergence::Tolerance;
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_report::{Accuracy, PlanRow, Summary};
use cofferdam_scene::{
    AccuracyScene, DamFidelityScene, DampingModel, LoadedScene, Scene, SceneError, Warning,
};
use miette::Diagnostic;
use pilot::{LEAST_SLIDING, Outcome};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

/// The quantities that can be promised.
pub const CREST: &str = "crest";
pub const HISTORY: &str = "history";
pub const SLIDING: &str = "sliding";

pub const KEPT: &str = "kept";
pub const NOT_KEPT: &str = "not kept";
pub const CANNOT: &str = "cannot be kept";

/// Factor on errors that are extrapolated from two lengths of elements, or found by other modes.
const SAFETY: f64 = 1.5;
/// Share of the change with 1 % of shaking that the numerics of the finest level may bring about: they act like a thousandth of the
/// shaking.
const LIKE_SHAKING: f64 = 0.1;
/// Modes of a block with which reduced blocks run once more, or the second number if the scene has the first: a dam takes neither by itself.
const OTHER_MODES: [usize; 2] = [48, 40];
/// Error of a level that the table does not have.
const UNMEASURED: f64 = 0.02;
/// Share of the strictest accuracy that the communication step may use up, and how often it is halved for that. Its error is that of
/// linear inputs at the highest frequency of the record, (ωH)²/12.
const OF_STEP: f64 = 0.25;
const MOST_HALVINGS: i32 = 3;
/// Share of the record's Fourier energy below its highest frequency.
const ENERGY: f64 = 0.99;
/// Changes of the shaking.
pub const MORE_OR_LESS: f64 = 0.01;

/// Why no accuracy can be promised.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum AccuracyError {
    /// The scene, with a level's keys.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A unit.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A run of the pilot.
    #[error("the pilot failed: {what}: {cause}; run without an accuracy, and look at its log")]
    Run { what: String, cause: Box<SimulationError> },
    /// A scene for which there is no ladder.
    #[error("no accuracy can be asked for here: {why}")]
    Unfit { why: String },
}

impl AccuracyError {
    /// The program's exit status.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Unfit { .. } => 2,
            Self::Run { .. } => 3,
            Self::Unit(_) => 4,
        }
    }
}

/// What is asked for: the largest error of each quantity, as a share.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked(pub BTreeMap<String, f64>);

/// Reads `5%`, `0.05` or `crest=2%,sliding=20%`; a share without a name is that of all that are not named.
pub fn asked(text: &str) -> Result<Asked, String> {
    let share = |text: &str| {
        let (number, unit) =
            text.trim().strip_suffix('%').map_or((text.trim(), 1.0), |number| (number.trim(), 0.01));
        let value =
            number.parse::<f64>().map_err(|_| format!("`{text}` is no number; write 5% or 0.05"))? * unit;
        let sound = (1e-4..=1.0).contains(&value);
        sound
            .then_some(value)
            .ok_or_else(|| format!("`{text}` must lie from 0.01 % to 100 %; 5 means 500 %, so write 5%"))
    };
    let (mut found, mut unnamed) = (BTreeMap::new(), None);
    for part in text.split(',') {
        match part.split_once('=') {
            Some((name, value)) => {
                let name = name.trim();
                if ![CREST, HISTORY, SLIDING].contains(&name) {
                    return Err(format!(
                        "there is no quantity `{name}`; {CREST}, {HISTORY} and {SLIDING} are known"
                    ));
                }
                found.insert(name.to_owned(), share(value)?);
            }
            None => unnamed = Some(share(part)?),
        }
    }
    if let Some(value) = unnamed {
        // The history of a block that slides has no limit; it is asked for by name.
        if !found.contains_key(HISTORY) {
            found.insert(UNNAMED.to_owned(), value);
        }
        for name in [CREST, HISTORY, SLIDING] {
            found.entry(name.to_owned()).or_insert(value);
        }
    }
    Ok(Asked(found))
}

impl From<AccuracyScene> for Asked {
    fn from(scene: AccuracyScene) -> Self {
        let AccuracyScene { crest, history, sliding } = scene;
        let each = [(CREST, crest), (HISTORY, history), (SLIDING, sliding)];
        Self(each.into_iter().filter_map(|(name, share)| Some((name.to_owned(), share?))).collect())
    }
}

/// Mark that quantities were not named one by one.
const UNNAMED: &str = "all";

/// The lengths of elements, m, from the coarsest.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    pub sizes: [f64; Ladder::RUNGS],
}

impl Ladder {
    pub const RUNGS: usize = 5;

    /// 5 to 1.25 m, and in proportion for dams that are lower than 103 m.
    pub fn of(scene: &Scene) -> Self {
        let part = (scene.height() / 103.0).min(1.0);
        Self { sizes: [5.0, 3.3, 2.5, 1.8, 1.25].map(|size| size * part) }
    }

    /// The settings of a rung: elements, the water's points, `fidelity` of the dam.
    pub fn settings(&self, scene: &Scene, rung: usize, fidelity: DamFidelityScene) -> Vec<String> {
        let size = self.sizes[rung];
        let mut settings =
            vec![format!("dam.element_size={size}"), format!("dam.fidelity=\"{}\"", fidelity.word())];
        // Points of the water closer than those cost its preparation and change nothing (docs/accuracy.md).
        let points = if fidelity == DamFidelityScene::Intact { self.sizes[0] } else { self.sizes[2] };
        for (side, water) in scene.waters().filter(|(_, water)| !water.is_empty()) {
            let depth = scene.depth_of(side);
            if water.interface_size.is_none()
                && size < points
                && points < depth
                && water.fidelity.has_memory()
            {
                settings.push(format!("{}={points}", side.key("interface_size")));
            }
            if water.fidelity.is_compressible() {
                settings.push(format!("{}=\"automatic\"", side.key("method")));
            }
        }
        if matches!(scene.coupling.tolerance, Tolerance::Relative(tolerance) if tolerance > 1e-3) {
            settings.push("coupling.tolerance=\"balanced\"".to_owned());
        }
        settings
    }

    /// The settings of the reference. A step that stays above the strict tolerance does not end it: it is counted.
    pub fn reference(&self, scene: &Scene) -> Vec<String> {
        let mut settings = vec![
            format!("dam.element_size={}", self.sizes[Self::RUNGS - 1]),
            "dam.fidelity=\"dem\"".to_owned(),
            "coupling.tolerance=1e-8".to_owned(),
            "coupling.on_failure=\"continue\"".to_owned(),
            format!("time.communication_step={}", scene.time.communication_step / 2.0),
        ];
        for (side, water) in scene.waters().filter(|(_, water)| water.fidelity.is_compressible()) {
            settings.push(format!("{}=\"radau2\"", side.key("method")));
            if water.interface_size.is_none() && self.sizes[2] < scene.depth_of(side) {
                settings.push(format!("{}={}", side.key("interface_size"), self.sizes[2]));
            }
        }
        settings
    }
}

/// What a run promises.
#[derive(Clone, Debug)]
pub struct Promise {
    pub record: Accuracy,
    /// The plan that stands beside it in the manifest; empty in a study.
    pub plan: Vec<PlanRow>,
}

impl Promise {
    /// The program's exit status of a completed run.
    pub fn exit_status(&self) -> u8 {
        match &*self.record.verdict {
            KEPT => 0,
            NOT_KEPT => 6,
            _ => 7,
        }
    }

    /// Adds what is promised to the notes of a summary.
    pub fn note(&self, summary: &mut Summary) {
        summary.notes.push(self.sentence());
        for (quantity, [low, median, high]) in &self.record.band {
            summary.notes.push(format!(
                "{quantity}: {low:.3}, {median:.3}, {high:.3} mm are 16 %, median and 84 % of twins within 1 % of shaking: quote this band"
            ));
        }
    }

    /// The promise in a sentence.
    pub fn sentence(&self) -> String {
        let Accuracy { verdict, asked, expected, sensitivity, .. } = &self.record;
        let each = asked.iter().map(|(quantity, asked)| {
            let of = |values: &BTreeMap<String, f64>| values.get(quantity).copied();
            let moved = of(sensitivity)
                .map_or_else(String::new, |s| format!(", 1 % of shaking changes it by {:.1} %", 100.0 * s));
            format!(
                "{quantity} {:.2} % of {:.1} % asked{moved}",
                100.0 * of(expected).unwrap_or(f64::NAN),
                100.0 * asked
            )
        });
        format!(
            "accuracy: {verdict}; expected error against the reference: {}",
            each.collect::<Vec<_>>().join("; ")
        )
    }
}

/// Why there is no ladder for a scene.
fn unfit(scene: &Scene) -> Option<&'static str> {
    let Some(dam) = &scene.dam else {
        return Some("the dam is prescribed and has no error of its own; leave --accuracy out");
    };
    let foreign = dam.fidelity.is_foreign() || scene.has_foreign_water();
    match dam {
        _ if foreign => Some("a unit is another program's, whose numerics are its own; leave --accuracy out"),
        _ if dam.mesh.is_some() => Some(
            "the mesh is that of a file and cannot be refined; take the section and `dam.element_size`, or leave --accuracy out",
        ),
        _ if dam.fidelity.is_rigid() => {
            Some("blocks that do not deform are another model; choose \"dem\" or \"reduced\"")
        }
        _ if scene.ground_motion.record.is_none() => {
            Some("the ground moves by a ramp; give a record, or leave --accuracy out")
        }
        _ if scene.time.adaptive.is_some() => {
            Some("communication steps are adaptive; leave out [time.adaptive] or --accuracy")
        }
        _ => None,
    }
}

/// Pilot runs so far.
struct Pilot<'a> {
    scene: &'a Path,
    /// Settings of the user and of the communication step.
    base: Vec<String>,
    ladder: Ladder,
    loaded: &'a LoadedScene,
    fidelity: DamFidelityScene,
    runs: usize,
}

impl Pilot<'_> {
    fn settings(&self, rung: usize) -> Vec<String> {
        self.ladder.settings(&self.loaded.scene, rung, self.fidelity)
    }

    /// The settings of a rung with a factor on the shaking.
    fn shaken(&self, rung: usize, factor: f64) -> Vec<String> {
        let scale = self.loaded.scene.ground_motion.record.as_ref().map_or(1.0, |record| record.scale);
        let mut settings = self.base.clone();
        settings.extend(self.settings(rung));
        settings.push(format!("ground_motion.record.scale={}", factor * scale));
        settings
    }

    /// The settings of a rung with blocks of other modes; none where blocks have no modes.
    fn with_other_modes(&self, rung: usize) -> Option<Vec<String>> {
        let own = self.loaded.scene.dam.as_ref().and_then(|dam| dam.modes);
        let other = OTHER_MODES.into_iter().find(|modes| own != Some(*modes))?;
        let setting = format!("dam.modes={other}");
        let settings = || self.shaken(rung, 1.0).into_iter().chain([setting]).collect();
        (self.fidelity == DamFidelityScene::Reduced).then(settings)
    }

    /// Runs the scene once with each of these settings.
    fn run(&mut self, runs: &[Vec<String>]) -> Result<Vec<Outcome>, AccuracyError> {
        self.runs += runs.len();
        pilot::run(self.scene, runs)
    }
}

/// The communication step that the record needs, s: the scene's, or a shorter one where that is too long.
fn communication_step(loaded: &LoadedScene) -> f64 {
    let better = loaded.warnings.iter().filter_map(|warning| match &warning.warning {
        Warning::CoarseStep { better, .. } | Warning::ClippedSamples { better, .. } => Some(*better),
        _ => None,
    });
    better.fold(loaded.scene.time.communication_step, f64::min)
}

/// Runs the pilot of a scene that was read from `path` with `settings`, and chooses.
///
/// **Errors**: a scene without a ladder; units that cannot be made; a run of the pilot that fails.
pub fn promise(
    path: &Path,
    settings: &[String],
    loaded: &LoadedScene,
    asked: &Asked,
) -> Result<Promise, AccuracyError> {
    if let Some(why) = unfit(&loaded.scene) {
        return Err(AccuracyError::Unfit { why: why.to_owned() });
    }
    let began = Instant::now();
    let Some(dam) = &loaded.scene.dam else {
        return Err(AccuracyError::Unfit { why: "there is no dam".to_owned() });
    };
    let cracked = !dam.cracks.is_empty() && !dam.fidelity.is_intact();
    let fidelity = match cracked {
        false => DamFidelityScene::Intact,
        // Reduced blocks have no local damping.
        true if dam.damping.model == DampingModel::Local => DamFidelityScene::Dem,
        true => DamFidelityScene::Reduced,
    };
    let step = communication_step(loaded);
    let mut base = settings.to_vec();
    base.push(format!("time.communication_step={step}"));
    let mut pilot = Pilot { scene: path, base, ladder: Ladder::of(&loaded.scene), loaded, fidelity, runs: 0 };
    let outcomes = pilot.run(&[pilot.shaken(1, 1.0), pilot.shaken(0, 1.0)])?;
    let moves = cracked && outcomes.iter().any(|outcome| outcome.moved > LEAST_SLIDING);
    let mut wanted = asked.0.clone();
    let unnamed = wanted.remove(UNNAMED).is_some();
    if !cracked {
        wanted.remove(SLIDING);
    }
    if moves && unnamed {
        wanted.remove(HISTORY);
    }
    let strictest = wanted.values().copied().fold(1.0, f64::min);
    let highest = TAU * loaded.ground_motion.frequency_below_which(ENERGY);
    let of_step = |halvings: i32| (highest * step * 0.5_f64.powi(halvings)).powi(2) / 12.0;
    let enough = |halvings: &i32| of_step(*halvings) <= OF_STEP * strictest;
    let halvings = (0..MOST_HALVINGS).find(enough).unwrap_or(MOST_HALVINGS);
    let of_step = of_step(halvings);
    let decided = if moves {
        moving(&mut pilot, &wanted, of_step)?
    } else {
        still(&pilot, &wanted, &outcomes, of_step)
    };
    let Decision { rung, fidelity, expected, sensitivity, left_by_reference, band } = decided;
    let worst = wanted.iter().map(|(quantity, asked)| {
        let (error, change) = (expected.get(quantity), sensitivity.get(quantity));
        match (error, change) {
            (_, Some(change)) if moves && change > asked => CANNOT,
            (Some(error), _) if error <= asked => KEPT,
            _ => NOT_KEPT,
        }
    });
    let rank = |verdict: &&str| [KEPT, NOT_KEPT, CANNOT].iter().position(|own| own == verdict);
    let verdict = worst.max_by_key(rank).unwrap_or(KEPT);
    let mut chosen = pilot.ladder.settings(&loaded.scene, rung, fidelity);
    let own = step * 0.5_f64.powi(halvings);
    chosen.push(format!("time.communication_step={own}"));
    let record = Accuracy {
        verdict: verdict.to_owned(),
        asked: wanted,
        expected,
        sensitivity,
        left_by_reference,
        chosen,
        pilot_runs: pilot.runs,
        pilot_time: began.elapsed().as_secs_f64(),
        band,
        table_version: table::TABLE.version,
    };
    Ok(Promise { record, plan: Vec::new() })
}

/// What a pilot comes to.
struct Decision {
    rung: usize,
    fidelity: DamFidelityScene,
    expected: BTreeMap<String, f64>,
    sensitivity: BTreeMap<String, f64>,
    left_by_reference: BTreeMap<String, f64>,
    band: BTreeMap<String, [f64; 3]>,
}

/// An error of a quantity between two runs.
pub fn apart(quantity: &str, run: &Outcome, exact: &Outcome) -> f64 {
    match quantity {
        CREST => run.crest_error(exact),
        SLIDING => run.sliding_error(exact),
        _ => run.history_error(exact),
    }
}

/// Error of the finest level by the table.
fn of_table(cracked: bool, fidelity: DamFidelityScene, quantity: &str) -> f64 {
    let row = table::largest(cracked, fidelity, Ladder::RUNGS - 1, quantity);
    row.map_or(UNMEASURED, table::LevelError::largest)
}

/// Where nothing slides or opens: the error of the elements falls as h², extrapolated from the two coarsest; the first rung that is
/// good enough.
fn still(pilot: &Pilot<'_>, wanted: &BTreeMap<String, f64>, outcomes: &[Outcome], of_step: f64) -> Decision {
    let [fine, coarse] = [&outcomes[0], &outcomes[1]];
    let squares = pilot.ladder.sizes.map(|size| size * size);
    let last = Ladder::RUNGS - 1;
    let per_square = |quantity: &str| {
        // A peak errs by no more than its history; the difference of two peaks may vanish by chance.
        let quantity = if quantity == CREST { HISTORY } else { quantity };
        apart(quantity, coarse, fine) / (squares[0] - squares[1])
    };
    let error = |quantity: &str, rung: usize| {
        SAFETY * per_square(quantity) * (squares[rung] - squares[last])
            + of_step
            // Linear blocks err as modes do; what the table has of blocks is of those that slide.
            + of_table(false, DamFidelityScene::Intact, if quantity == SLIDING { HISTORY } else { quantity })
    };
    let good = |rung: &usize| wanted.iter().all(|(quantity, asked)| error(quantity, *rung) <= *asked);
    let rung = (0..Ladder::RUNGS).find(good).unwrap_or(last);
    let of_all =
        |of: &dyn Fn(&str) -> f64| wanted.keys().map(|quantity| (quantity.clone(), of(quantity))).collect();
    Decision {
        rung,
        fidelity: pilot.fidelity,
        expected: of_all(&|quantity| error(quantity, rung)),
        sensitivity: BTreeMap::new(),
        left_by_reference: of_all(&|quantity| per_square(quantity) * squares[last]),
        band: BTreeMap::new(),
    }
}

/// Where a block slides or opens its crack: the elements' error has no order, so that the finest rung is taken; what 1 % of shaking
/// changes there decides whether the answer is defined. Blocks of other modes say what the modes leave out.
fn moving(
    pilot: &mut Pilot<'_>,
    wanted: &BTreeMap<String, f64>,
    of_step: f64,
) -> Result<Decision, AccuracyError> {
    let last = Ladder::RUNGS - 1;
    let other_modes = pilot.with_other_modes(last);
    let has_modes = other_modes.is_some();
    let twins = [1.0, 1.0 - MORE_OR_LESS, 1.0 + MORE_OR_LESS].map(|factor| pilot.shaken(last, factor));
    let mut runs = pilot.run(&other_modes.into_iter().chain(twins).collect::<Vec<_>>())?;
    let other_modes = has_modes.then(|| runs.remove(0));
    let of_all =
        |of: &dyn Fn(&str) -> f64| wanted.keys().map(|quantity| (quantity.clone(), of(quantity))).collect();
    let change =
        |quantity: &str| runs[1..].iter().map(|twin| apart(quantity, twin, &runs[0])).fold(0.0, f64::max);
    let sensitivity: BTreeMap<String, f64> = of_all(&change);
    let exact = &runs[0];
    let expected = |fidelity| {
        of_all(&|quantity| {
            let like_shaking = LIKE_SHAKING * sensitivity.get(quantity).copied().unwrap_or(0.0);
            let modes = other_modes.as_ref().filter(|_| fidelity == DamFidelityScene::Reduced);
            let of_modes = modes.map_or(0.0, |other| SAFETY * apart(quantity, other, exact));
            of_table(true, fidelity, quantity) + of_step + like_shaking.max(of_modes)
        })
    };
    let mut band = BTreeMap::new();
    let undefined: Vec<&String> =
        wanted.iter().filter(|(quantity, asked)| sensitivity[*quantity] > **asked).map(|(q, _)| q).collect();
    // All elements have no modes to choose.
    let has_choice = pilot.loaded.scene.dam.as_ref().is_none_or(|dam| dam.modes.is_none());
    let (fidelity, expected) = match undefined.is_empty() && has_choice {
        true => cheapest(pilot.fidelity, wanted, expected),
        false => (pilot.fidelity, expected(pilot.fidelity)),
    };
    if !undefined.is_empty() {
        let nearer = [1.0 - MORE_OR_LESS / 2.0, 1.0 + MORE_OR_LESS / 2.0];
        runs.extend(pilot.run(&nearer.map(|factor| pilot.shaken(last, factor)))?);
        for quantity in undefined {
            let value = |run: &Outcome| 1e3 * if quantity == SLIDING { run.slid() } else { run.peak() };
            let mut values: Vec<f64> = runs.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            band.insert(quantity.clone(), [0.16, 0.5, 0.84].map(|share| quantile(&values, share)));
        }
    }
    Ok(Decision { rung: last, fidelity, expected, sensitivity, left_by_reference: BTreeMap::new(), band })
}

/// Every element and contact in the place of `cheap` blocks, where these alone would miss what is wanted.
fn cheapest(
    cheap: DamFidelityScene,
    wanted: &BTreeMap<String, f64>,
    expected: impl Fn(DamFidelityScene) -> BTreeMap<String, f64>,
) -> (DamFidelityScene, BTreeMap<String, f64>) {
    let [cheap, full] = [cheap, DamFidelityScene::Dem].map(|fidelity| (fidelity, expected(fidelity)));
    let keeps =
        |errors: &BTreeMap<String, f64>| wanted.iter().all(|(quantity, asked)| errors[quantity] <= *asked);
    if !keeps(&cheap.1) && keeps(&full.1) { full } else { cheap }
}

/// Says what was chosen.
pub fn announce(promise: &Promise) {
    let Accuracy { chosen, pilot_runs, pilot_time, left_by_reference, .. } = &promise.record;
    say(format!("pilot: {pilot_runs} runs in {pilot_time:.1} s; chosen: {}", chosen.join(", ")));
    say(promise.sentence());
    for (quantity, error) in left_by_reference {
        say(format!("the reference's own elements leave about {:.2} % of the {quantity}", 100.0 * error));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_assembly::read_scene;
    use cofferdam_scene::OnFailure;

    #[test]
    fn elements_take_the_place_of_modes_only_where_they_keep_what_modes_miss() {
        use DamFidelityScene::{Dem, Reduced};
        let expected =
            |fidelity| BTreeMap::from([(SLIDING.to_owned(), if fidelity == Dem { 0.01 } else { 0.03 })]);
        for (asked, chosen, error) in [(0.05, Reduced, 0.03), (0.02, Dem, 0.01), (0.005, Reduced, 0.03)] {
            let (fidelity, errors) =
                cheapest(Reduced, &BTreeMap::from([(SLIDING.to_owned(), asked)]), expected);
            assert_eq!((fidelity, errors[SLIDING]), (chosen, error), "{asked} was asked");
        }
    }

    #[test]
    fn blocks_run_once_more_by_a_number_of_modes_that_they_do_not_have() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/koyna-coarse");
        let other = |fidelity, set: &[String]| {
            let loaded = read_scene(&path, set).expect("a scene");
            let ladder = Ladder::of(&loaded.scene);
            let pilot = Pilot { scene: &path, base: Vec::new(), ladder, loaded: &loaded, fidelity, runs: 0 };
            pilot.with_other_modes(0).map(|settings| settings.last().cloned().unwrap_or_default())
        };
        use DamFidelityScene::{Dem, Reduced};
        assert_eq!(other(Reduced, &[]).as_deref(), Some("dam.modes=48"));
        assert_eq!(
            other(Reduced, &["dam.fidelity=reduced", "dam.modes=48"].map(str::to_owned)).as_deref(),
            Some("dam.modes=40")
        );
        assert_eq!(other(Dem, &[]), None);
    }

    #[test]
    fn the_reference_is_the_strictest_run_and_goes_on_with_steps_above_its_tolerance() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/koyna-coarse");
        let scene = read_scene(&path, &[]).expect("a scene").scene;
        let settings = Ladder::of(&scene).reference(&scene);
        let reference = read_scene(&path, &settings).expect("a scene").scene;
        assert_eq!(reference.coupling.tolerance, Tolerance::Relative(1e-8));
        assert_eq!(reference.coupling.on_failure, OnFailure::Continue);
        assert_eq!(2.0 * reference.time.communication_step, scene.time.communication_step);
        let dam = reference.dam.expect("a dam");
        assert_eq!((dam.fidelity, dam.element_size), (DamFidelityScene::Dem, 1.25));
    }

    #[test]
    fn an_accuracy_is_a_share_or_one_for_each_quantity() {
        let all = asked("5%").expect("a share").0;
        assert_eq!((all[CREST], all[SLIDING]), (0.05, 0.05));
        let named = asked("crest=2%, sliding=0.2").expect("shares").0;
        assert_eq!(
            named.into_iter().collect::<Vec<_>>(),
            [(CREST.to_owned(), 0.02), (SLIDING.to_owned(), 0.2)]
        );
        // What is named is what was named, and the rest is that of all others.
        for text in ["crest=2%, 5%", "5%, crest=2%"] {
            let mixed = asked(text).expect("shares").0;
            assert_eq!([CREST, HISTORY, SLIDING, UNNAMED].map(|name| mixed[name]), [0.02, 0.05, 0.05, 0.05]);
        }
        let with_history = asked("5%, history=10%").expect("shares").0;
        assert!(with_history[HISTORY] == 0.1 && !with_history.contains_key(UNNAMED), "{with_history:?}");
        assert!(asked("5").is_err_and(|why| why.contains("write 5%")));
        assert!(asked("drift=5%").is_err_and(|why| why.contains("no quantity `drift`")));
    }
}
