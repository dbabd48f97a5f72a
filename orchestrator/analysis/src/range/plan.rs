//! The runs of a range: the scene as it is, one factor at a time, and all together.

use super::setting::{Choice, Factor, Values};
use crate::statistics::{choice, uncorrelated_latin_hypercube};

/// Part of a range that a run belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The scene as it is.
    AsItIs,
    /// Another setting of the factor of this number alone.
    Alone(usize),
    /// The joint sample.
    Joint,
}

/// The setting of a factor in a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Coordinate {
    /// A number.
    Number(f64),
    /// The number of a choice.
    Choice(usize),
    /// The seed of noise on the motion; none without noise.
    Noise(Option<u64>),
}

/// A run of a range.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// What belongs to it in sentences.
    pub name: String,
    /// Part of the range.
    pub part: Part,
    /// The changes of the scene.
    pub sets: Vec<String>,
    /// The setting of each factor.
    pub coordinates: Vec<Coordinate>,
    /// Cost relative to that of the scene as it is, roughly: long runs come first.
    pub cost: f64,
}

impl Planned {
    /// Seed of the noise on its motion.
    pub fn noise(&self) -> Option<u64> {
        self.coordinates.iter().find_map(|coordinate| match coordinate {
            Coordinate::Noise(seed) => *seed,
            _ => None,
        })
    }
}

/// Number by which seeds of the joint sample differ from those of the replicates.
const OF_JOINT: u64 = 500_000;

impl Factor {
    /// Its setting in the scene as it is.
    fn base(&self) -> Coordinate {
        match &self.values {
            Values::Between(between) => Coordinate::Number(between.base),
            Values::Choices { base, .. } => Coordinate::Choice(*base),
            Values::Noise(_) => Coordinate::Noise(None),
        }
    }

    /// Its settings one at a time, but for the scene's.
    fn alone(&self, seed: u64) -> Vec<Coordinate> {
        match &self.values {
            Values::Between(between) => {
                let ends = [between.low, between.high].into_iter().filter(|end| *end != between.base);
                ends.map(Coordinate::Number).collect()
            }
            Values::Choices { choices, base } => {
                (0..choices.len()).filter(|index| index != base).map(Coordinate::Choice).collect()
            }
            Values::Noise(replicates) => {
                (0..*replicates as u64).map(|number| Coordinate::Noise(Some(noise(seed, number)))).collect()
            }
        }
    }

    /// Its setting in the run with this number of the joint sample, at this `share` of its range.
    fn at(&self, share: f64, seed: u64, number: usize) -> Coordinate {
        match &self.values {
            Values::Between(between) => Coordinate::Number(between.at(share)),
            Values::Choices { choices, .. } => Coordinate::Choice(choice(share, choices.len())),
            Values::Noise(_) => Coordinate::Noise(Some(noise(seed, OF_JOINT + number as u64))),
        }
    }

    /// The number of its choices; none for numbers and noise.
    fn choices(&self) -> Option<usize> {
        match &self.values {
            Values::Choices { choices, .. } => Some(choices.len()),
            Values::Between(_) | Values::Noise(_) => None,
        }
    }

    /// The changes of the scene for a setting.
    fn sets(&self, coordinate: &Coordinate) -> Vec<String> {
        match (&self.values, coordinate) {
            (Values::Between(between), Coordinate::Number(value)) if *value != between.base => {
                (between.sets)(*value)
            }
            (Values::Choices { choices, .. }, Coordinate::Choice(index)) => {
                choices.get(*index).map_or_else(Vec::new, |Choice { sets, .. }| sets.clone())
            }
            _ => Vec::new(),
        }
    }

    /// A setting as text.
    pub fn shown(&self, coordinate: &Coordinate) -> String {
        match (&self.values, coordinate) {
            (Values::Between(between), Coordinate::Number(value)) => between.shown(*value),
            (Values::Choices { choices, .. }, Coordinate::Choice(index)) => {
                choices.get(*index).map_or_else(String::new, |choice| choice.name.clone())
            }
            (_, Coordinate::Noise(Some(seed))) => format!("noise of seed {seed}"),
            _ => "as in the scene".to_owned(),
        }
    }
}

/// A seed of noise.
fn noise(seed: u64, number: u64) -> u64 {
    1_000_000 * seed + number
}

/// The scene as it is, and one factor at a time.
pub fn one_at_a_time(factors: &[Factor], seed: u64) -> Vec<Planned> {
    let base: Vec<Coordinate> = factors.iter().map(Factor::base).collect();
    let name = "the scene as it is".to_owned();
    let mut runs =
        vec![Planned { name, part: Part::AsItIs, sets: Vec::new(), coordinates: base.clone(), cost: 1.0 }];
    for (index, factor) in factors.iter().enumerate() {
        for coordinate in factor.alone(seed) {
            let mut coordinates = base.clone();
            let name = format!("{}: {}", factor.about.name, factor.shown(&coordinate));
            let sets = factor.sets(&coordinate);
            coordinates[index] = coordinate;
            let cost = cost(&sets);
            runs.push(Planned { name, part: Part::Alone(index), sets, coordinates, cost });
        }
    }
    runs
}

/// A Latin hypercube over the factors that vary jointly.
pub fn joint(factors: &[Factor], samples: usize, seed: u64) -> Vec<Planned> {
    let dimensions = factors.iter().filter(|factor| factor.about.joint).map(Factor::choices);
    let points = uncorrelated_latin_hypercube(samples, &dimensions.collect::<Vec<_>>(), seed);
    let run = |(number, point): (usize, &Vec<f64>)| {
        let mut shares = point.iter();
        let coordinates: Vec<Coordinate> = factors
            .iter()
            .map(|factor| {
                let share = if factor.about.joint { shares.next() } else { None };
                share.map_or_else(|| factor.base(), |share| factor.at(*share, seed, number))
            })
            .collect();
        // A record is a table, whose keys may be set afterwards.
        let all = factors.iter().zip(&coordinates).flat_map(|(factor, coordinate)| factor.sets(coordinate));
        let mut sets: Vec<String> = all.collect();
        sets.sort_by_key(|set| !is_table(set));
        let cost = cost(&sets);
        Planned { name: format!("joint sample {}", number + 1), part: Part::Joint, sets, coordinates, cost }
    };
    points.iter().enumerate().map(run).collect()
}

/// Whether a change replaces a table.
fn is_table(set: &str) -> bool {
    set.split_once('=').is_some_and(|(_, value)| value.starts_with('{'))
}

/// Cost of a run with these changes, relative to that of one without, roughly.
fn cost(sets: &[String]) -> f64 {
    let of = |set: &String| match set.split_once('=') {
        Some(("dam.fidelity", "\"dem\"")) => 15.0,
        Some(("dam.element_size" | "dam.time_step_safety" | "time.communication_step", _)) => 2.0,
        _ => 1.0,
    };
    sets.iter().map(of).product()
}

#[cfg(test)]
mod tests {
    use super::super::setting::{Between, Values};
    use super::*;
    use cofferdam_report::{FactorKind, RangeFactor};

    fn factor(name: &str, joint: bool, values: Values) -> Factor {
        let [range, reason] = [String::new(), String::new()];
        let about = RangeFactor { name: name.to_owned(), kind: FactorKind::Model, range, reason, joint };
        Factor { about, values }
    }

    fn factors() -> Vec<Factor> {
        let sets = Box::new(|value| vec![format!("a={value}")]);
        let between =
            Between { low: 0.5, high: 2.0, base: 1.0, logarithmic: true, sets, before: "", after: "" };
        let choice = |name: &str, sets: &[&str]| Choice {
            name: name.to_owned(),
            sets: sets.iter().map(|set| (*set).to_owned()).collect(),
        };
        let choices = vec![choice("x", &["b=x"]), choice("y", &[]), choice("z", &["b={z=1}"])];
        vec![
            factor("number", true, Values::Between(between)),
            factor("choice", true, Values::Choices { choices, base: 1 }),
            factor(
                "step",
                false,
                Values::Choices { choices: vec![choice("as it is", &[]), choice("half", &["c=1"])], base: 0 },
            ),
            factor("noise", true, Values::Noise(2)),
        ]
    }

    #[test]
    fn one_factor_changes_at_a_time() {
        let runs = one_at_a_time(&factors(), 1);
        let sets: Vec<Vec<&str>> =
            runs.iter().map(|run| run.sets.iter().map(String::as_str).collect()).collect();
        let none: Vec<&str> = Vec::new();
        assert_eq!(
            sets,
            [
                none.clone(),
                vec!["a=0.5"],
                vec!["a=2"],
                vec!["b=x"],
                vec!["b={z=1}"],
                vec!["c=1"],
                none.clone(),
                none
            ]
        );
        let noise: Vec<bool> = runs.iter().map(|run| run.noise().is_some()).collect();
        assert_eq!(noise, [false, false, false, false, false, false, true, true]);
        assert_eq!(runs[3].name, "choice: x");
        assert_eq!(runs[3].part, Part::Alone(1));
    }

    #[test]
    fn every_joint_factor_has_each_part_of_its_range_equally_often_and_the_others_are_the_scenes() {
        let runs = joint(&factors(), 12, 3);
        assert_eq!(runs, joint(&factors(), 12, 3));
        assert_ne!(runs, joint(&factors(), 12, 4));
        let of = |index: usize| runs.iter().map(move |run| run.coordinates[index].clone());
        for choice in 0..3 {
            assert_eq!(of(1).filter(|coordinate| *coordinate == Coordinate::Choice(choice)).count(), 4);
        }
        let below =
            of(0).filter(|coordinate| matches!(coordinate, Coordinate::Number(value) if *value < 1.0));
        assert_eq!(below.count(), 6);
        assert!(of(2).all(|coordinate| coordinate == Coordinate::Choice(0)));
        let mut seeds: Vec<u64> = runs.iter().filter_map(Planned::noise).collect();
        seeds.dedup();
        assert_eq!(seeds.len(), 12);
        // Tables come first, so that they do not replace a key that was set before.
        let table = runs.iter().find(|run| run.coordinates[1] == Coordinate::Choice(2)).expect("a run");
        assert_eq!(table.sets[0], "b={z=1}");
    }
}
