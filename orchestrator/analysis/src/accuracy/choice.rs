//! Which level a pilot comes to.

use super::ladder::Ladder;
use super::pilot::{self, Outcome};
use super::{AccuracyError, CREST, HISTORY, MORE_OR_LESS, SLIDING, table};
use crate::context::Context;
use crate::statistics::quantile;
use cofferdam_scene::{DamFidelityScene, LoadedScene};
use std::collections::BTreeMap;
use std::path::Path;

/// Factor on errors that are extrapolated from two lengths of elements, or found by other modes.
const SAFETY: f64 = 1.5;
/// Share of the change with 1 % of shaking that the numerics of the finest level may bring about: they act like a thousandth of the
/// shaking.
const LIKE_SHAKING: f64 = 0.1;
/// Modes of a block with which reduced blocks run once more, or the second number if the scene has the first: a dam takes neither by itself.
const OTHER_MODES: [usize; 2] = [48, 40];
/// Error of a level that the table does not have.
const UNMEASURED: f64 = 0.02;

/// Pilot runs so far.
pub(super) struct Pilot<'a> {
    pub scene: &'a Path,
    /// Settings of the user and of the communication step.
    pub base: Vec<String>,
    pub ladder: Ladder,
    pub loaded: &'a LoadedScene,
    pub fidelity: DamFidelityScene,
    pub runs: usize,
    pub context: &'a Context<'a>,
}

impl Pilot<'_> {
    fn settings(&self, rung: usize) -> Vec<String> {
        self.ladder.settings(&self.loaded.scene, rung, self.fidelity)
    }

    /// The settings of a rung with a factor on the shaking.
    pub fn shaken(&self, rung: usize, factor: f64) -> Vec<String> {
        let mut settings = self.base.clone();
        settings.extend(self.settings(rung));
        settings.extend(self.loaded.scene.ground_motion.scaled(factor));
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
    pub fn run(&mut self, runs: &[Vec<String>]) -> Result<Vec<Outcome>, AccuracyError> {
        self.runs += runs.len();
        pilot::run(self.scene, runs, self.context)
    }
}

/// Result of a pilot.
pub(super) struct Decision {
    pub rung: usize,
    pub fidelity: DamFidelityScene,
    pub expected: BTreeMap<String, f64>,
    pub sensitivity: BTreeMap<String, f64>,
    pub left_by_reference: BTreeMap<String, f64>,
    pub band: BTreeMap<String, [f64; 3]>,
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
pub(super) fn still(
    pilot: &Pilot<'_>,
    wanted: &BTreeMap<String, f64>,
    outcomes: &[Outcome],
    of_step: f64,
) -> Decision {
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
/// changes there decides whether the result is defined. Blocks with other numbers of modes show the truncation error of the modes.
pub(super) fn moving(
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

/// Every element and contact instead of `cheap` blocks, if only the blocks would miss the request.
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

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_assembly::read_scene;

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
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/koyna-coarse");
        let other = |fidelity, set: &[String]| {
            let loaded = read_scene(&path, set).expect("a scene");
            let ladder = Ladder::of(&loaded.scene);
            let pilot = Pilot {
                scene: &path,
                base: Vec::new(),
                ladder,
                loaded: &loaded,
                fidelity,
                runs: 0,
                context: &Context::default(),
            };
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
}
