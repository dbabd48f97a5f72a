//! What of a text is TOML: statements that are none are set aside, one after the other.

use std::ops::Range;
use toml::de::DeTable;

/// Beyond so many mistakes a text is taken for something else.
const MOST_DAMAGES: usize = 20;

/// A statement that is no TOML.
#[derive(Debug)]
pub struct Damage {
    /// What the parser said.
    pub message: String,
    /// How it would be right.
    pub remedy: &'static str,
    /// Where.
    pub span: Range<usize>,
    /// The key that the statement was to give, or the table and then its keys, as far as that can be told.
    pub paths: Vec<Vec<String>>,
}

/// The text with every statement that is no TOML blanked, places unchanged, and what was wrong with those.
/// `None` if the text is no scene at all.
///
/// The parser's own recovery would give up the rest of the file after some mistakes.
pub fn readable(source: &str) -> (Option<String>, Vec<Damage>) {
    let mut lines = lines(source);
    let mut damages = Vec::new();
    loop {
        let text: String = lines.iter().map(|line| line.text.as_str()).collect();
        let Err(error) = DeTable::parse(&text) else { return (Some(text), damages) };
        let span = error.span().unwrap_or(0..0);
        let at = match error.message().contains("multi-line") {
            // The parser stumbles over the end of the file.
            true => lines.iter().rposition(|line| line.text.contains("\"\"\"") || line.text.contains("'''")),
            false => lines.iter().rposition(|line| line.start <= span.start),
        };
        let at = at.unwrap_or(0);
        let statement = statement(&lines, at);
        let paths = paths(&lines, &statement);
        let header = lines[statement.start].header.is_some();
        // Where a bracket is left open, the parser stumbles over the next statement only.
        let (message, remedy, span) = match (statement.contains(&at), error.message()) {
            (false, _) => {
                let end = lines[statement.end - 1].content_end();
                ("a bracket is left open", "close it", end..end)
            }
            (true, message @ "duplicate key") => (message, "leave one out", span),
            (true, message) if header => {
                (message, "write `[table]`, or `[[table]]` for one of several", span)
            }
            (true, message) => (
                message,
                "write `key = value`, numbers such as 91.75 without a unit, text in \"quotes\"",
                span,
            ),
        };
        let damage = Damage { message: message.to_owned(), remedy, span, paths };
        damages.push(damage);
        let blank = lines[statement.clone()].iter().all(|line| line.text.trim().is_empty());
        if blank || damages.len() == MOST_DAMAGES {
            return (None, damages);
        }
        for line in &mut lines[statement] {
            line.blank();
        }
    }
}

/// A line with its end, and where it starts.
struct Line {
    start: usize,
    text: String,
    header: Option<Vec<String>>,
    begins: bool,
}

impl Line {
    fn blank(&mut self) {
        self.text = self
            .text
            .chars()
            .map(|c| if c == '\n' { "\n".to_owned() } else { " ".repeat(c.len_utf8()) })
            .collect();
    }

    fn content_end(&self) -> usize {
        self.start + self.text.trim_end().len()
    }
}

fn lines(source: &str) -> Vec<Line> {
    let mut start = 0;
    let line = |text: &str| {
        let header = header(text);
        let first = text.trim_start().chars().next();
        let begins = header.is_some() || first.is_some_and(|c| c.is_alphabetic() || c == '_');
        let line = Line { start, text: text.to_owned(), header, begins };
        start += text.len();
        line
    };
    let mut lines: Vec<Line> = source.split_inclusive('\n').map(line).collect();
    if lines.is_empty() {
        lines.push(Line { start: 0, text: String::new(), header: None, begins: false });
    }
    lines
}

/// The path that a table's header names, however its brackets are.
fn header(line: &str) -> Option<Vec<String>> {
    let line = line.split('#').next().unwrap_or(line).trim();
    let name = line.trim_matches(['[', ']', ' ', '\t']);
    let named = name.starts_with(|c: char| c.is_alphabetic() || c == '_') && !line.contains('=');
    // Without its first bracket, it must look like nothing else.
    (named && (line.starts_with('[') || line.ends_with(']') && name.chars().all(bare))).then(|| words(name))
}

fn bare(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-' | '.')
}

fn words(name: &str) -> Vec<String> {
    let name = name.split(|c| !bare(c)).next().unwrap_or("");
    name.split('.').filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// The lines of the statement over which the parser stumbled in line `at`; of a header, its whole table.
fn statement(lines: &[Line], at: usize) -> Range<usize> {
    let begun = lines[..at].iter().rposition(|line| line.begins && !line.text.trim().is_empty());
    let begin = begun.filter(|begun| left_open(&lines[*begun..at])).unwrap_or(at);
    let header = lines[begin].header.is_some();
    let after =
        lines[begin + 1..].iter().position(|line| if header { line.header.is_some() } else { line.begins });
    let end = after.map_or(lines.len(), |after| begin + 1 + after);
    // A statement of one line ends there: what follows up to the next is comment, or its own mistake.
    match header || left_open(&lines[begin..=begin]) {
        true => begin..end,
        false => begin..begin + 1,
    }
}

fn left_open(lines: &[Line]) -> bool {
    let text = lines.iter().flat_map(|line| line.text.split('#').next().unwrap_or("").chars());
    let depth = text.map(|c| match c {
        '[' | '{' => 1,
        ']' | '}' => -1,
        _ => 0,
    });
    depth.sum::<i32>() > 0
}

/// What the statement in these lines was to give.
fn paths(lines: &[Line], statement: &Range<usize>) -> Vec<Vec<String>> {
    let table =
        lines[..=statement.start].iter().rev().find_map(|line| line.header.clone()).unwrap_or_default();
    let key = |line: &Line| table.iter().cloned().chain(words(line.text.trim_start())).collect();
    match lines[statement.start].header {
        None => vec![key(&lines[statement.start])],
        Some(_) => {
            let keys = lines[statement.clone()].iter().skip(1).filter(|line| line.begins).map(key);
            std::iter::once(table.clone()).chain(keys).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::readable;

    /// The source without the statements set aside, and the paths of those.
    fn read(source: &str) -> (String, Vec<String>) {
        let (text, damages) = readable(source);
        let text = text.unwrap_or_default();
        assert_eq!(text.len(), source.len());
        let kept: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        (kept.join("; "), damages.into_iter().map(|d| d.paths[0].join(".")).collect())
    }

    #[test]
    fn a_broken_statement_is_set_aside_and_the_next_is_read() {
        for broken in [
            "d = = 3",
            "d = 91,75",
            "d 91.75",
            "d",
            "d = 9 m",
            "d =",
            "d = a",
            "d = \"a",
            "d = [[0, 1]",
            "d = {b = 1",
        ] {
            let (kept, paths) = read(&format!("[a]\n{broken}\nc = 1\n[b]\nx = 2\n"));
            assert_eq!(
                (kept.as_str(), paths),
                ("[a]; c = 1; [b]; x = 2", vec!["a.d".to_owned()]),
                "{broken}"
            );
        }
        let (kept, paths) = read("[a]\nd = [\n[0, 1]\n[2, 3]\n]\nc = 1\n");
        assert_eq!((kept.as_str(), paths), ("[a]; c = 1", vec!["a.d".to_owned()]));
        let (kept, paths) = read("[a]\nd = 1\n// comment\nc = 1\nd = 2\n");
        assert_eq!((kept.as_str(), paths), ("[a]; d = 1; c = 1", vec!["a".to_owned(), "a.d".to_owned()]));
    }

    #[test]
    fn a_broken_header_takes_its_table_along() {
        for broken in ["[a.b", "[[a.b]", "a.b]", "[[a.b]]]", "[c]"] {
            let (kept, paths) = read(&format!("[c]\nd = 1\n{broken}\nd = 2\n\n[e]\n"));
            assert_eq!(kept, "[c]; d = 1; [e]", "{broken}");
            assert_eq!(paths.len(), 1, "{broken}");
        }
    }
}
