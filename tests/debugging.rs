//! docs/debugging.md is run: every command in its order, its exit status, and what it is said to print.

use std::path::Path;
use std::process::Command;
use whole_chain::python::interpreter;
use whole_chain::scenario::{binary, root};

/// Commands with the exit status that they state, and the lines quoted below them.
#[derive(Default)]
struct Block {
    commands: Vec<(String, i32)>,
    quoted: Vec<String>,
}

/// Whitespace and the frames of error messages carry no meaning.
fn words(text: &str) -> String {
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

fn blocks(document: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut fence = "";
    for line in document.lines() {
        match (line.strip_prefix("```"), fence) {
            (Some("bash"), "") => blocks.push(Block::default()),
            (Some(_), _) => {}
            (None, "bash") => {
                let (command, status) = line.split_once("   # exit status ").unwrap_or((line, "0"));
                let status = status.parse().unwrap_or_else(|e| panic!("{line}: {e}"));
                blocks.last_mut().expect("a block").commands.push((command.to_owned(), status));
            }
            (None, "text") => blocks.last_mut().expect("commands first").quoted.push(words(line)),
            (None, _) => {}
        }
        if let Some(language) = line.strip_prefix("```") {
            fence = language;
        }
    }
    blocks
}

/// Standard output, then standard error.
fn run(command: &str, status: i32, folder: &Path) -> String {
    let path = std::env::var("PATH").expect("a path");
    let [units, python] = [binary(), interpreter()].map(|file| file.parent().expect("a folder"));
    let output = Command::new("bash")
        .args(["-c", command])
        .env("PATH", format!("{}:{}:{path}", units.display(), python.display()))
        .current_dir(folder)
        .output()
        .unwrap_or_else(|e| panic!("{command}: {e}"));
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{command}\n{said}");
    words(&said)
}

/// **Panics** if a line is not found behind the one before; `…` stands for anything.
fn assert_quoted(quoted: &[String], said: &str) {
    let mut rest = said;
    for line in quoted {
        for part in line.split('…').map(str::trim).filter(|part| !part.is_empty()) {
            let at = rest.find(part).unwrap_or_else(|| panic!("`{part}` of `{line}` is not in\n{rest}"));
            rest = &rest[at + part.len()..];
        }
    }
}

#[test]
fn every_command_does_what_the_document_says() {
    let folder = tempfile::tempdir().expect("a folder");
    for linked in ["examples", "scenes"] {
        std::os::unix::fs::symlink(root().join(linked), folder.path().join(linked)).expect("a link");
    }
    let document = std::fs::read_to_string(root().join("docs/debugging.md")).expect("the document");
    let blocks = blocks(&document);
    let commands = blocks.iter().map(|block| block.commands.len()).sum::<usize>();
    assert!(commands >= 25, "{commands} commands were found");
    for Block { commands, quoted } in &blocks {
        assert!(!quoted.is_empty(), "{commands:?} lacks what it prints");
        let said: Vec<_> =
            commands.iter().map(|(command, status)| run(command, *status, folder.path())).collect();
        assert_quoted(quoted, &said.join(" "));
    }
    assert!(folder.path().join("growth.svg").is_file());
}
