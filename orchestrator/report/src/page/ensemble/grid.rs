//! Tables whose columns follow from the data.

use super::super::tables;
use super::folder::Table;
use crate::percent;
use quick_xml::escape::escape;
use std::fmt::Write;

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Headings.
    pub headings: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
}

/// What stands in a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// A number.
    Number(f64),
    /// A share, shown in per cent.
    Share(f64),
    /// Words.
    Text(String),
    /// A hash or a key.
    Code(String),
    /// The file of a sample, by its hash.
    Sample(String),
}

impl Cell {
    /// A number where `text` is a finite one.
    pub fn of(text: &str) -> Self {
        match text.parse::<f64>() {
            _ if text.is_empty() => Self::Empty,
            Ok(value) if value.is_finite() => Self::Number(value),
            _ => Self::Text(text.to_owned()),
        }
    }

    /// The same of a share.
    pub fn share(text: &str) -> Self {
        match Self::of(text) {
            Self::Number(share) => Self::Share(share),
            other => other,
        }
    }

    fn html(&self) -> String {
        match self {
            Self::Empty => "<td></td>".to_owned(),
            Self::Number(value) => format!("<td class=\"number\">{}</td>", tables::number(*value)),
            Self::Share(share) => {
                format!("<td class=\"number\"><data value=\"{share}\">{} %</data></td>", percent(*share))
            }
            Self::Text(words) => format!("<td>{}</td>", escape(words)),
            Self::Code(code) => format!("<td><code>{}</code></td>", escape(code)),
            Self::Sample(hash) => format!(
                "<td><a href=\"samples/{0}.toml\"><code>{1}</code></a></td>",
                escape(hash),
                escape(&hash[..hash.char_indices().nth(8).map_or(hash.len(), |(at, _)| at)])
            ),
        }
    }
}

/// Columns whose texts may look like numbers.
const NAMES: [&str; 2] = ["record", "pair"];

impl Cell {
    /// What stands below a heading: a name, or a number where it is one.
    fn below(heading: &str, text: &str) -> Self {
        if NAMES.contains(&heading) && !text.is_empty() {
            Self::Text(text.to_owned())
        } else {
            Self::of(text)
        }
    }
}

impl Grid {
    /// The columns `wanted` of the rows of `table` that `keep` wants; numbers are numbers.
    pub fn of(table: &Table, wanted: &[usize], keep: impl Fn(&[String]) -> bool) -> Self {
        let cell = |row: &[String], column: usize| Cell::below(&table.headings[column], &row[column]);
        let cells = |row: &Vec<String>| wanted.iter().map(|column| cell(row, *column)).collect();
        Self {
            headings: wanted.iter().map(|column| table.headings[*column].clone()).collect(),
            rows: table.rows.iter().filter(|row| keep(row)).map(cells).collect(),
        }
    }

    /// Without the columns `names` if all their cells are empty.
    pub fn without_empty(mut self, names: &[&str]) -> Self {
        for name in names {
            let Some(at) = self.headings.iter().position(|heading| heading == name) else { continue };
            if self.rows.iter().all(|row| row.get(at) == Some(&Cell::Empty)) {
                self.headings.remove(at);
                self.rows.iter_mut().for_each(|row| drop(row.remove(at)));
            }
        }
        self
    }

    /// As HTML; nothing without rows. A number stands below its heading.
    pub fn html(&self, class: &str) -> String {
        if self.rows.is_empty() {
            return String::new();
        }
        let mut text = format!("<div class=\"scroll\"><table class=\"{class}\"><thead><tr>");
        for (column, heading) in self.headings.iter().enumerate() {
            let number = |row: &Vec<Cell>| matches!(row.get(column), Some(Cell::Number(_) | Cell::Share(_)));
            let class = if self.rows.iter().any(number) { " class=\"number\"" } else { "" };
            // Writing to a string cannot fail.
            let _ = write!(text, "<th scope=\"col\"{class}>{}</th>", escape(heading));
        }
        text += "</tr></thead><tbody>\n";
        for row in &self.rows {
            let cells: String = row.iter().map(Cell::html).collect();
            let _ = writeln!(text, "<tr>{cells}</tr>");
        }
        text + "</tbody></table></div>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_left_out_only_if_they_are_empty() {
        let grid = Grid {
            headings: ["median", "low", "high"].map(str::to_owned).to_vec(),
            rows: vec![
                vec![Cell::Number(1.0), Cell::Empty, Cell::Empty],
                vec![Cell::Empty, Cell::Empty, Cell::Number(2.0)],
            ],
        };
        let found = grid.without_empty(&["low", "high"]);
        assert_eq!(found.headings, ["median", "high"]);
        assert_eq!(found.rows[1], [Cell::Empty, Cell::Number(2.0)]);
    }

    #[test]
    fn names_stay_as_they_are() {
        assert_eq!(Cell::below("record", "0012"), Cell::Text("0012".to_owned()));
        assert_eq!(Cell::below("pair", ""), Cell::Empty);
        assert_eq!(Cell::below("scale", "0012"), Cell::Number(12.0));
    }
}
