//! Tables and lists in HTML.

use super::super::Quantity;
use super::super::stability::StabilityTable;
use super::data::{Check, Group, Row, Value};
use super::number::{plain, shown};
use quick_xml::escape::escape;
use std::fmt::Write;

/// A number as text, with all its digits in the markup.
pub fn number(value: f64) -> String {
    format!("<data value=\"{value}\">{}</data>", shown(value))
}

/// An input value with all its digits.
fn given(value: f64) -> String {
    format!("<data value=\"{value}\">{}</data>", plain(value))
}

/// The unit, if there is one.
pub fn unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { escape(unit).into_owned() }
}

/// When and where a quantity occurred.
pub fn occasion(quantity: &Quantity) -> String {
    let time = quantity.time.map(|time| format!("at <data value=\"{time}\">{time:.3}</data> s"));
    let place = quantity.place.map(|[x, y]| format!("x = {}, y = {} m", given(x), given(y)));
    time.into_iter().chain(place).collect::<Vec<_>>().join(", ")
}

/// Rows under a heading: given values, remarks below them.
pub fn group(group: &Group) -> String {
    // Writing to a string cannot fail.
    let mut text =
        format!("<section class=\"group\"><h3>{}</h3><table class=\"inputs\"><tbody>\n", escape(&group.name));
    for Row { name, value, remark } in &group.rows {
        let value = match value {
            Value::Number(value, of) => format!("<b>{}</b> {}", given(*value), unit(of)),
            Value::Text(words) => format!("<b>{}</b>", escape(words)),
            Value::Code(code) => format!("<code>{}</code>", escape(code)),
        };
        let remark =
            if remark.is_empty() { String::new() } else { format!("<small>{}</small>", escape(remark)) };
        let _ = writeln!(text, "<tr><th scope=\"row\">{}</th><td>{value}{remark}</td></tr>", escape(name));
    }
    text + "</tbody></table></section>\n"
}

/// A table of results with remarks.
pub fn results(rows: &[Row]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut text = String::from("<table class=\"short\"><tbody>\n");
    for Row { name, value, remark } in rows {
        let value = match value {
            Value::Number(value, of) => {
                format!("<td class=\"number\">{}</td><td class=\"unit\">{}</td>", number(*value), unit(of))
            }
            Value::Text(words) | Value::Code(words) => format!("<td colspan=\"2\">{}</td>", escape(words)),
        };
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th>{value}<td class=\"remark\">{}</td></tr>",
            escape(name),
            escape(remark)
        );
    }
    text + "</tbody></table>\n"
}

/// The stability of a joint: one column for each combination of loads.
pub fn stability(joint: &StabilityTable) -> String {
    let StabilityTable { title, columns, rows, run } = joint;
    let cells = |values: &mut dyn Iterator<Item = &str>, tag: &str| -> String {
        values.map(|value| format!("<{tag} class=\"number\">{}</{tag}>", escape(value))).collect()
    };
    let heads = cells(&mut columns.iter().map(String::as_str), "th");
    let mut text = format!(
        "<h3>{}</h3>\n<table class=\"short\"><thead><tr><th></th>{heads}</tr></thead><tbody>\n",
        escape(title)
    );
    for (label, values) in rows {
        let values = cells(&mut values.iter().map(String::as_str), "td");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "<tr><th scope=\"row\">{}</th>{values}</tr>", escape(label));
    }
    text += "</tbody></table>\n";
    for run in run {
        let _ = writeln!(text, "<p class=\"about\">{}</p>", escape(run));
    }
    text
}

/// The table of the summary; with a column of bands if there are any.
pub fn quantities(quantities: &[Quantity]) -> String {
    let banded = quantities.iter().any(|quantity| quantity.band.is_some());
    let heading =
        if banded { "<th scope=\"col\" class=\"number\">16 %, median, 84 % of replicates</th>" } else { "" };
    let mut text = format!(
        "<table class=\"quantities\"><thead><tr><th scope=\"col\">quantity</th><th scope=\"col\" class=\"number\">value</th>\
         <th scope=\"col\">unit</th>{heading}<th scope=\"col\">time and place</th></tr></thead><tbody>\n",
    );
    for quantity in quantities {
        let band = match quantity.band {
            _ if !banded => String::new(),
            None => "<td></td>".to_owned(),
            Some(band) => format!("<td class=\"number\">{}</td>", band.map(number).join(", ")),
        };
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th><td class=\"number\">{}</td><td class=\"unit\">{}</td>{band}<td class=\"remark\">{}</td></tr>",
            escape(&quantity.name),
            number(quantity.value),
            unit(&quantity.unit),
            occasion(quantity)
        );
    }
    text + "</tbody></table>\n"
}

/// The table of the checks.
pub fn checks(checks: &[Check]) -> String {
    let mut text = String::from(
        "<table class=\"checks\"><thead><tr><th scope=\"col\">check</th><th scope=\"col\" class=\"number\">value</th>\
         <th scope=\"col\" class=\"number\">reference</th><th scope=\"col\">unit</th><th scope=\"col\">limit</th>\
         <th scope=\"col\">result</th><th scope=\"col\">basis</th></tr></thead><tbody>\n",
    );
    for check in checks {
        let (class, verdict) = match check.kept {
            Some(true) => ("kept", "✓ passed"),
            Some(false) => ("broken", "✗ failed"),
            None => ("unjudged", "not judged"),
        };
        let _ = writeln!(
            text,
            "<tr class=\"{class}\"><th scope=\"row\">{}</th><td class=\"number\">{}</td><td class=\"number\">{}</td>\
             <td class=\"unit\">{}</td><td>{}</td><td class=\"verdict\">{verdict}</td><td class=\"remark\">{}</td></tr>",
            escape(&check.name),
            number(check.found),
            check.expected.map_or_else(String::new, number),
            unit(check.unit),
            escape(&check.limit),
            escape(&check.remark)
        );
    }
    text + "</tbody></table>\n"
}

/// A list of sentences; text between backquotes is a key or a command.
pub fn list(sentences: &[String]) -> String {
    let items: String =
        sentences.iter().map(|sentence| format!("<li>{}</li>\n", with_code(sentence))).collect();
    format!("<ul>\n{items}</ul>\n")
}

fn with_code(sentence: &str) -> String {
    let parts: Vec<&str> = sentence.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return escape(sentence).into_owned();
    }
    let part = |(index, part): (usize, &&str)| match index % 2 {
        0 => escape(*part).into_owned(),
        _ => format!("<code>{}</code>", escape(*part)),
    };
    parts.iter().enumerate().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_marked_and_nothing_is_taken_as_markup() {
        assert_eq!(with_code("a smaller `mu<1` & more"), "a smaller <code>mu&lt;1</code> &amp; more");
        assert_eq!(with_code("one ` alone <b>"), "one ` alone &lt;b&gt;");
    }
}
