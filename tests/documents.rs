//! Every command that a document shows is one that the program takes: its name, its options and their values. Every link leads
//! to a file and a heading, the book has every page, and the English is that of docs/developer/style.md.

use std::path::{Path, PathBuf};
use std::process::Command;
use whole_chain::document::command_lines;
use whole_chain::scenario::{binary, root};

/// How the program is called in the documents.
const CALLED: [&str; 3] = ["cofferdam ", "target/release/cofferdam ", "cargo run --release -- "];

/// The Markdown files of the project that speak of today.
fn documents(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && !name.starts_with('.') && name != "target" && name != "decisions" {
            documents(&path, found);
        } else if name.ends_with(".md") && name != "CHANGELOG.md" {
            found.push(path);
        }
    }
}

/// The arguments of a call, up to where the shell's business begins; a word in capitals stands for a number or a name.
fn arguments(call: &str) -> Vec<String> {
    let (mut words, mut quote) = (vec![String::new()], None);
    for letter in call.chars() {
        match (letter, quote) {
            ('\'' | '"', None) => quote = Some(letter),
            (_, Some(begun)) if letter == begun => quote = None,
            (' ', None) => words.push(String::new()),
            _ => words.last_mut().expect("a word").push(letter),
        }
    }
    let of_shell = |word: &String| {
        ["#", "|", ">", "&&", "2>/dev/null"].contains(&word.as_str()) || word.starts_with('>')
    };
    let own = words.into_iter().filter(|word| !word.is_empty()).take_while(|word| !of_shell(word));
    let stands_for =
        |word: String| if word.chars().all(|c| c.is_ascii_uppercase()) { "1".to_owned() } else { word };
    own.map(|word| stands_for(word.trim_end_matches(';').to_owned())).collect()
}

#[test]
fn the_program_takes_every_command_of_the_documents() {
    let mut files = Vec::new();
    documents(&root(), &mut files);
    let mut taken = 0;
    let mut refused = Vec::new();
    for file in &files {
        let text = std::fs::read_to_string(file).expect("a document");
        for line in command_lines(&text) {
            let Some(call) = CALLED.iter().find_map(|called| line.strip_prefix(called)) else { continue };
            let arguments = arguments(call);
            // Of a choice, of what may be left out, or of a drawing, no one command can be made.
            let is_open = |word: &String| word.contains(['|', '[', '<']) && !word.contains('=');
            if call.contains('→') || arguments.iter().any(|word| is_open(word) || word == "…") {
                continue;
            }
            // All before `--help` is looked at, and nothing is done.
            let done =
                Command::new(binary()).args(&arguments).arg("--help").output().expect("cofferdam runs");
            taken += 1;
            if !done.status.success() {
                let said = String::from_utf8_lossy(&done.stderr);
                refused.push(format!("{}: {line}\n{}", file.display(), said.lines().next().unwrap_or("")));
            }
        }
    }
    assert!(taken >= 150, "{taken} commands were found");
    assert!(refused.is_empty(), "{}", refused.join("\n"));
    println!("{taken} commands");
}

/// A text without its fenced blocks.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let outside = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fence && !fenced
    });
    outside.collect::<Vec<_>>().join("\n")
}

/// The anchors of a document's headings, as GitHub makes them.
fn anchors(text: &str) -> Vec<String> {
    let headings = prose(text);
    let headings = headings.lines().filter_map(|line| line.strip_prefix('#'));
    let anchor = |heading: &str| -> String {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// The targets of a document's links: a path, empty for the document itself, and an anchor, if there is one.
fn links(text: &str) -> Vec<(String, Option<String>)> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    let inside = targets.filter(|target| !target.contains("://") && !target.contains(' '));
    inside
        .map(|target| match target.split_once('#') {
            Some((path, anchor)) => (path.to_owned(), Some(anchor.to_owned())),
            None => (target.to_owned(), None),
        })
        .collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut files = Vec::new();
    documents(&root(), &mut files);
    documents(&root().join("docs/decisions"), &mut files);
    files.push(root().join("CHANGELOG.md"));
    let (mut followed, mut dead) = (0, Vec::new());
    for file in &files {
        let text = std::fs::read_to_string(file).expect("a document");
        for (path, anchor) in links(&text) {
            let target = if path.is_empty() { file.clone() } else { file.with_file_name("").join(&path) };
            followed += 1;
            let there = match &anchor {
                None => target.exists(),
                Some(anchor) => {
                    std::fs::read_to_string(&target).is_ok_and(|text| anchors(&text).contains(anchor))
                }
            };
            if !there {
                dead.push(format!("{}: {path}#{}", file.display(), anchor.unwrap_or_default()));
            }
        }
    }
    assert!(followed > 200, "{followed} links were found");
    assert!(dead.is_empty(), "{} dead links\n{}", dead.len(), dead.join("\n"));
}

#[test]
fn the_book_has_every_page() {
    let mut pages = Vec::new();
    documents(&root().join("docs"), &mut pages);
    documents(&root().join("docs/decisions"), &mut pages);
    let summary = root().join("docs/SUMMARY.md");
    let listed = links(&std::fs::read_to_string(&summary).expect("a summary"));
    let listed: Vec<PathBuf> = listed.iter().map(|(path, _)| root().join("docs").join(path)).collect();
    let missing: Vec<_> = pages.iter().filter(|page| **page != summary && !listed.contains(page)).collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md lacks {missing:?}");
}

#[test]
fn measured_blocks_name_date_commit_and_machine() {
    let mut pages = Vec::new();
    documents(&root().join("docs/measurements"), &mut pages);
    let mut measured = 0;
    for page in pages {
        let text = std::fs::read_to_string(&page).expect("a page");
        for block in text.split("```measure\n").skip(1) {
            let (block, _) = block.split_once("<!-- end of measurement -->").expect("the end of a block");
            let (command, body) = block.split_once("```").expect("a fence");
            let stamp = body.trim().lines().last().unwrap_or_default();
            let parts = ["Measured on 20", ", commit ", " cores), in "];
            assert!(parts.iter().all(|part| stamp.contains(part)), "{}: {command}: {stamp}", page.display());
            assert!(!stamp.contains("-dirty") && !stamp.contains("unknown"), "{}: {stamp}", page.display());
            assert!(body.contains("| --- |"), "{}: no table below {command}", page.display());
            measured += 1;
        }
    }
    assert!(measured >= 10, "{measured} measured blocks");
}

/// Phrases of the style guide's table, and what to write instead.
const PHRASES: [(&str, &str); 22] = [
    ("in the place of", "instead of"),
    ("anew", "again"),
    ("goes on", "continues"),
    ("go on with", "continue"),
    ("in the mean", "on average"),
    ("half again", "50 % more"),
    ("is no error", "is ignored, or: is not an error"),
    ("no whole", "not an integer"),
    ("what is not known exactly", "uncertain parameters"),
    ("smells of", "suggests"),
    ("hopeless", "stagnation"),
    ("shakes itself", "self-excited vibration"),
    ("shake themselves", "self-excited vibration"),
    ("answers an earthquake", "responds to an earthquake"),
    ("answer an earthquake", "respond to an earthquake"),
    ("with second order", "at second order"),
    ("with first order", "at first order"),
    ("another draw", "another realisation"),
    ("one draw", "one realisation"),
    ("a quiet hour", "the machine and the number of runs"),
    ("are the most", "the limit is"),
    ("is the least", "the minimum is"),
];

/// Where a phrase may stand, and why.
const ALLOWED: [(&str, &str); 1] = [("docs/developer/style.md", "lists them")];

#[test]
fn users_read_idiomatic_english() {
    let mut files = Vec::new();
    documents(&root(), &mut files);
    for entry in std::fs::read_dir(root().join("tests/snapshots")).expect("snapshots") {
        files.push(entry.expect("an entry").path());
    }
    let allowed = |file: &Path| ALLOWED.iter().any(|(allowed, _)| file.ends_with(allowed));
    let texts = files.iter().filter(|file| !allowed(file));
    let texts =
        texts.map(|file| (file.display().to_string(), std::fs::read_to_string(file).expect("a text")));
    let mut found = Vec::new();
    for (name, text) in texts {
        for (line, words) in text.lines().enumerate() {
            let words = format!(" {} ", words.to_lowercase());
            let letter = |c: Option<char>| c.is_some_and(char::is_alphabetic);
            for (phrase, instead) in PHRASES {
                let whole = words.match_indices(phrase).any(|(at, _)| {
                    let (before, after) = (&words[..at], &words[at + phrase.len()..]);
                    !letter(before.chars().next_back()) && !letter(after.chars().next())
                });
                if whole {
                    found.push(format!("{name}:{}: \"{phrase}\"; write: {instead}", line + 1));
                }
            }
        }
    }
    assert!(found.is_empty(), "{} phrases of docs/developer/style.md\n{}", found.len(), found.join("\n"));
}
