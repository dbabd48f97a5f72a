//! Names that a user gives for variables of the contract: one, one for each value, or a pattern for scalars.

use super::error::FmuUnitError;
use super::model::{Causality, Kind, Model, ModelVariable};
use cofferdam_coupling::participant::VariableNames;
use std::collections::{BTreeMap, BTreeSet};

/// Begins and ends the placeholder of a pattern, `{i}` or `{i=0}`.
const PLACEHOLDER: (&str, char) = ("{i", '}');
/// Similarity from which a name is suggested, of 0 to 1.
const ALIKE: f64 = 0.6;
/// Most scalars that are tried as the first of a pattern for a list of names.
const MOST_ATTEMPTS: usize = 64;
/// Most names that are suggested.
const SUGGESTED: usize = 3;

/// Scalars that stand for the values of one variable, in order.
struct Group {
    /// The name of the array that they make.
    name: String,
    /// Their places among the variables.
    places: Vec<usize>,
}

/// A name with the place of a number.
struct Pattern<'a> {
    before: &'a str,
    after: &'a str,
    /// Number of the first; else 0 or 1, whichever is there.
    first: Option<u64>,
}

/// Makes arrays of the scalars that `given` names, in the place of the first of each, and joins the other scalars `p[1]`, `p[2]`, …
///
/// Returns the name that each variable of the contract has then.
///
/// **Errors**: a name that is not there; numbers that are missing or there twice; a pattern without a place for the number;
/// variables of different kinds; one for two variables of the contract.
pub fn join(
    model: &mut Model,
    given: &BTreeMap<String, VariableNames>,
) -> Result<BTreeMap<String, String>, FmuUnitError> {
    let (mut names, mut groups) = (BTreeMap::new(), Vec::<Group>::new());
    for (variable, given) in given {
        let group = match given {
            VariableNames::Several(list) => Some(listed(model, variable, list)?),
            VariableNames::One(name) if !is_known(model, name) && name.contains(['{', '}']) => {
                Some(numbered(model, variable, name)?)
            }
            VariableNames::One(_) => None,
        };
        let name = match (group, given) {
            (Some(group), _) => {
                let twice = group.places.iter().find(|place| groups.iter().any(|g| g.places.contains(place)));
                if let Some(place) = twice {
                    let name = &model.variables[*place].name;
                    let why = format!("`{name}` is given for another variable too; name each once");
                    return Err(refused(variable, given, why));
                }
                let name = group.name.clone();
                groups.push(group);
                name
            }
            (None, VariableNames::One(name)) => name.clone(),
            (None, VariableNames::Several(_)) => continue,
        };
        if names.values().any(|other| *other == name) {
            let why = format!("`{name}` is given for another variable too; name each once");
            return Err(refused(variable, given, why));
        }
        names.insert(variable.clone(), name);
    }
    let first = |group: &Group| group.places.iter().copied().min().unwrap_or(0);
    let of = |place: usize| groups.iter().find(|group| group.places.contains(&place));
    let mut joined = Vec::with_capacity(model.variables.len());
    for (place, variable) in model.variables.iter().enumerate() {
        match of(place) {
            None => joined.push(variable.clone()),
            Some(group) if first(group) == place => joined.push(ModelVariable {
                name: group.name.clone(),
                references: group.places.iter().map(|place| model.variables[*place].references[0]).collect(),
                size: group.places.len(),
                array: true,
                ..model.variables[group.places[0]].clone()
            }),
            Some(_) => (),
        }
    }
    model.variables = joined;
    model.join_arrays();
    Ok(names)
}

fn is_known(model: &Model, name: &str) -> bool {
    model.variables.iter().any(|variable| variable.name == name)
}

fn refused(variable: &str, given: &VariableNames, why: String) -> FmuUnitError {
    let given = match given {
        VariableNames::One(name) => format!("{name:?}"),
        VariableNames::Several(list) => format!("{} names", list.len()),
    };
    FmuUnitError::Names { variable: variable.to_owned(), given, why }
}

/// The scalars of a list of names.
fn listed(model: &Model, variable: &str, list: &[String]) -> Result<Group, FmuUnitError> {
    let refused = |why: String| refused(variable, &VariableNames::Several(list.to_vec()), why);
    let mut places = Vec::with_capacity(list.len());
    for name in list {
        let found = model.variables.iter().position(|variable| variable.name == *name);
        let Some(place) = found else { return Err(missing(model, variable, name)) };
        if places.contains(&place) {
            return Err(refused(format!("`{name}` is there twice; name each once")));
        }
        if model.variables[place].size != 1 {
            return Err(refused(format!(
                "`{name}` is an array; give its name alone, {variable} = {name:?}, or those of scalars"
            )));
        }
        places.push(place);
    }
    let name = list.join(", ");
    if places.is_empty() {
        return Err(refused("there must be one for each value".to_owned()));
    }
    alike(model, &places).map_err(refused)?;
    Ok(Group { name, places })
}

/// The scalars whose names follow a pattern.
fn numbered(model: &Model, variable: &str, text: &str) -> Result<Group, FmuUnitError> {
    let refused = |why: String| refused(variable, &VariableNames::One(text.to_owned()), why);
    let pattern = Pattern::read(text).map_err(refused)?;
    let places = pattern.places(model).map_err(refused)?;
    if places.is_empty() {
        return Err(missing(model, variable, text));
    }
    alike(model, &places).map_err(refused)?;
    Ok(Group { name: text.to_owned(), places })
}

/// Whether all can be values of one array.
fn alike(model: &Model, places: &[usize]) -> Result<(), String> {
    let first = &model.variables[places[0]];
    for variable in places.iter().map(|place| &model.variables[*place]) {
        if variable.kind != Kind::Float64 {
            return Err(format!("`{}` is a {:?}, not a real number", variable.name, variable.kind));
        }
        if variable.causality != first.causality {
            return Err(format!(
                "`{}` is of causality {:?} and `{}` {:?}; all must be the same",
                first.name, first.causality, variable.name, variable.causality
            ));
        }
    }
    Ok(())
}

impl<'a> Pattern<'a> {
    /// **Errors**: there is not one place for the number.
    fn read(text: &'a str) -> Result<Self, String> {
        let remedy = "write {i} where the number stands, \"p_{i}\", or {i=0} to say with which it begins";
        let Some((before, rest)) = text.split_once(PLACEHOLDER.0) else {
            return Err(format!("a pattern needs a placeholder: {remedy}"));
        };
        let (number, after) =
            rest.split_once(PLACEHOLDER.1).ok_or_else(|| format!("`{{i` is not closed: {remedy}"))?;
        let first = match number.strip_prefix('=') {
            None if number.is_empty() => None,
            Some(number) if number.parse::<u64>().is_ok() => number.parse().ok(),
            _ => return Err(format!("`{{i{number}}}` is no placeholder: {remedy}")),
        };
        if after.contains(PLACEHOLDER.0) {
            return Err(
                "it has two placeholders; give one, and the other number as it is, \"p[1,{i}]\"".to_owned()
            );
        }
        Ok(Self { before, after, first })
    }

    /// The number in a name that follows the pattern. Leading zeros do not count.
    fn number(&self, name: &str) -> Option<u64> {
        let digits = name.strip_prefix(self.before)?.strip_suffix(self.after)?;
        let number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        number.then(|| digits.parse().ok())?
    }

    /// The places of the scalars that follow it, by their numbers; none if there are none.
    ///
    /// **Errors**: a number is missing, or there twice.
    fn places(&self, model: &Model) -> Result<Vec<usize>, String> {
        let mut found: Vec<(u64, usize)> = Vec::new();
        for (place, variable) in model.variables.iter().enumerate().filter(|(_, variable)| variable.size == 1)
        {
            let number = self.number(&variable.name).filter(|number| *number >= self.first.unwrap_or(0));
            found.extend(number.map(|number| (number, place)));
        }
        found.sort_unstable();
        let Some((lowest, place)) = found.first() else { return Ok(Vec::new()) };
        let name = |place: usize| &model.variables[place].name;
        match self.first {
            None if *lowest > 1 => {
                return Err(format!(
                    "the first is `{}`; to begin there, write {{i={lowest}}} in place of {{i}}",
                    name(*place)
                ));
            }
            Some(first) if *lowest != first => {
                return Err(format!(
                    "there is none with the number {first}; the first is `{}`",
                    name(*place)
                ));
            }
            _ => (),
        }
        for pair in found.windows(2) {
            let ((one, place), (next, other)) = (pair[0], pair[1]);
            if next == one {
                return Err(format!("`{}` and `{}` have the same number", name(place), name(other)));
            }
            if next != one + 1 {
                return Err(format!(
                    "number {} is missing between `{}` and `{}`; correct the FMU, or list the names, [\"…\", \"…\"]",
                    one + 1,
                    name(place),
                    name(other)
                ));
            }
        }
        Ok(found.into_iter().map(|(_, place)| place).collect())
    }
}

/// The parts of a name around its last number.
fn around_number(name: &str) -> Option<(&str, &str)> {
    let end = name.rfind(|c: char| c.is_ascii_digit())? + 1;
    let before = name[..end].trim_end_matches(|c: char| c.is_ascii_digit());
    Some((before, &name[end..]))
}

/// The pattern of the names that differ from `name` in its last number alone, and how many there are, if there are several and
/// they can be used.
pub fn pattern_of(model: &Model, name: &str) -> Option<(String, usize)> {
    let (before, after) = around_number(name)?;
    let pattern = Pattern { before, after, first: None };
    let places = pattern.places(model).ok().filter(|places| places.len() > 1)?;
    alike(model, &places).ok()?;
    Some((format!("{before}{{i}}{after}"), places.len()))
}

/// The names of `variables` with the number of values of an array; a pattern in place of scalars that it names.
fn summarised<'a>(
    model: &Model,
    variables: impl Iterator<Item = &'a ModelVariable>,
) -> Vec<(String, Option<usize>)> {
    let (mut names, mut numbered, mut attempts) = (Vec::new(), BTreeSet::new(), 0);
    for variable in variables {
        let around = around_number(&variable.name).filter(|_| !variable.array);
        if around.is_some_and(|around| numbered.contains(&around)) {
            continue;
        }
        let pattern = around.filter(|_| attempts < MOST_ATTEMPTS).and_then(|around| {
            attempts += 1;
            let found = pattern_of(model, &variable.name)?;
            numbered.insert(around);
            Some(found)
        });
        names.push(match pattern {
            Some((pattern, size)) => (pattern, Some(size)),
            None => (variable.name.clone(), variable.array.then_some(variable.size)),
        });
    }
    names
}

/// Names of the real variables of these causalities, with their sizes; scalars that can be named by a pattern by it.
pub fn names(model: &Model, causalities: &[Causality]) -> String {
    first_few(summarised(model, model.real(causalities)))
}

/// Names of variables, with their sizes.
pub fn plain_names<'a>(variables: impl Iterator<Item = &'a ModelVariable>) -> String {
    first_few(variables.map(|v| (v.name.clone(), v.array.then_some(v.size))).collect())
}

fn first_few(all: Vec<(String, Option<usize>)>) -> String {
    const SHOWN: usize = 12;
    let number = all.len();
    let shown = all.into_iter().take(SHOWN).map(|(name, size)| match size {
        Some(size) => format!("`{name}`[{size}]"),
        None => format!("`{name}`"),
    });
    let shown = shown.collect::<Vec<_>>().join(", ");
    match number {
        0 => "none".to_owned(),
        1..=SHOWN => shown,
        _ => format!("{shown}, and {} more", number - SHOWN),
    }
}

/// A name or pattern that is not there.
pub fn missing(model: &Model, variable: &str, name: &str) -> FmuUnitError {
    let real = model.variables.iter().filter(|variable| variable.kind == Kind::Float64);
    let known: Vec<String> = match name.contains('{') {
        true => summarised(model, real).into_iter().map(|(name, _)| name).collect(),
        false => real.map(|variable| variable.name.clone()).collect(),
    };
    let likeness =
        |known: &str| strsim::normalized_damerau_levenshtein(&known.to_lowercase(), &name.to_lowercase());
    let mut nearest: Vec<(f64, String)> =
        known.into_iter().map(|known| (likeness(&known), known)).filter(|(like, _)| *like >= ALIKE).collect();
    nearest.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    FmuUnitError::NoSuchVariable {
        variable: variable.to_owned(),
        name: name.to_owned(),
        nearest: nearest.into_iter().take(SUGGESTED).map(|(_, name)| name).collect(),
        found: names(model, &[Causality::Input, Causality::Output]),
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Causality::{Input, Output};
    use super::*;

    fn scalar(name: &str, place: usize, causality: Causality) -> ModelVariable {
        ModelVariable {
            name: name.to_owned(),
            references: vec![100 + place as u32],
            kind: Kind::Float64,
            causality,
            unit: "Pa".to_owned(),
            size: 1,
            array: false,
        }
    }

    fn model(names: &[&str]) -> Model {
        let variables = names.iter().enumerate().map(|(place, name)| scalar(name, place, Output)).collect();
        Model::of_variables(variables)
    }

    fn given(variable: &str, names: VariableNames) -> BTreeMap<String, VariableNames> {
        BTreeMap::from([(variable.to_owned(), names)])
    }

    /// References of the array that `names` makes of a model with these scalars.
    fn joined(scalars: &[&str], names: impl Into<VariableNames>) -> Result<Vec<u32>, String> {
        let mut model = model(scalars);
        let names =
            join(&mut model, &given("interface_pressure", names.into())).map_err(|e| e.to_string())?;
        let array = model.variables.iter().find(|variable| variable.name == names["interface_pressure"]);
        let array = array.expect("the array");
        assert_eq!((array.size, array.array), (array.references.len(), true));
        let others = model
            .variables
            .iter()
            .filter(|other| other.references.iter().any(|r| array.references.contains(r)));
        assert_eq!(others.count(), 1, "each scalar is in the array alone");
        Ok(array.references.clone())
    }

    fn list(names: &[&str]) -> VariableNames {
        VariableNames::Several(names.iter().map(|name| (*name).to_owned()).collect())
    }

    #[test]
    fn patterns_take_scalars_by_their_numbers() {
        for (scalars, pattern) in [
            (["x", "p_10", "p_9"], "p_{i=9}"),
            (["x", "p_2", "p_1"], "p_{i}"),
            (["p", "p_1", "p_0"], "p_{i}"),
            (["p(3)", "p(2)", "p(1)"], "p({i=2})"),
            (["p[1,1]", "p[2,2]", "p[2,1]"], "p[2,{i}]"),
            (["p[1,1]", "p[2,1]", "p[1,1].x"], "p[{i},1]"),
            (["pressure_1x", "pressure_02", "pressure_01"], "pressure_{i}"),
            (["x1", "p[2]", "p[1]"], "p[{i}]"),
            (["", "ü2m", "ü1m"], "ü{i}m"),
        ] {
            let expected = match pattern {
                "p({i=2})" => vec![101, 100],
                "p[{i},1]" => vec![100, 101],
                _ => vec![102, 101],
            };
            assert_eq!(joined(&scalars, pattern), Ok(expected), "{pattern}");
        }
    }

    #[test]
    fn twelve_scalars_are_in_the_order_of_numbers_not_of_letters() {
        let names: Vec<String> = (1..=12).map(|i| format!("p_{i}")).collect();
        let mut scalars: Vec<&str> = names.iter().map(String::as_str).collect();
        scalars.sort_unstable();
        let expected: Vec<u32> = names
            .iter()
            .map(|name| 100 + scalars.iter().position(|s| s == name).expect("it is there") as u32)
            .collect();
        assert_eq!(joined(&scalars, "p_{i}"), Ok(expected));
    }

    #[test]
    fn lists_take_scalars_in_their_order() {
        assert_eq!(joined(&["top", "heel", "mid"], list(&["heel", "mid", "top"])), Ok(vec![101, 102, 100]));
        // Elements of what would be an array by itself.
        assert_eq!(joined(&["p[1]", "p[2]", "p[3]"], list(&["p[3]", "p[1]"])), Ok(vec![102, 100]));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_a_remedy() {
        let p = ["p_1", "p_2", "p_4", "q_3", "q_4", "r_1", "r_01"];
        let cases: [(VariableNames, &[&str]); 12] = [
            ("p_{i}".into(), &["\"p_{i}\"", "number 3 is missing between `p_2` and `p_4`", "list the names"]),
            ("q_{i}".into(), &["the first is `q_3`; to begin there, write {i=3}"]),
            ("q_{i=1}".into(), &["none with the number 1; the first is `q_3`"]),
            ("r_{i}".into(), &["`r_1` and `r_01` have the same number"]),
            ("p_{}".into(), &["a pattern needs a placeholder: write {i}"]),
            ("p_{n}".into(), &["a pattern needs a placeholder"]),
            ("p_{i+1}".into(), &["`{i+1}` is no placeholder", "{i=0}"]),
            ("p_{i".into(), &["`{i` is not closed"]),
            ("p[{i},{i}]".into(), &["two placeholders", "p[1,{i}]"]),
            ("P_{i}x".into(), &["no such variable of real numbers; it has"]),
            (list(&["p_1", "p_1"]), &["2 names", "`p_1` is there twice"]),
            (list(&[]), &["one for each value"]),
        ];
        for (names, words) in cases {
            let said = joined(&p, names.clone()).expect_err("it is refused");
            assert!(said.contains("`interface_pressure`"), "{said}");
            assert!(words.iter().all(|word| said.contains(word)), "{names:?}: {said}");
        }
        let said = joined(&["pressure_1", "pressure_2", "x"], list(&["presure_1"])).expect_err("misspelt");
        assert!(
            said.contains("\"presure_1\"") && said.contains("the nearest: `pressure_1`, `pressure_2`"),
            "{said}"
        );
        let said = joined(&["pressure_1", "pressure_2", "x"], "presure_{i}").expect_err("misspelt");
        assert!(said.contains("the nearest: `pressure_{i}`; it has `pressure_{i}`[2], `x`"), "{said}");
    }

    #[test]
    fn scalars_of_two_kinds_make_no_array() {
        let mut mixed = model(&["p_1", "p_2", "n_1", "n_2"]);
        mixed.variables[1].causality = Input;
        mixed.variables[3].kind = Kind::Int32;
        for (pattern, words) in [
            ("p_{i}", "`p_1` is of causality Output and `p_2` Input"),
            ("n_{i}", "`n_2` is a Int32, not a real number"),
        ] {
            let said = join(&mut mixed, &given("interface_pressure", pattern.into()));
            let said = said.expect_err("it is refused").to_string();
            assert!(said.contains(words), "{said}");
        }
        // One array for two variables, by one name and by its elements.
        for other in ["p_{i}".into(), list(&["p_1"])] {
            let mut both = given("interface_pressure", "p_{i}".into());
            both.insert("hydrostatic_pressure".to_owned(), other);
            let said = join(&mut model(&["p_1", "p_2"]), &both).expect_err("it is refused").to_string();
            assert!(said.contains("is given for another variable too"), "{said}");
        }
    }

    #[test]
    fn other_scalars_are_joined_as_before() {
        let mut model = model(&["p[1]", "p[2]", "a_1", "a_2"]);
        let names = join(&mut model, &given("interface_pressure", "p".into())).expect("it is there");
        assert_eq!(names["interface_pressure"], "p");
        let found: Vec<&str> = model.variables.iter().map(|variable| variable.name.as_str()).collect();
        assert_eq!(found, ["p", "a_1", "a_2"]);
        let shown = summarised(&model, model.variables.iter());
        assert_eq!(shown, [("p".to_owned(), Some(2)), ("a_{i}".to_owned(), Some(2))]);
    }
}
