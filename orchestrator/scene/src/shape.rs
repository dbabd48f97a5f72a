//! What a scene may hold, derived from its types: the keys of every table, and what their values must be.

use super::Scene;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value as Schema;
use std::sync::OnceLock;

/// What a value must be.
#[derive(Debug)]
pub enum Shape {
    Table(Vec<Field>),
    /// A table whose keys are the user's own.
    Map(Box<Shape>),
    /// Of so many values, or of any number.
    Array(Box<Shape>, Option<usize>),
    Number(Range),
    /// A number or a word.
    NumberOr(Range, Vec<Word>),
    /// A whole number from the first to the last.
    Whole([i64; 2]),
    Text,
    /// A text, or several.
    TextOrTexts,
    /// `true` or `false`.
    Flag,
    Word(Vec<Word>),
    /// The types say no more.
    Any,
}

/// The numbers that a key may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub least: f64,
    pub most: f64,
    /// Whether `least` itself is none of them.
    pub open: bool,
}

/// One of the words that a key may have.
#[derive(Debug)]
pub struct Word {
    pub word: String,
    /// What it means, as its type's author says.
    pub meaning: String,
}

/// A key of a table.
#[derive(Debug)]
pub struct Field {
    pub name: String,
    /// What it is, as its type's author says.
    pub meaning: String,
    pub required: bool,
    pub shape: Shape,
    /// SI unit; empty for pure numbers and words.
    pub unit: String,
    /// What is taken where the key is not given.
    pub default: Option<Schema>,
    /// The same in words, where it follows from other keys.
    pub otherwise: Option<String>,
    /// The table whose keys it has too.
    pub like: Option<String>,
}

impl Range {
    /// Whether `value` is one of these numbers; NaN never is.
    pub fn holds(self, value: f64) -> bool {
        let above = if self.open { value > self.least } else { value >= self.least };
        // Where nothing is said, the checks of what the keys mean together look at the number.
        self.is_free() || above && value <= self.most
    }

    /// Whether all numbers are allowed.
    pub fn is_free(self) -> bool {
        self.least == f64::NEG_INFINITY && self.most == f64::INFINITY
    }

    fn of(schema: &Schema) -> Self {
        let bound = |key: &str| schema[key].as_f64();
        let open = bound("exclusiveMinimum");
        let least = open.or(bound("minimum")).unwrap_or(f64::NEG_INFINITY);
        let most = bound("maximum").unwrap_or(if open.is_some() { f64::MAX } else { f64::INFINITY });
        Self { least, most, open: open.is_some() }
    }
}

impl Field {
    /// The first sentence of its meaning, and its unit.
    pub fn summary(&self) -> String {
        let first = self.meaning.split(". ").next().unwrap_or("").trim_end_matches('.');
        if self.unit.is_empty() { first.to_owned() } else { format!("{first}, {}", self.unit) }
    }
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
        let given: Vec<Self> = list("anyOf").iter().filter(|s| !is_null(s)).map(Self::of).collect();
        match <[Self; 2]>::try_from(given) {
            Ok([Self::Number(range), Self::Word(words)]) => return Self::NumberOr(range, words),
            Ok([Self::Text, Self::Array(of, None)]) if matches!(*of, Self::Text) => return Self::TextOrTexts,
            Ok([first, _]) => return first,
            Err(given) => {
                if let Some(first) = given.into_iter().next() {
                    return first;
                }
            }
        }
        let word = |s: &Schema| {
            let word = s["const"].as_str().or(s.as_str())?.to_owned();
            Some(Word { word, meaning: text(s, "description") })
        };
        let words: Vec<Word> = list("oneOf").iter().chain(list("enum")).filter_map(word).collect();
        if !words.is_empty() {
            return Self::Word(words);
        }
        // An optional value is `["number", "null"]`.
        let of_type = list("type").iter().find_map(|t| t.as_str().filter(|t| *t != "null"));
        match schema["type"].as_str().or(of_type) {
            Some("object") => match schema.get("additionalProperties") {
                Some(of) if *of != false => Self::Map(Box::new(Self::of(of))),
                _ => Self::Table(Self::fields(schema)),
            },
            Some("array") => {
                let count = schema["minItems"].as_u64().filter(|n| schema["maxItems"].as_u64() == Some(*n));
                Self::Array(Box::new(Self::of(&schema["items"])), count.map(|n| n as usize))
            }
            Some("number") => Self::Number(Range::of(schema)),
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
            meaning: text(schema, "description"),
            required: required(name),
            shape: Self::of(schema),
            unit: text(schema, "unit"),
            default: schema.get("default").filter(|value| !value.is_null()).cloned(),
            otherwise: schema["otherwise"].as_str().map(str::to_owned),
            like: schema["like"].as_str().map(str::to_owned),
        };
        properties.map(field).collect()
    }

    /// The key at `path`, such as `dam.cracks.0.elevation` or `dam.cracks.elevation`.
    pub fn field(path: &str) -> Option<&'static Field> {
        let mut found: Option<&'static Field> = None;
        for name in path.split('.').filter(|part| part.parse::<usize>().is_err()) {
            let fields = found.map_or(Self::scene(), |field| &field.shape).rows()?;
            found = Some(fields.iter().find(|field| field.name == name)?);
        }
        found
    }

    /// The keys of a table, or of each of several.
    pub fn rows(&self) -> Option<&[Field]> {
        match self {
            Self::Table(fields) => Some(fields),
            Self::Array(of, None) => of.rows(),
            _ => None,
        }
    }

    /// The tables, each as its header is written, in which `key` is at home; `path` is that of this table.
    pub fn homes(&self, key: &str, path: &str) -> Vec<String> {
        let fields = self.rows().unwrap_or(&[]);
        let own = fields.iter().any(|field| field.name == key).then(|| path.to_owned());
        let below = fields.iter().flat_map(|field| field.shape.homes(key, &join(path, &field.name)));
        own.into_iter().chain(below).collect()
    }

    /// Whether the table at `path` has the keys of another one.
    pub fn is_like_another(path: &str) -> bool {
        Self::field(path).is_some_and(|field| field.like.is_some())
    }

    /// The header of the table at `path`.
    pub fn header(path: &str) -> String {
        // The parts that are numbers say which of several tables.
        let names: Vec<&str> = path.split('.').filter(|part| part.parse::<usize>().is_err()).collect();
        match Self::field(path).map(|field| &field.shape) {
            _ if path.is_empty() => "the scene".to_owned(),
            Some(Self::Array(..)) => format!("`[[{}]]`", names.join(".")),
            _ => format!("`[{}]`", names.join(".")),
        }
    }

    /// Whether it is a table, or several.
    pub fn is_table(&self) -> bool {
        self.rows().is_some()
    }

    /// What it must be, in words.
    pub fn wanted(&self) -> String {
        match self {
            Self::Table(_) => "a table".to_owned(),
            Self::Map(of) => format!("a table of {}", of.plural()),
            Self::Array(of, Some(count)) => format!("an array of {count} {}", of.plural()),
            Self::Array(of, None) => format!("an array of {}", of.plural()),
            Self::Number(_) => "a number".to_owned(),
            Self::NumberOr(_, words) => format!("a number or {}", one_of(words)),
            Self::Whole(_) => "a whole number".to_owned(),
            Self::Text => "text in quotes".to_owned(),
            Self::TextOrTexts => "one text or several".to_owned(),
            Self::Flag => "true or false".to_owned(),
            Self::Word(words) => one_of(words),
            Self::Any => "a number, text, true or false, or an array of numbers".to_owned(),
        }
    }

    fn plural(&self) -> String {
        match self {
            Self::Table(_) => "tables".to_owned(),
            Self::Array(of, Some(count)) => format!("arrays of {count} {}", of.plural()),
            Self::Number(_) => "numbers".to_owned(),
            Self::Any => "values".to_owned(),
            other => format!("values, each {}", other.wanted()),
        }
    }
}

fn text(schema: &Schema, key: &str) -> String {
    schema[key].as_str().unwrap_or("").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The words, quoted, with `or` before the last.
fn one_of(words: &[Word]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("`{}`", word.word)).collect();
    match quoted.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => quoted.concat(),
    }
}

/// The word of a scene for one of its choices.
pub fn word(choice: &impl Serialize) -> String {
    let value = toml::Value::try_from(choice).ok();
    value.and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// The path of `key` in the table at `path`.
pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
