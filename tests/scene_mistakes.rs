//! One mistake, one problem: every key of the shipped scenes, made wrong in every way.

use cofferdam_scene::{Invalid, Scene};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::collections::BTreeSet;
use whole_chain::scene_text::{Desk, shipped};

const CASES: [&str; 4] = ["koyna-coarse", "koyna-intact", "rigid-dam-ramp", "koyna-tailwater"];

/// A line of a shipped scene, all of whose statements are lines.
enum Line<'a> {
    Header { brackets: &'a str, path: Vec<&'a str> },
    Key { key: &'a str, value: &'a str },
    Other,
}

fn parsed(line: &str) -> Line<'_> {
    let content = line.split('#').next().unwrap_or("").trim();
    if content.starts_with('[') {
        let brackets = if content.starts_with("[[") { "[[" } else { "[" };
        return Line::Header { brackets, path: content.trim_matches(['[', ']']).split('.').collect() };
    }
    match content.split_once(" = ") {
        Some((key, value)) => Line::Key { key, value },
        None => Line::Other,
    }
}

/// The scene with line `index` replaced.
fn with_line(text: &str, index: usize, line: &str) -> String {
    let lines = text.lines().enumerate().map(|(i, old)| if i == index { line } else { old });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// Line `index` and those up to the next header.
fn without_table(text: &str, index: usize) -> String {
    let header = |line: &str| matches!(parsed(line), Line::Header { .. });
    let after = text.lines().skip(index + 1).position(header).map_or(usize::MAX, |after| index + 1 + after);
    let lines = text.lines().enumerate().filter(|(i, _)| !(index..after).contains(i));
    lines.map(|(_, line)| format!("{line}\n")).collect()
}

/// The kinds of the problems of this text.
fn problems(desk: &Desk, text: &str, set: &[&str]) -> Vec<Invalid> {
    let error = desk.read(text, set).err();
    error.map_or_else(Vec::new, |e| e.problems.into_iter().map(|p| p.invalid).collect())
}

/// Applies `mistake` to every line of every shipped scene; whatever it gives must be `expected`.
fn sweep(mistake: fn(&str, usize) -> Vec<String>, expected: fn(&[Invalid], &str) -> bool) {
    let desk = Desk::default();
    let mut tried = 0;
    for case in CASES {
        let text = shipped(case);
        for index in 0..text.lines().count() {
            for wrong in mistake(&text, index) {
                let found = problems(&desk, &wrong, &[]);
                let line = text.lines().nth(index).unwrap_or("");
                assert!(expected(&found, &wrong), "{case}, `{line}`: {found:#?}\n{wrong}");
                tried += 1;
            }
        }
    }
    println!("{tried} mistakes");
    assert!(tried > 20, "{tried} mistakes");
}

/// The value of every key replaced by these.
fn with_values(text: &str, index: usize, values: &[&str]) -> Vec<String> {
    match text.lines().nth(index).map(parsed) {
        Some(Line::Key { key, .. }) => {
            values.iter().map(|value| with_line(text, index, &format!("{key} = {value}"))).collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn a_misspelt_key_is_one_problem_that_names_the_right_one() {
    // Two letters exchanged, one left out, one doubled.
    let slips = |word: &str| {
        let (first, rest) = word.split_at(1);
        [
            format!("{first}{}{}{}", &rest[1..2], &rest[0..1], &rest[2..]),
            format!("{first}{}", &rest[1..]),
            format!("{first}{first}{rest}"),
        ]
    };
    let desk = Desk::default();
    for case in CASES {
        let text = shipped(case);
        for (index, line) in text.lines().enumerate() {
            let (words, wrap): (Vec<&str>, _) = match parsed(line) {
                Line::Header { brackets, path } => (path, Some(brackets)),
                Line::Key { key, .. } => (vec![key], None),
                Line::Other => continue,
            };
            for (part, word) in words.iter().enumerate() {
                for slip in slips(word) {
                    let mut wrong = words.clone();
                    wrong[part] = &slip;
                    let new = match wrap {
                        Some("[") => format!("[{}]", wrong.join(".")),
                        Some(_) => format!("[[{}]]", wrong.join(".")),
                        None => line.replacen(word, &slip, 1),
                    };
                    let found = problems(&desk, &with_line(&text, index, &new), &[]);
                    let named = matches!(&found[..], [Invalid::Misspelt { key, meant, .. }] if *key == slip && meant == word);
                    assert!(slip == *word || named, "{case}, `{new}`: {found:#?}");
                }
            }
        }
    }
}

#[test]
fn a_missing_key_is_at_most_one_problem() {
    let without = |text: &str, index: usize| match text.lines().nth(index).map(parsed) {
        Some(Line::Key { .. }) => vec![with_line(text, index, "")],
        Some(Line::Header { .. }) => vec![without_table(text, index)],
        _ => Vec::new(),
    };
    sweep(without, |found, text| match toml::from_str::<Scene>(text) {
        Err(_) => matches!(found, [Invalid::Missing { .. }]),
        Ok(_) => found.len() <= 1,
    });
}

#[test]
fn a_wrong_type_is_one_problem() {
    let wrong = |text: &str, index: usize| with_values(text, index, &["true", "{}", "2024-01-01", "[true]"]);
    sweep(wrong, |found, _| matches!(found, [Invalid::Type { .. }]));
}

#[test]
fn an_absurd_number_is_at_most_one_problem() {
    let wrong = |text: &str, index: usize| {
        with_values(text, index, &["nan", "-1e9", "0", "1e308", "1e-310", "inf", "7"])
    };
    sweep(wrong, |found, _| found.len() <= 1);
    let nan = |text: &str, index: usize| with_values(text, index, &["nan"]);
    sweep(nan, |found, _| found.len() == 1);
}

#[test]
fn a_number_that_no_run_can_take_is_one_problem() {
    let desk = Desk::default();
    for (case, set) in [
        (CASES[0], "time.duration=1e308"),
        (CASES[0], "time.duration=1e-12"),
        (CASES[0], "time.communication_step=1e-310"),
        (CASES[0], "dam.element_size=1e-200"),
        (CASES[0], "dam.cracks.0.elevation=1e-310"),
        (CASES[0], "reservoir.element_size=1e-310"),
        (CASES[0], "reservoir.depth=1e-300"),
        (CASES[0], "ground_motion.record.scale=1e308"),
        (CASES[0], "ground_motion.record.scale=1e5"),
        (CASES[2], "reservoir.depth=1e300"),
        (CASES[2], "reservoir.depth=1e-300"),
        (CASES[2], "time.duration=1e-12"),
        (CASES[2], "time.duration=1e308"),
        (CASES[2], "ground_motion.ramp.rise=1e-310"),
    ] {
        let found = problems(&desk, &shipped(case), &[set]);
        assert_eq!(found.len(), 1, "{case}, {set}: {found:#?}");
        let said = found[0].to_string();
        assert!(said.len() < 200, "{case}, {set}: {said}");
    }
}

#[test]
fn a_statement_that_is_no_toml_is_one_problem() {
    let broken = |text: &str, index: usize| match text.lines().nth(index).map(parsed) {
        Some(Line::Key { key, value }) => {
            let lines = ["= 1", "", "1,5", "5 m", "word", "\"open", "[[0, 1]", "[1]]", "0.1.2"];
            let mut lines: Vec<String> = lines.iter().map(|wrong| format!("{key} = {wrong}")).collect();
            lines.extend([format!("{key} {value}"), key.to_owned(), format!("{key}: {value}")]);
            lines.extend([
                format!("\"{key}\" = = 1"),
                format!("'{key}' {value}"),
                format!("\"{key} = {value}"),
            ]);
            lines.extend([
                format!("{key} = {value}\n{key} = {value}"),
                format!("// comment\n{key} = {value}"),
            ]);
            let mark = if index == 0 { "\u{feff}" } else { "" };
            lines.iter().map(|line| with_line(text, index, &format!("{mark}{line}"))).collect()
        }
        Some(Line::Header { brackets, path }) => {
            let path = path.join(".");
            let closed = if brackets == "[" { "]" } else { "]]" };
            let lines = [
                format!("{brackets}{path}"),
                format!("{path}{closed}"),
                format!("{brackets}{path}{closed}]"),
            ];
            lines.iter().map(|line| with_line(text, index, line)).collect()
        }
        _ => Vec::new(),
    };
    sweep(broken, |found, _| matches!(found, [Invalid::Syntax { .. }]));
}

#[test]
fn a_key_in_a_wrong_table_is_one_problem() {
    let moved = |text: &str, index: usize| match text.lines().nth(index).map(parsed) {
        // The keys above all tables stand there already.
        Some(Line::Key { key, value }) if text.lines().take(index).any(|line| line.starts_with('[')) => {
            vec![format!("{key} = {value}\n{}", with_line(text, index, ""))]
        }
        _ => Vec::new(),
    };
    sweep(moved, |found, _| matches!(found, [Invalid::Misplaced { .. }]));
}

#[test]
fn a_wrong_override_is_one_problem() {
    let desk = Desk::default();
    for case in CASES {
        let text = shipped(case);
        let mut paths = BTreeSet::new();
        let mut table = String::new();
        for line in text.lines() {
            match parsed(line) {
                Line::Header { brackets, path } => {
                    let parts = (1..=path.len()).map(|parts| path[..parts].join("."));
                    paths.extend(parts);
                    table = path.join(".") + if brackets == "[" { "." } else { ".0." };
                }
                Line::Key { key, .. } => drop(paths.insert(format!("{table}{key}"))),
                Line::Other => (),
            }
        }
        for path in paths {
            for value in ["true", "{x = 1}", "[true]", "a word"] {
                let set = format!("{path}={value}");
                let found = problems(&desk, &text, &[&set]);
                let fits = value == "a word" && (path == "title" || path.ends_with(".file"));
                assert!(found.len() <= 1 || value == "{x = 1}", "{case}, {set}: {found:#?}");
                assert!(fits || !found.is_empty(), "{case}, {set}");
            }
            let slip = format!("{path}e=1");
            let found = problems(&desk, &text, &[&slip]);
            let named = matches!(&found[..], [Invalid::Misspelt { .. }]);
            assert!(named, "{case}, {slip}: {found:#?}");
        }
    }
}

#[test]
fn no_text_makes_it_panic() {
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), any::<bool>()), 0..6);
    let set = r#"(dam|time|title|reservoir\.depth)?[a-z.0-9 é\[\]{}"]{0,8}=?[a-z.0-9, é\[\]{}"=]{0,8}"#;
    let desk = Desk::default();
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) };
    let run = TestRunner::new(config).run(&(changes, set), |(changes, set)| {
        let mut bytes = shipped(CASES[0]).into_bytes();
        for (index, byte, printable) in changes {
            let index = index.index(bytes.len());
            bytes[index] = if printable { b"[]{}=\"'#.,-\n 09ae"[usize::from(byte) % 17] } else { byte };
        }
        match desk.read(&bytes, &[&set]) {
            Ok(loaded) => loaded.warnings.iter().for_each(|warning| drop(desk.shown(warning))),
            Err(error) => error.problems.iter().for_each(|problem| drop(desk.shown(problem))),
        }
        Ok(())
    });
    run.expect("no panic");
}
