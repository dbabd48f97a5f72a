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
        let digit = |c: char| c.is_ascii_digit();
        let around = text.split_at_checked(span.start);
        let decimal_comma = around.is_some_and(|(before, after)| {
            before.ends_with(digit) && after.strip_prefix(',').is_some_and(|after| after.starts_with(digit))
        });
        // Where a bracket is left open, the parser stumbles over the next statement only.
        let (message, remedy, span) = match (statement.contains(&at), error.message()) {
            (false, _) => {
                let end = lines[statement.end - 1].content_end();
                ("a bracket is left open", "close it", end..end)
            }
            (true, message @ "duplicate key") => (message, "leave one out", span),
            (true, _) if decimal_comma => ("a comma in a number", "write a decimal point, as in 91.75", span),
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
        let content = without_mark(text);
        // A quoted key, unlike a quoted value, has its `=` behind it.
        let begins =
            header.is_some() || begins_bare(content) || content.starts_with(QUOTES) && content.contains('=');
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
    let line = without_mark(line.split('#').next().unwrap_or(line)).trim_end();
    let name = line.trim_matches(['[', ']', ' ', '\t']);
    // A quoted name, unlike a row of texts, has no comma.
    let named = begins_bare(name) || name.starts_with(QUOTES) && !name.contains(',');
    let bracketed = line.starts_with('[') || line.ends_with(']') && name.chars().all(|c| bare(c) || c == '.');
    // Without its first bracket, it must look like nothing else.
    (named && bracketed && !line.contains('=')).then(|| words(name))
}

const QUOTES: [char; 2] = ['"', '\''];

/// The line from its first letter, and without the mark that some editors put before the first line.
fn without_mark(line: &str) -> &str {
    line.trim_start_matches('\u{feff}').trim_start()
}

fn begins_bare(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

fn bare(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-')
}

/// The words with dots between them that a line begins with, without their quotes.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = Some(without_mark(line));
    while let Some(text) = rest {
        let quoted = text.strip_prefix('"').and_then(|t| t.split_once('"'));
        let quoted = quoted.or_else(|| text.strip_prefix('\'')?.split_once('\''));
        // With a `=` inside, the first quote is left open.
        let quoted = quoted.filter(|(word, _)| !word.contains('='));
        let text = text.trim_start_matches(QUOTES);
        let (word, after) =
            quoted.unwrap_or_else(|| text.split_at(text.find(|c| !bare(c)).unwrap_or(text.len())));
        if !word.is_empty() {
            words.push(word.to_owned());
        }
        rest = after.trim_start().strip_prefix('.').map(str::trim_start);
    }
    words
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
    let key = |line: &Line| table.iter().cloned().chain(words(&line.text)).collect();
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
    fn quotes_and_a_byte_order_mark_are_no_part_of_a_key() {
        for (broken, path) in [
            ("\"d\" = 9 m", "a.d"),
            ("'d' = = 3", "a.d"),
            ("\"d\" 9", "a.d"),
            ("\"d = 9", "a.d"),
            ("d . \"e\" = 9 m", "a.d.e"),
            ("\"d\" = [[0, 1]", "a.d"),
            ("d = [[0, 1],\n[\"x\", \"y\"]", "a.d"),
        ] {
            let (kept, paths) = read(&format!("[\"a\"]\n{broken}\n\"c\" = 1\n"));
            assert_eq!((kept.as_str(), paths), ("[\"a\"]; \"c\" = 1", vec![path.to_owned()]), "{broken}");
        }
        for (source, path) in
            [("d 9\nc = 1\n", "d"), ("\"d\" = = 9\nc = 1\n", "d"), ("[a\nd = 9\n[b]\nc = 1\n", "a")]
        {
            let (kept, paths) = read(&format!("\u{feff}{source}"));
            assert!(kept.ends_with("c = 1") && paths == [path], "{source}: {kept}, {paths:?}");
        }
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
