//! Tables and lists in HTML.

use super::super::Quantity;
use super::data::{Check, Group, Row, Value};
use super::number::{plain, shown};
use quick_xml::escape::escape;
use std::fmt::Write;

/// A number as text, with all its digits in the markup.
pub fn number(value: f64) -> String {
    format!("<data value=\"{value}\">{}</data>", shown(value))
}

/// A given number, whose digits are all shown.
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

/// Rows under a heading.
pub fn group(group: &Group) -> String {
    let mut text = format!(
        "<section class=\"group\"><h3>{}</h3>{}",
        escape(&group.name),
        rows("inputs", &group.rows, given)
    );
    text.push_str("</section>\n");
    text
}

/// A table of rows, whose numbers are written by `write`.
pub fn rows(class: &str, rows: &[Row], write: fn(f64) -> String) -> String {
    // Writing to a string cannot fail.
    let mut text = format!("<table class=\"{class}\"><tbody>\n");
    for Row { name, value, remark } in rows {
        let value = match value {
            Value::Number(value, of) => {
                format!("<td class=\"number\">{}</td><td class=\"unit\">{}</td>", write(*value), unit(of))
            }
            Value::Text(words) => format!("<td class=\"words\" colspan=\"2\">{}</td>", escape(words)),
            Value::Code(code) => format!("<td class=\"code\" colspan=\"2\">{}</td>", escape(code)),
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

/// The table of the summary.
pub fn quantities(quantities: &[Quantity]) -> String {
    let mut text = String::from(
        "<table class=\"quantities\"><thead><tr><th scope=\"col\">quantity</th><th scope=\"col\" class=\"number\">value</th>\
         <th scope=\"col\">unit</th><th scope=\"col\">when and where</th></tr></thead><tbody>\n",
    );
    for quantity in quantities {
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th><td class=\"number\">{}</td><td class=\"unit\">{}</td><td class=\"remark\">{}</td></tr>",
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
        "<table class=\"checks\"><thead><tr><th scope=\"col\">check</th><th scope=\"col\" class=\"number\">found</th>\
         <th scope=\"col\" class=\"number\">beside</th><th scope=\"col\">unit</th><th scope=\"col\">limit</th>\
         <th scope=\"col\">verdict</th><th scope=\"col\">basis</th></tr></thead><tbody>\n",
    );
    for check in checks {
        let (class, verdict) = match check.kept {
            Some(true) => ("kept", "✓ kept"),
            Some(false) => ("broken", "✗ not kept"),
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

/// A list of sentences.
pub fn list(sentences: &[String]) -> String {
    let items: String = sentences.iter().map(|sentence| format!("<li>{}</li>\n", escape(sentence))).collect();
    format!("<ul>\n{items}</ul>\n")
}
