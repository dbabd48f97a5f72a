//! Documents that are run: commands in their order, exit statuses, files that they show, what is said to be printed.
//!
//! | block | what is done |
//! |---|---|
//! | `bash` | each line is run, `\` at its end continues in the next; it ends with status 0, or as `   # exit status N` says |
//! | `text`, behind it | its lines stand in this order in what those commands print |
//! | any other, behind a line that ends with `` `PATH`: `` | it is written to that file; with "Add to" before, to its end |
//!
//! Whitespace and the frames of messages do not count, nor how lines are wrapped. `…` stands for up to a line's length of anything. All else that is
//! fenced is refused.

use crate::python::interpreter;
use crate::scenario::{binary, root};
use std::path::{Component, Path};
use std::process::Command;

/// Longest text for which `…` stands: that of a terminal's line.
const LEFT_OUT: usize = 100;
const STATUS: &str = "   # exit status ";

/// What a document asks its reader to do.
#[derive(Debug, PartialEq)]
enum Step {
    /// Write a file, or add to its end.
    File { path: String, add: bool, text: String },
    /// Type commands, which end with these exit statuses and print these lines.
    Commands { commands: Vec<(String, i32)>, quoted: Vec<String> },
}

/// A document's steps, or those of a part of it.
#[derive(Debug)]
pub struct Document(Vec<Step>);

/// The sections of `file`, a path within the project, by their titles; what comes before the first has none.
///
/// **Panics** as [`Document::read`].
pub fn sections(file: &str) -> Vec<(String, Document)> {
    let text = text(file);
    let mut sections = vec![(String::new(), String::new())];
    let mut is_fenced = false;
    for line in text.lines() {
        is_fenced ^= line.starts_with("```");
        match line.strip_prefix("## ") {
            Some(title) if !is_fenced => sections.push((title.to_owned(), String::new())),
            _ => sections.last_mut().expect("the one begun").1 += &format!("{line}\n"),
        }
    }
    sections.into_iter().map(|(title, text)| (title, parsed(file, &text))).collect()
}

/// Lines of all fenced blocks of a text, with those that `\` continues, and what stands between single backticks elsewhere.
pub fn command_lines(text: &str) -> Vec<String> {
    let (mut found, mut paragraph) = (Vec::new(), String::new());
    // Every second part is fenced; it begins with the name of its language.
    for (number, part) in text.split("```").enumerate() {
        if number % 2 == 1 {
            found.extend(part.replace(" \\\n", " ").lines().skip(1).map(|line| line.trim().to_owned()));
            continue;
        }
        for line in part.lines().chain([""]) {
            if line.trim().is_empty() || line.starts_with('|') {
                paragraph.push_str(line);
                found.extend(paragraph.split('`').skip(1).step_by(2).map(words));
                paragraph.clear();
            } else {
                paragraph += &format!("{line} ");
            }
        }
    }
    found
}

/// The text of a file of the project.
pub fn text(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

fn parsed(file: &str, text: &str) -> Document {
    Document::parse(text).unwrap_or_else(|mistake| panic!("{file}: {mistake}"))
}

impl Document {
    /// Reads `file`, a path within the project.
    ///
    /// **Panics** if a fenced block is of no known kind.
    pub fn read(file: &str) -> Self {
        parsed(file, &text(file))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let mut steps = Vec::new();
        let (mut said, mut lines) = ("", text.lines());
        while let Some(line) = lines.next() {
            let Some(language) = line.trim_start().strip_prefix("```") else {
                if !line.trim().is_empty() {
                    said = line;
                }
                continue;
            };
            let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            match (language, named(said), steps.last_mut()) {
                _ if line.starts_with(' ') => return Err(format!("`{line}` is indented")),
                ("bash", _, _) => {
                    let commands = commands(&body)?;
                    steps.push(Step::Commands { commands, quoted: Vec::new() });
                }
                ("text", _, Some(Step::Commands { quoted, .. }))
                    if quoted.is_empty() && said == "```bash" =>
                {
                    quoted.extend(body.iter().map(|line| words(line)));
                }
                ("" | "text", _, _) => {
                    return Err(format!("a block of `{language}` behind `{said}`: it is run by nobody"));
                }
                (_, Some((path, add)), _) => {
                    steps.push(Step::File { path, add, text: body.join("\n") + "\n" });
                }
                _ => {
                    return Err(format!(
                        "a block of `{language}` behind `{said}`: it is run by nobody, and no file"
                    ));
                }
            }
            said = line;
        }
        Ok(Self(steps))
    }

    /// Does all that the document says in `folder`; commands that are `provided` are taken as done.
    ///
    /// **Panics** if a command ends otherwise or does not print what is quoted.
    pub fn run(&self, folder: &Path, provided: &[&str]) {
        for step in &self.0 {
            match step {
                Step::File { path, add, text } => write(&folder.join(path), *add, text),
                Step::Commands { commands, quoted } => {
                    let own: Vec<_> =
                        commands.iter().filter(|(line, _)| !provided.contains(&&**line)).collect();
                    assert!(own.is_empty() || !quoted.is_empty(), "{commands:?} lacks what it prints");
                    let said: Vec<String> =
                        own.iter().map(|(command, status)| run(command, *status, folder)).collect();
                    if let Err(missing) = found(quoted, &said.join(" ")) {
                        panic!("{commands:?}\n{missing}");
                    }
                }
            }
        }
    }

    /// Number of commands.
    pub fn commands(&self) -> usize {
        let count = |step: &Step| match step {
            Step::Commands { commands, .. } => commands.len(),
            Step::File { .. } => 0,
        };
        self.0.iter().map(count).sum()
    }
}

/// The file that a line before a block names, and whether the block is added to it.
fn named(line: &str) -> Option<(String, bool)> {
    let (before, path) = line.trim_end().strip_suffix("`:")?.rsplit_once('`')?;
    let is_within = Path::new(path).components().all(|part| matches!(part, Component::Normal(_)));
    (is_within && !path.is_empty()).then(|| (path.to_owned(), before.ends_with("Add to ")))
}

/// The commands of a block with their exit statuses.
fn commands(body: &[&str]) -> Result<Vec<(String, i32)>, String> {
    let whole = body.join("\n").replace(" \\\n  ", " ");
    let mut commands = Vec::new();
    for line in whole.lines() {
        let (command, status) = line.split_once(STATUS).unwrap_or((line, "0"));
        let status = status.parse().map_err(|e| format!("{line}: {e}"))?;
        commands.push((command.to_owned(), status));
    }
    if commands.is_empty() { Err("a block without commands".to_owned()) } else { Ok(commands) }
}

fn write(path: &Path, add: bool, text: &str) {
    let folder = path.parent().expect("a folder");
    std::fs::create_dir_all(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let before = if add { std::fs::read_to_string(path) } else { Ok(String::new()) };
    let before = before.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    std::fs::write(path, before + text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

/// Whitespace and the frames of error messages carry no meaning.
fn words(text: &str) -> String {
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// Standard output, then standard error.
fn run(command: &str, status: i32, folder: &Path) -> String {
    let path = std::env::var("PATH").expect("a path");
    let [units, python] = [binary(), interpreter()].map(|file| file.parent().expect("a folder"));
    let output = Command::new("bash")
        .args(["-c", command])
        .env("PATH", format!("{}:{}:{path}", units.display(), python.display()))
        // The same bits, in a fraction of the time.
        .env("COFFERDAM_TRANSPORT", "in-process")
        .current_dir(folder)
        .output()
        .unwrap_or_else(|e| panic!("{command}: {e}"));
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{command}\n{said}");
    words(&said)
}

/// Whether each line stands as whole words behind the one before; otherwise what is missing.
fn found(quoted: &[String], said: &str) -> Result<(), String> {
    let mut rest = said;
    for line in quoted.iter().filter(|line| *line != "…" && !line.is_empty()) {
        rest = behind(line, rest).ok_or_else(|| format!("`{line}` is not in\n{rest}"))?;
    }
    Ok(())
}

/// What of `said` comes behind the first place where `line` stands.
fn behind<'a>(line: &str, said: &'a str) -> Option<&'a str> {
    let (first, further) = line.split_once('…').map_or((line, None), |(first, rest)| (first, Some(rest)));
    let further: Vec<&str> = further.into_iter().flat_map(|rest| rest.split('…')).collect();
    said.match_indices(first.trim_end()).find_map(|(start, begun)| {
        if !(first.is_empty() || start == 0 || said[..start].ends_with(' ')) {
            return None;
        }
        // A blank before `…` is left to what comes behind it: `…` may stand for nothing.
        let mut rest = &said[start + begun.len()..];
        for part in &further {
            let gap = rest.find(part.trim_end())?;
            if rest[..gap].chars().count() > LEFT_OUT {
                return None;
            }
            rest = &rest[gap + part.trim_end().len()..];
        }
        (line.ends_with('…') || ends_here(rest)).then_some(rest)
    })
}

/// Whether no word continues at the beginning of `rest`.
fn ends_here(rest: &str) -> bool {
    let rest = rest.strip_prefix([',', ';', ':', '.']).unwrap_or(rest);
    rest.is_empty() || rest.starts_with(' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_unknown_kinds_are_refused() {
        for text in [
            "```\nls\n```",
            "```console\nls\n```",
            "```toml\na = 1\n```",
            "```text\nout\n```",
            "  ```bash\n  ls\n  ```",
        ] {
            assert!(Document::parse(text).is_err(), "{text}");
        }
        for path in ["/etc/a", "../a", ""] {
            assert!(Document::parse(&format!("`{path}`:\n```toml\na = 1\n```")).is_err(), "{path}");
        }
        // What is printed stands right behind the commands, once.
        assert!(Document::parse("```bash\nls\n```\nIt prints\n```text\nout\n```").is_err());
        assert!(Document::parse("```bash\nls\n```\n```text\na\n```\n```text\nb\n```").is_err());
        assert!(Document::parse("```bash\nls   # exit status two\n```").is_err());
    }

    #[test]
    fn steps_come_in_their_order() {
        let text = "Write `a/b.toml`:\n\n```toml\na = 1\n```\n\nAdd to `a/b.toml`:\n```toml\nb = 2\n```\n\
                    ```bash\nls a \\\n  b   # exit status 2\ncat a\n```\n```text\nx  y\n```\n";
        let file = |add, text: &str| Step::File { path: "a/b.toml".to_owned(), add, text: text.to_owned() };
        let commands = vec![("ls a b".to_owned(), 2), ("cat a".to_owned(), 0)];
        let quoted = vec!["x y".to_owned()];
        let steps = [file(false, "a = 1\n"), file(true, "b = 2\n"), Step::Commands { commands, quoted }];
        assert_eq!(Document::parse(text).expect("a document").0, steps);
    }

    #[test]
    fn quoted_lines_are_whole_words_in_their_order() {
        let said = "crest 57.1 mm at 4.2 s sliding 209 mm";
        let holds =
            |lines: &[&str]| found(&lines.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>(), said);
        for lines in [
            &["crest 57.1 mm", "…", "sliding 209 mm"][..],
            &["crest … mm at …"],
            &["cre… 57.… mm"],
            &["… 209 mm"],
        ] {
            assert_eq!(holds(lines), Ok(()), "{lines:?}");
        }
        for lines in [
            &["crest 57"][..],
            &["rest 57.1"],
            &["sliding 209 mm", "crest 57.1 mm"],
            &["crest … cm"],
            &["57.1 … 57.1"],
        ] {
            assert!(holds(lines).is_err(), "{lines:?}");
        }
        let far = format!("begin {} end", "x ".repeat(LEFT_OUT));
        assert!(found(&["begin … end".to_owned()], &far).is_err());
    }
}
