use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// Place in a TOML document of the value at `key`, such as `dam.cracks.0.elevation`.
///
/// Where a part of the key is not written, because a default stands for it, the place is
/// that of the innermost table that is.
pub fn locate(source: &str, key: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(source).ok()?;
    let mut parts = key.split('.');
    let first = document.get_ref().get(parts.next()?)?;
    let (mut value, mut span) = (first.get_ref(), first.span());
    for part in parts {
        let inner = match value {
            DeValue::Table(table) => table.get(part),
            DeValue::Array(array) => part.parse().ok().and_then(|index: usize| array.get(index)),
            _ => None,
        };
        let Some(inner) = inner else { break };
        (value, span) = (inner.get_ref(), inner.span());
    }
    Some(span)
}

#[cfg(test)]
mod tests {
    use super::locate;

    #[test]
    fn values_are_found_by_their_keys() {
        let source = "[dam]\nsize = 5\n[[dam.cracks]]\nelevation = 1\n[[dam.cracks]]\nelevation = 66.5\n";
        let text = |key| locate(source, key).map(|span| &source[span]);
        assert_eq!(text("dam.cracks.1.elevation"), Some("66.5"));
        assert_eq!(text("dam.size"), Some("5"));
        assert_eq!(text("dam.damping"), Some("[dam]"));
        assert_eq!(text("reservoir.depth"), None);
    }
}
