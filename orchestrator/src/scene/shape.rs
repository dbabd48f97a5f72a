//! What a scene may hold, derived from its types: the keys of every table, and what their values must be.

use super::Scene;
use schemars::generate::SchemaSettings;
use serde_json::Value as Schema;
use std::sync::OnceLock;

/// What a value must be.
#[derive(Debug)]
pub enum Shape {
    Table(Vec<Field>),
    /// Of so many values, or of any number.
    Array(Box<Shape>, Option<usize>),
    Number,
    /// A whole number from the first to the last.
    Whole([i64; 2]),
    Text,
    /// `true` or `false`.
    Flag,
    /// One of these.
    Word(Vec<String>),
    /// The types say no more.
    Any,
}

/// A key of a table.
#[derive(Debug)]
pub struct Field {
    pub name: String,
    /// What it is, as its type's author says.
    pub meaning: String,
    pub required: bool,
    pub shape: Shape,
}

impl Shape {
    /// That of a scene.
    pub fn scene() -> &'static Self {
        static SHAPE: OnceLock<Shape> = OnceLock::new();
        SHAPE.get_or_init(|| {
            let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
            Self::of(settings.into_generator().into_root_schema_for::<Scene>().as_value())
        })
    }

    fn of(schema: &Schema) -> Self {
        let list = |key: &str| schema[key].as_array().map_or(&[][..], Vec::as_slice);
        let is_null = |s: &&Schema| s["type"] == "null";
        if let Some(given) = list("anyOf").iter().find(|s| !is_null(s)) {
            return Self::of(given);
        }
        let word = |s: &Schema| s["const"].as_str().or(s.as_str()).map(str::to_owned);
        let words = list("oneOf").iter().chain(list("enum")).filter_map(word);
        let words: Vec<String> = words.collect();
        if !words.is_empty() {
            return Self::Word(words);
        }
        // An optional value is `["number", "null"]`.
        let of_type = list("type").iter().find_map(|t| t.as_str().filter(|t| *t != "null"));
        match schema["type"].as_str().or(of_type) {
            Some("object") => Self::Table(Self::fields(schema)),
            Some("array") => {
                let count = schema["minItems"].as_u64().filter(|n| schema["maxItems"].as_u64() == Some(*n));
                Self::Array(Box::new(Self::of(&schema["items"])), count.map(|n| n as usize))
            }
            Some("number") => Self::Number,
            Some("integer") => {
                let bound = |key: &str| schema[key].as_i64();
                Self::Whole([bound("minimum").unwrap_or(i64::MIN), bound("maximum").unwrap_or(i64::MAX)])
            }
            Some("string") => Self::Text,
            Some("boolean") => Self::Flag,
            _ => Self::Any,
        }
    }

    fn fields(schema: &Schema) -> Vec<Field> {
        let required =
            |name: &str| schema["required"].as_array().is_some_and(|r| r.iter().any(|k| k == name));
        let properties = schema["properties"].as_object().into_iter().flatten();
        let field = |(name, schema): (&String, &Schema)| Field {
            name: name.clone(),
            meaning: schema["description"].as_str().unwrap_or("").trim_end_matches('.').to_owned(),
            required: required(name),
            shape: Self::of(schema),
        };
        properties.map(field).collect()
    }

    /// The tables, each as its header is written, in which `key` is at home; `path` is that of this table.
    pub fn homes(&self, key: &str, path: &str) -> Vec<String> {
        let Self::Table(fields) = self else { return Vec::new() };
        let own = fields.iter().any(|field| field.name == key).then(|| path.to_owned());
        let below = fields.iter().flat_map(|field| match &field.shape {
            Self::Array(rows, None) => rows.homes(key, &join(path, &field.name)),
            shape => shape.homes(key, &join(path, &field.name)),
        });
        own.into_iter().chain(below).collect()
    }

    /// The header of the table at `path`.
    pub fn header(path: &str) -> String {
        // The parts that are numbers say which of several tables.
        let names: Vec<&str> = path.split('.').filter(|part| part.parse::<usize>().is_err()).collect();
        let mut shape = Self::scene();
        for name in &names {
            let field = |fields: &'static [Field]| fields.iter().find(|field| field.name == *name);
            let found = match shape {
                Self::Table(fields) => field(fields),
                Self::Array(rows, _) => match &**rows {
                    Self::Table(fields) => field(fields),
                    _ => None,
                },
                _ => None,
            };
            match found {
                Some(field) => shape = &field.shape,
                None => break,
            }
        }
        match shape {
            _ if path.is_empty() => "the scene".to_owned(),
            Self::Array(..) => format!("`[[{}]]`", names.join(".")),
            _ => format!("`[{}]`", names.join(".")),
        }
    }

    /// Whether it is a table, or several.
    pub fn is_table(&self) -> bool {
        match self {
            Self::Table(_) => true,
            Self::Array(of, _) => of.is_table(),
            _ => false,
        }
    }

    /// What it must be, in words.
    pub fn wanted(&self) -> String {
        match self {
            Self::Table(_) => "a table".to_owned(),
            Self::Array(of, Some(count)) => format!("an array of {count} {}", of.plural()),
            Self::Array(of, None) => format!("an array of {}", of.plural()),
            Self::Number => "a number".to_owned(),
            Self::Whole(_) => "a whole number".to_owned(),
            Self::Text => "text in quotes".to_owned(),
            Self::Flag => "true or false".to_owned(),
            Self::Word(words) => one_of(words),
            Self::Any => "something else".to_owned(),
        }
    }

    fn plural(&self) -> String {
        match self {
            Self::Table(_) => "tables".to_owned(),
            Self::Array(of, Some(count)) => format!("arrays of {count} {}", of.plural()),
            Self::Number => "numbers".to_owned(),
            other => format!("values, each {}", other.wanted()),
        }
    }
}

/// The words, quoted, with `or` before the last.
pub fn one_of(words: &[String]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
    match quoted.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => quoted.concat(),
    }
}

/// The path of `key` in the table at `path`.
pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
