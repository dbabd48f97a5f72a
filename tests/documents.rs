//! Every command that a document shows is one that the program takes: its name, its options and their values.

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
        } else if name.ends_with(".md") && name != "CHANGELOG.md" && name != "extended.md" {
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
