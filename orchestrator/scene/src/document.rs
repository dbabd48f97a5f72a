//! A scene as it is written: a tree of values that know their places, with `--set` put in.

use super::{Invalid, syntax};
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where something is written: in the file (text 0) or in the `--set` of that number, from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    pub text: usize,
    pub start: usize,
    pub end: usize,
}

/// The keys of a table, each with its own place.
pub type Entries = BTreeMap<String, (Place, Node)>;

/// A value and its place; that of a table is its header.
#[derive(Clone, Debug)]
pub struct Node {
    pub content: Content,
    pub place: Place,
}

/// What a node holds.
#[derive(Clone, Debug)]
pub enum Content {
    Table(Entries),
    Array(Vec<Node>),
    Scalar(toml::Value),
    /// A whole number beyond 64 bits: as it is written, and as near as a float comes.
    Large(String, f64),
    /// Given, but no TOML; said already.
    Unreadable,
}

impl Node {
    /// The tree of a file, of which what is no TOML is set aside, and what was wrong with that.
    /// `None` where too little is left to say more.
    pub fn read(source: &str) -> (Option<Self>, Vec<(Place, Invalid)>) {
        let (readable, damages) = syntax::readable(source);
        let tree = readable.and_then(|text| {
            let entries = entries(DeTable::parse(&text).ok()?.get_ref(), 0);
            Some(Self { content: Content::Table(entries), place: Place::default() })
        });
        let tree = tree.map(|mut tree| {
            for damage in &damages {
                let place = Place { text: 0, start: damage.span.start, end: damage.span.end };
                for path in &damage.paths {
                    tree.add(path, Self { content: Content::Unreadable, place: place.clone() });
                }
            }
            tree
        });
        let place = |span: Range<usize>| Place { text: 0, start: span.start, end: span.end };
        let fault =
            |d: syntax::Damage| (place(d.span), Invalid::Syntax { message: d.message, remedy: d.remedy });
        (tree, damages.into_iter().map(fault).collect())
    }

    /// Name of the case and the scene of a manifest; no name and all of what is none.
    pub fn of_manifest(mut self) -> (Option<String>, Self) {
        match &mut self.content {
            Content::Table(entries) if entries.contains_key("build") && entries.contains_key("scene") => {
                let name = entries.remove("name").and_then(|(_, name)| match name.content {
                    Content::Scalar(toml::Value::String(name)) => Some(name),
                    _ => None,
                });
                (name, entries.remove("scene").map_or(self, |(_, scene)| scene))
            }
            _ => (None, self),
        }
    }

    /// Carries out the override `text`, `key=value`, the `number`th; tables are made if need be.
    ///
    /// `None` if it is none, or no such place can be in the scene.
    pub fn set(&mut self, text: &str, number: usize) -> Option<()> {
        let (key, value) = text.split_once('=')?;
        let statement = format!("{key}=0");
        let tables = DeTable::parse(&statement).ok()?;
        let mut parts = Vec::new();
        let mut table = Some(tables.get_ref());
        while let Some((name, value)) = table.and_then(|table| table.iter().next()) {
            let span = name.span();
            parts.push((name.get_ref().as_ref(), Place { text: number, start: span.start, end: span.end }));
            table = value.get_ref().as_table();
        }
        // Padded, so that places are those in `text`.
        let padded = format!("v{}={value}", " ".repeat(key.len() - 1));
        let start = text.len() - value.trim_start().len();
        let place = Place { text: number, start, end: start + value.trim().len() };
        let parsed = DeTable::parse(&padded).ok();
        let parsed = parsed.filter(|table| table.get_ref().len() == 1);
        let new = parsed.and_then(|t| Some(node(t.get_ref().get("v")?, number)));
        let word = || Self { content: Content::Scalar(value.trim().into()), place };
        self.put(&parts, new.unwrap_or_else(word))
    }

    fn put(&mut self, path: &[(&str, Place)], new: Self) -> Option<()> {
        let [(name, place), rest @ ..] = path else {
            *self = new;
            return Some(());
        };
        match &mut self.content {
            Content::Table(entries) => {
                let made = || {
                    let content = Content::Table(Entries::new());
                    (place.clone(), Self { content, place: place.clone() })
                };
                let entry = entries.entry((*name).to_owned()).or_insert_with(made);
                if rest.is_empty() {
                    entry.0 = place.clone();
                }
                entry.1.put(rest, new)
            }
            Content::Array(array) => array.get_mut(name.parse::<usize>().ok()?)?.put(rest, new),
            Content::Scalar(_) | Content::Large(..) => None,
            Content::Unreadable => Some(()),
        }
    }

    /// Puts `new` at `path` if nothing is there; of tables in an array the last is meant.
    fn add(&mut self, path: &[String], new: Self) {
        match (&mut self.content, path) {
            (Content::Table(entries), [name, rest @ ..]) => {
                let place = new.place.clone();
                let entry = match rest {
                    [] => new.clone(),
                    _ => Self { content: Content::Table(Entries::new()), place: place.clone() },
                };
                entries.entry(name.clone()).or_insert((place, entry)).1.add(rest, new);
            }
            (Content::Array(array), [_, ..]) => {
                if let Some(last) = array.last_mut() {
                    last.add(path, new);
                }
            }
            _ => (),
        }
    }
}

fn entries(table: &DeTable<'_>, text: usize) -> Entries {
    let place = |span: Range<usize>| Place { text, start: span.start, end: span.end };
    let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
        let name: &std::borrow::Cow<'_, str> = key.get_ref();
        (name.to_string(), (place(key.span()), node(value, text)))
    };
    table.iter().map(entry).collect()
}

fn node(value: &Spanned<DeValue<'_>>, text: usize) -> Node {
    let span = value.span();
    let content = match value.get_ref() {
        DeValue::Table(table) => Content::Table(entries(table, text)),
        DeValue::Array(array) => Content::Array(array.iter().map(|v| node(v, text)).collect()),
        DeValue::String(word) => Content::Scalar(word.to_string().into()),
        DeValue::Boolean(truth) => Content::Scalar((*truth).into()),
        DeValue::Datetime(date) => Content::Scalar((*date).into()),
        DeValue::Float(number) => Content::Scalar(number.as_str().parse().unwrap_or(f64::NAN).into()),
        DeValue::Integer(number) => {
            let (digits, radix) = (number.as_str(), number.radix());
            match i64::from_str_radix(digits, radix) {
                Ok(number) => Content::Scalar(number.into()),
                Err(_) => Content::Large(number.to_string(), float(digits, radix)),
            }
        }
    };
    Node { content, place: Place { text, start: span.start, end: span.end } }
}

/// The whole number of these digits, which only decimal ones have a sign before.
fn float(digits: &str, radix: u32) -> f64 {
    let each = digits.chars().filter_map(|c| c.to_digit(radix));
    let size = each.fold(0.0, |size, digit| size * f64::from(radix) + f64::from(digit));
    if digits.starts_with('-') { -size } else { size }
}
