//! Holds a scene as it is written against the shape that it must have, and mends it.

use super::document::{Content, Entries, Node, Place};
use super::shape::{Field, Shape, join};
use super::{Invalid, Scene};
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// How keys begin that ask for physics that is not there, a word of each, and what that is.
const NOT_MODELLED: [(&[&str], &str); 2] = [
    (&["foundation", "rock", "abutment"], "ground that deforms is"),
    (&["temperature", "thermal"], "strains of temperature are"),
];

/// Other words of engineers for keys.
const OTHER_WORDS: [(&str, &str); 7] = [
    ("friction_angle", "friction_coefficient"),
    ("phi", "friction_coefficient"),
    ("level", "depth"),
    ("water_level", "depth"),
    ("e", "young_modulus"),
    ("elastic_modulus", "young_modulus"),
    ("nu", "poisson_ratio"),
];

fn not_modelled(key: &str) -> Option<&'static str> {
    let key = key.to_lowercase();
    let begins =
        |starts: &[&str]| key.split(['_', '-']).any(|word| starts.iter().any(|s| word.starts_with(s)));
    NOT_MODELLED.iter().find(|(starts, _)| begins(starts)).map(|(_, what)| *what)
}

/// A scene that has its shape, and what was done for that.
#[derive(Debug, Default)]
pub struct Conformed {
    /// What was wrong, and where.
    pub problems: Vec<(Place, Invalid)>,
    /// Where the value of each key stands.
    pub places: BTreeMap<String, Place>,
    /// Keys whose value is a stand-in, so that nothing can be said about it.
    pub unsound: BTreeSet<String>,
    /// What is missing, with its table.
    missing: Vec<(String, &'static Field)>,
    /// Tables to which misplaced keys belong, and those keys.
    misplaced: Vec<(String, String)>,
}

impl Conformed {
    /// The scene in `node`, with stand-ins for what is wrong.
    pub fn read(node: &Node) -> (Option<Scene>, Self) {
        let mut found = Self::default();
        let mended = found.value(node, Shape::scene(), "");
        found.tell_missing();
        match mended.try_into() {
            Ok(scene) => (Some(scene), found),
            Err(error) => {
                if found.problems.is_empty() {
                    let message = toml::de::Error::message(&error).to_owned();
                    found.problems.push((
                        Place::default(),
                        Invalid::Syntax { message, remedy: "compare it with a shipped scene" },
                    ));
                }
                (None, found)
            }
        }
    }

    /// Place of the value at `key`; where that is not written, of the innermost table that is.
    pub fn place(&self, key: &str) -> Place {
        let mut key = key;
        loop {
            match (self.places.get(key), key.rsplit_once('.')) {
                (Some(place), _) => return place.clone(),
                (None, Some((table, _))) => key = table,
                (None, None) => return Place::default(),
            }
        }
    }

    /// A value that has `shape`: the one at `path`, or a stand-in.
    fn value(&mut self, node: &Node, shape: &'static Shape, path: &str) -> Value {
        self.places.insert(path.to_owned(), node.place.clone());
        match (shape, &node.content) {
            (Shape::Any, Content::Scalar(value)) => return value.clone(),
            (Shape::Any, Content::Array(nodes)) => {
                let number = |node: &Node| match &node.content {
                    Content::Scalar(value @ (Value::Float(_) | Value::Integer(_))) => Some(value.clone()),
                    _ => None,
                };
                if let Some(numbers) = nodes.iter().map(number).collect() {
                    return Value::Array(numbers);
                }
                let (key, wanted, found) = (path.to_owned(), shape.wanted(), described(&node.content));
                self.problems.push((node.place.clone(), Invalid::Type { key, wanted, found }));
            }
            (Shape::Map(of), Content::Table(entries)) => {
                let value = |(name, (_, node)): (&String, &(Place, Node))| {
                    (name.clone(), self.value(node, of, &join(path, name)))
                };
                return Value::Table(entries.iter().map(value).collect());
            }
            (Shape::Table(fields), Content::Table(entries)) => return self.table(entries, fields, path),
            (Shape::Array(of, count), Content::Array(nodes)) if count.is_none_or(|n| n == nodes.len()) => {
                let values = nodes.iter().enumerate();
                let value = |(i, node): (usize, &Node)| self.value(node, of, &join(path, &i.to_string()));
                return Value::Array(values.map(value).collect());
            }
            (
                Shape::Number(range) | Shape::NumberOr(range, _),
                Content::Scalar(Value::Float(_) | Value::Integer(_)) | Content::Large(..),
            ) => {
                let number = match &node.content {
                    Content::Scalar(Value::Integer(number)) => *number as f64,
                    Content::Scalar(Value::Float(number)) | Content::Large(_, number) => *number,
                    _ => f64::NAN,
                };
                if range.holds(number) {
                    return number.into();
                }
                let invalid = Invalid::outside(path, number, *range);
                self.problems.push((node.place.clone(), invalid));
            }
            (Shape::Whole([least, most]), Content::Scalar(Value::Integer(value))) => {
                if (least..=most).contains(&value) {
                    return (*value).into();
                }
                let key = path.to_owned();
                let invalid = Invalid::Count { key, value: *value, least: *least, most: *most };
                self.problems.push((node.place.clone(), invalid));
            }
            (Shape::Text | Shape::TextOrTexts, Content::Scalar(Value::String(text))) => {
                return text.clone().into();
            }
            (Shape::TextOrTexts, Content::Array(nodes)) => {
                let values = nodes.iter().enumerate();
                let value =
                    |(i, node): (usize, &Node)| self.value(node, &Shape::Text, &join(path, &i.to_string()));
                return Value::Array(values.map(value).collect());
            }
            (Shape::Flag, Content::Scalar(Value::Boolean(flag))) => return (*flag).into(),
            (Shape::Word(words) | Shape::NumberOr(_, words), Content::Scalar(Value::String(word))) => {
                let words: Vec<&str> = words.iter().map(|word| word.word.as_str()).collect();
                if words.contains(&word.as_str()) {
                    return word.clone().into();
                }
                let (key, word) = (path.to_owned(), word.clone());
                let meant = similar(&word, &words).map(str::to_owned);
                let invalid = Invalid::Word { key, word, wanted: shape.wanted(), meant };
                self.problems.push((node.place.clone(), invalid));
            }
            (_, Content::Unreadable) => (),
            (_, content) => {
                let (wanted, found) = (shape.wanted(), described(content));
                let invalid = Invalid::Type { key: path.to_owned(), wanted, found };
                self.problems.push((node.place.clone(), invalid));
            }
        }
        self.unsound.insert(path.to_owned());
        stand_in(shape)
    }

    fn table(&mut self, entries: &Entries, fields: &'static [Field], path: &str) -> Value {
        let known = |name: &str| fields.iter().any(|field| field.name == name);
        let mut given: BTreeMap<&str, Node> = BTreeMap::new();
        for (name, (_, node)) in entries.iter().filter(|(name, _)| known(name)) {
            given.insert(name, node.clone());
        }
        for (name, (place, node)) in entries.iter().filter(|(name, _)| !known(name)) {
            if let Some(meant) = self.unknown((name, place, node), &given, fields, path) {
                match given.get_mut(meant) {
                    Some(other) if can_join(other, node) => join_nodes(other, node.clone()),
                    Some(_) => (),
                    None => drop(given.insert(meant, node.clone())),
                }
            }
        }
        let mut mended = Table::new();
        for field in fields {
            let key = join(path, &field.name);
            match given.get(field.name.as_str()) {
                Some(node) => drop(mended.insert(field.name.clone(), self.value(node, &field.shape, &key))),
                None if field.required => {
                    self.missing.push((path.to_owned(), field));
                    mended.insert(field.name.clone(), stand_in(&field.shape));
                    self.unsound.insert(key);
                }
                None => (),
            }
        }
        mended.into()
    }

    /// Tells of a key that the table at `path` does not have; returns the one that was meant, if that is clear.
    fn unknown(
        &mut self,
        (name, place, node): (&str, &Place, &Node),
        given: &BTreeMap<&str, Node>,
        fields: &'static [Field],
        path: &str,
    ) -> Option<&'static str> {
        if let Some(what) = not_modelled(name) {
            let (key, table) = (name.to_owned(), Shape::header(path));
            self.problems.push((place.clone(), Invalid::NotModelled { key, table, what }));
            return None;
        }
        // In the file a key is given once; `--set` mostly changes one that is.
        let free = |field: &&Field| {
            place.text > 0 || given.get(field.name.as_str()).is_none_or(|other| can_join(other, node))
        };
        let free: Vec<&'static str> = fields.iter().filter(free).map(|field| field.name.as_str()).collect();
        let everywhere = Shape::scene().homes(name, "");
        let homes: Vec<&String> = everywhere
            .iter()
            .filter(|home| !Shape::is_like_another(home) && !is_of_another_program(home))
            .collect();
        let at_home = matches!(homes.len(), 1..=4);
        let other_word = OTHER_WORDS.iter().find(|(word, _)| *word == name.to_lowercase());
        let other_word = other_word.and_then(|(_, key)| free.iter().copied().find(|free| free == key));
        let meant = other_word
            .or_else(|| similar(name, &free))
            .or_else(|| if at_home { None } else { alike(name, &free) });
        let (key, table) = (name.to_owned(), Shape::header(path));
        let invalid = match meant {
            Some(meant) => Invalid::Misspelt { key, table, meant: meant.to_owned() },
            None if at_home => {
                self.misplaced.extend(everywhere.iter().map(|home| (home.clone(), key.clone())));
                let place = |home: &String| match home.as_str() {
                    "" => "the top of the file, above all tables".to_owned(),
                    home => Shape::header(home),
                };
                let homes: Vec<String> = homes.into_iter().map(place).collect();
                Invalid::Misplaced { key, table, home: homes.join(" or ") }
            }
            None => {
                let keys: Vec<String> = fields.iter().map(|field| format!("`{}`", field.name)).collect();
                Invalid::Unknown { key, table, keys: keys.join(", ") }
            }
        };
        self.problems.push((place.clone(), invalid));
        meant
    }

    /// Missing is what stands nowhere, not even in a wrong table.
    fn tell_missing(&mut self) {
        let given = |key: &String| self.places.contains_key(key);
        let meant = self.misplaced.iter().map(|(home, key)| join(home, key));
        self.unsound.extend(meant.filter(|key| !given(key)));
        for (table, field) in std::mem::take(&mut self.missing) {
            let key = join(&pattern(&table), &field.name);
            let elsewhere = |(home, name): &(String, String)| join(home, name) == key || *home == key;
            if !self.misplaced.iter().any(elsewhere) {
                let header = Shape::header(&key);
                let key = if field.shape.is_table() { header } else { format!("`{}`", field.name) };
                let meaning = field.summary();
                let invalid = Invalid::Missing { key, table: Shape::header(&table), meaning };
                self.problems.push((self.place(&table), invalid));
            }
        }
    }
}

/// Whether a table is that of another program's unit: rarely there, and with keys that other tables have too.
fn is_of_another_program(table: &str) -> bool {
    [".fmu", ".command", ".log"].iter().any(|end| table.ends_with(end))
}

/// A value of that shape from which no check draws anything.
fn stand_in(shape: &Shape) -> Value {
    match shape {
        Shape::Table(fields) => {
            let required = fields.iter().filter(|field| field.required);
            required.map(|field| (field.name.clone(), stand_in(&field.shape))).collect::<Table>().into()
        }
        Shape::Map(_) => Table::new().into(),
        Shape::Array(of, count) => vec![stand_in(of); count.unwrap_or(0)].into(),
        Shape::Number(_) | Shape::NumberOr(..) => f64::NAN.into(),
        Shape::Whole([least, most]) => 0.clamp(*least, *most).into(),
        Shape::Word(words) => words.first().map(|word| word.word.clone()).unwrap_or_default().into(),
        Shape::Flag => false.into(),
        Shape::Text | Shape::TextOrTexts | Shape::Any => String::new().into(),
    }
}

/// The path without the numbers of tables in arrays.
fn pattern(path: &str) -> String {
    let names: Vec<&str> = path.split('.').filter(|part| part.parse::<usize>().is_err()).collect();
    names.join(".")
}

/// Whether both are parts of one table, or rows of one array: a header among several was misspelt.
fn can_join(one: &Node, other: &Node) -> bool {
    let tables = |nodes: &[Node]| nodes.iter().all(|node| matches!(node.content, Content::Table(_)));
    match (&one.content, &other.content) {
        (Content::Table(one), Content::Table(other)) => one.keys().all(|key| !other.contains_key(key)),
        (Content::Array(one), Content::Array(other)) => tables(one) && tables(other),
        _ => false,
    }
}

fn join_nodes(one: &mut Node, other: Node) {
    match (&mut one.content, other.content) {
        (Content::Table(one), Content::Table(other)) => one.extend(other),
        (Content::Array(one), Content::Array(other)) => one.extend(other),
        _ => (),
    }
}

/// The candidate that a slip or two of the hand turn into `word`.
fn similar<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let distance = |candidate: &&&str| strsim::osa_distance(&word.to_lowercase(), &candidate.to_lowercase());
    let nearest = candidates.iter().min_by_key(distance)?;
    // One slip in three letters, as rustc has it.
    (distance(&nearest) <= word.chars().count().max(3) / 3).then_some(*nearest)
}

/// The only candidate that begins with `word`, or else that is part of it or of which it is part.
fn alike<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let only = |fits: &dyn Fn(&str) -> bool| {
        let mut fitting = candidates.iter().filter(|candidate| fits(candidate));
        fitting.next().filter(|_| fitting.next().is_none()).copied()
    };
    let part = |short: &str, long: &str| short.len() > 3 && long.contains(short);
    only(&|candidate| word.len() > 3 && candidate.starts_with(word))
        .or_else(|| only(&|candidate| part(word, candidate) || part(candidate, word)))
}

fn described(content: &Content) -> String {
    match content {
        Content::Table(_) => "a table".to_owned(),
        Content::Array(values) => format!("an array of {}", values.len()),
        Content::Scalar(Value::String(text)) if text.replacen(',', ".", 1).parse::<f64>().is_ok() => {
            format!("the text {text:?}; numbers have a decimal point, no comma, and no quotes")
        }
        Content::Scalar(Value::String(text)) => format!("the text {text:?}"),
        Content::Scalar(Value::Integer(number)) => format!("the number {number}"),
        // Not the three hundred digits of 1e300.
        Content::Scalar(Value::Float(number)) => format!("the number {number:?}"),
        Content::Large(text, _) => format!("the number {text}, which is too large"),
        Content::Scalar(value) => value.to_string(),
        Content::Unreadable => "unreadable".to_owned(),
    }
}
