use super::{Invalid, SceneError};
use std::path::Path;
use toml::{Table, Value};

/// The scene `source` with each `key=value` of `overrides` set; without any, `source` itself.
pub fn apply(source: String, overrides: &[String], file: &Path) -> Result<String, SceneError> {
    // A scene that is no TOML is reported with its place by whoever parses it next.
    let Ok(mut table) = source.parse::<Table>() else { return Ok(source) };
    if overrides.is_empty() {
        return Ok(source);
    }
    for text in overrides {
        let set =
            text.split_once('=').and_then(|(key, value)| set(&mut table, key.trim(), parse(value.trim())));
        set.ok_or_else(|| SceneError::without_place(file, Invalid::Override { text: text.clone() }))?;
    }
    toml::to_string(&table)
        .map_err(|e| SceneError::without_place(file, Invalid::Syntax { message: e.to_string() }))
}

/// A TOML value, or else the text itself as a string.
fn parse(text: &str) -> Value {
    let parsed = format!("value = {text}").parse::<Table>().ok();
    parsed.and_then(|mut t| t.remove("value")).unwrap_or_else(|| Value::String(text.to_owned()))
}

/// Sets `key`, whose table or array must be there (tables are made).
fn set(table: &mut Table, key: &str, new: Value) -> Option<()> {
    let mut parts: Vec<&str> = key.split('.').collect();
    let last = parts.pop().filter(|l| !l.is_empty())?;
    let Some((first, rest)) = parts.split_first() else {
        table.insert(last.to_owned(), new);
        return Some(());
    };
    let mut value = table.entry(*first).or_insert_with(|| Value::Table(Table::new()));
    for part in rest {
        value = match value {
            Value::Table(table) => table.entry(*part).or_insert_with(|| Value::Table(Table::new())),
            Value::Array(array) => array.get_mut(part.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    match value {
        Value::Table(table) => drop(table.insert(last.to_owned(), new)),
        Value::Array(array) => *array.get_mut(last.parse::<usize>().ok()?)? = new,
        _ => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_set_and_nonsense_is_refused() -> Result<(), SceneError> {
        let source = "[dam]\nsize = 5.0\n[[dam.cracks]]\nelevation = 1.0\n";
        let with = |overrides: &[&str]| {
            let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
            apply(source.to_owned(), &overrides, Path::new("scene.toml"))
        };
        assert_eq!(with(&[])?, source);
        let changed: Table =
            with(&["dam.size=2.5", "dam.cracks.0.elevation = 66.5", "time.quiet=1", "title=a b"])?
                .parse()
                .unwrap_or_default();
        assert_eq!(changed["dam"]["size"].as_float(), Some(2.5));
        assert_eq!(changed["dam"]["cracks"][0]["elevation"].as_float(), Some(66.5));
        assert_eq!(changed["time"]["quiet"].as_integer(), Some(1));
        assert_eq!(changed["title"].as_str(), Some("a b"));
        for wrong in ["dam.size", "dam.cracks.7.elevation=1", "dam.size.deep=1", "=1"] {
            assert!(with(&[wrong]).is_err(), "{wrong}");
        }
        Ok(())
    }
}
