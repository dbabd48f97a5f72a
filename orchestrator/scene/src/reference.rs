//! The keys of a scene as a text: the part of `scenes/README.md` between its two marks.

use super::shape::{Field, Range, Shape, join};
use cofferdam_unit::number::plain;
use serde_json::Value;
use std::fmt::Write;

/// Every key of a scene in Markdown, one table for each table of a scene, with unit, range, default and meaning.
pub fn reference() -> String {
    let mut text = String::new();
    table(&mut text, "", "", Shape::scene());
    text
}

fn table(text: &mut String, path: &str, meaning: &str, shape: &Shape) {
    let fields = shape.rows().unwrap_or(&[]);
    let (keys, tables): (Vec<&Field>, Vec<&Field>) = fields.iter().partition(|field| !field.shape.is_table());
    if !keys.is_empty() {
        let title = if path.is_empty() { "Above all tables".to_owned() } else { Shape::header(path) };
        let meaning = if meaning.is_empty() { String::new() } else { format!("{meaning}\n\n") };
        let head = "| key | unit | range | default | meaning |\n|---|---|---|---|---|";
        // Writing to a String does not fail.
        let _ = writeln!(text, "### {title}\n\n{meaning}{head}");
        for field in keys {
            let (key, unit) = (join(path, &field.name), &field.unit);
            let (range, default, meaning) = (range(&field.shape), default(field), meaning_of(field));
            let _ = writeln!(text, "| `{key}` | {unit} | {range} | {default} | {meaning} |");
        }
        text.push('\n');
    }
    for field in tables {
        if let Some(like) = &field.like {
            let (header, like) = (Shape::header(&join(path, &field.name)), Shape::header(like));
            // Writing to a String does not fail.
            let _ = writeln!(
                text,
                "### {header}\n\n{} The keys, with their ranges and defaults, are those of {like}.\n",
                field.meaning
            );
            continue;
        }
        table(text, &join(path, &field.name), &field.meaning, &field.shape);
    }
}

fn range(shape: &Shape) -> String {
    match shape {
        Shape::Number(range) if range.is_free() => String::new(),
        Shape::Number(Range { least, most: f64::MAX, .. }) => format!("> {}", plain(*least)),
        Shape::Number(Range { least, most, .. }) | Shape::NumberOr(Range { least, most, .. }, _) => {
            format!("{} to {}", plain(*least), plain(*most))
        }
        Shape::Whole([i64::MIN, _] | [_, i64::MAX]) => String::new(),
        Shape::Whole([least, most]) => format!("{least} to {most}"),
        _ => String::new(),
    }
}

fn default(field: &Field) -> String {
    match (&field.default, &field.otherwise) {
        (_, Some(words)) => words.clone(),
        (Some(value), None) => format!("`{}`", shown(value)),
        (None, None) if field.required => "required".to_owned(),
        (None, None) => "none".to_owned(),
    }
}

/// A value as TOML has it, numbers as short as in messages.
fn shown(value: &Value) -> String {
    match value {
        Value::Number(number) => number.as_f64().map_or_else(String::new, plain),
        Value::Array(values) => {
            format!("[{}]", values.iter().map(shown).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

/// The meaning of a key, and of each word that it may have.
fn meaning_of(field: &Field) -> String {
    let words = match &field.shape {
        Shape::Word(words) | Shape::NumberOr(_, words) => words,
        Shape::Array(of, None) => match &**of {
            Shape::Word(words) => words,
            _ => return escaped(&field.meaning),
        },
        _ => return escaped(&field.meaning),
    };
    let each = words.iter().map(|word| match word.meaning.trim_end_matches('.') {
        "" => format!("`\"{}\"`", word.word),
        meaning => format!("`\"{}\"`: {meaning}", word.word),
    });
    escaped(&format!("{}<br>{}", field.meaning, each.collect::<Vec<_>>().join("<br>")))
}

/// Text in a cell of a table.
fn escaped(text: &str) -> String {
    text.replace('|', "\\|")
}
