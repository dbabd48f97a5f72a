//! `cofferdam-lab measure`: writes the measured blocks of pages.

use crate::terminal::{print, warn};
use cofferdam_assembly::build_info::Build;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

/// Arguments of `cofferdam-lab measure`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Pages with measured blocks
    #[arg(required = true, value_name = "PAGE")]
    pages: Vec<PathBuf>,

    /// Run only commands that contain this text
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,

    /// Also run commands whose block was written by this commit
    #[arg(long)]
    again: bool,
}

pub const HELP: &str = "\
Runs the commands of the measured blocks of Markdown pages and writes their
tables into the blocks, with date, commit, machine and duration. A measured
block is a fenced block with the language `measure` that holds one command of
cofferdam-lab or cofferdam without --output, and everything below it up to the
line `<!-- end of measurement -->`. A figure of the study replaces the file in
`figures` next to the page's folder if there is one of that name.

The page is written after each block; blocks that this commit has written are
skipped, so that an interrupted command continues. Run it in the folder in
which the commands hold.

Examples:
  cofferdam-lab measure docs/measurements/*.md
      Hours on two cores.
  cofferdam-lab measure docs/measurements/tradeoff.md --only variants

Exit status: 0 completed, 1 a page or a command failed.";

const FENCE: &str = "```";
const OPENING: &str = "```measure\n";
const STAMP: &str = "Measured on ";
const END: &str = "<!-- end of measurement -->";

/// A measured block by the bytes of its page.
struct Block {
    command: Vec<String>,
    /// From below the fence to the line of the end.
    body: std::ops::Range<usize>,
}

pub fn run(arguments: &Arguments) -> ExitCode {
    match arguments.pages.iter().try_for_each(|page| write(page, arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            warn(why);
            ExitCode::FAILURE
        }
    }
}

/// Writes the blocks of a page one after the other.
fn write(page: &Path, arguments: &Arguments) -> Result<(), String> {
    let failed = |why: &dyn std::fmt::Display| format!("{}: {why}", page.display());
    let read = || std::fs::read_to_string(page).map_err(|error| failed(&error));
    let text = read()?;
    let build = Build::here();
    for Block { command, body } in blocks(&text).map_err(|why| failed(&why))? {
        let line = command.join(" ");
        let stamp = text[body].trim_end().lines().last().unwrap_or_default();
        let is_current =
            build.commit != "unknown" && stamp.starts_with(STAMP) && stamp.contains(&of_commit(&build));
        if !line.contains(&arguments.only) || (is_current && !arguments.again) {
            continue;
        }
        print(format!("{}: {line}", page.display()));
        let measured = measure(&command, page, &build).map_err(|why| failed(&format!("`{line}`: {why}")))?;
        // Somebody may have edited the page while the command ran.
        let mut now = read()?;
        let all = blocks(&now).map_err(|why| failed(&why))?;
        let Some(block) = all.into_iter().find(|block| block.command == command) else {
            return Err(failed(&format!("it no longer has the block of `{line}`; run the command again")));
        };
        now.replace_range(block.body, &measured);
        let draft = page.with_extension("md.part");
        let written = std::fs::write(&draft, now).and_then(|()| std::fs::rename(&draft, page));
        written.map_err(|error| failed(&error))?;
    }
    Ok(())
}

/// How a stamp names the commit.
fn of_commit(build: &Build) -> String {
    format!(", commit {}, ", build.commit)
}

/// The measured blocks of a page.
fn blocks(text: &str) -> Result<Vec<Block>, String> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(opening) = text[at..].find(OPENING).map(|offset| at + offset) {
        let line = text[..opening].lines().count() + 1;
        let from = opening + OPENING.len();
        let fence = text[from..].find(FENCE).map(|offset| from + offset);
        let fence =
            fence.ok_or_else(|| format!("the block of line {line} is not closed; end it with {FENCE}"))?;
        let body = fence + FENCE.len();
        let end = text[body..].find(END).map(|offset| body + offset);
        let end =
            end.ok_or_else(|| format!("the block of line {line} lacks the line `{END}`; add it below"))?;
        if text[body..end].contains(OPENING) {
            return Err(format!("the block of line {line} lacks the line `{END}` before the next block"));
        }
        let command =
            words(&text[from..fence]).ok_or_else(|| format!("line {line}: a quote is not closed"))?;
        if command.first().is_none_or(|program| !["cofferdam", "cofferdam-lab"].contains(&program.as_str())) {
            return Err(format!("line {line}: expected a command of cofferdam-lab or cofferdam"));
        }
        found.push(Block { command, body: body..end });
        at = end;
    }
    Ok(found)
}

/// The words of a command as a shell separates them: quotes and continued lines. `None` if a quote is open.
fn words(command: &str) -> Option<Vec<String>> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for letter in command.replace("\\\n", " ").chars() {
        match (letter, quote) {
            (_, Some(begun)) if letter == begun => quote = None,
            ('\'' | '"', None) => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (_, None) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    quote.is_none().then_some(words)
}

/// Runs a command; its table and how it was measured.
fn measure(command: &[String], page: &Path, build: &Build) -> Result<String, String> {
    let [program, arguments @ ..] = command else { return Err("there is no command".to_owned()) };
    let program = std::env::current_exe().map_err(|error| error.to_string())?.with_file_name(program);
    let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    let output = folder.path().join("study");
    let began = Instant::now();
    // What follows `--` is passed on by the command.
    let own = arguments.iter().position(|word| word == "--").unwrap_or(arguments.len());
    let (own, passed_on) = arguments.split_at(own);
    let done = Command::new(&program).args(own).arg("--output").arg(&output).args(passed_on).output();
    let done = done.map_err(|error| format!("{}: {error}", program.display()))?;
    if !done.status.success() {
        return Err(format!("{}\n{}", done.status, String::from_utf8_lossy(&done.stderr)));
    }
    let minutes = began.elapsed().as_secs_f64() / 60.0;
    let mut tables = Vec::new();
    for entry in std::fs::read_dir(&output).map_err(|error| error.to_string())? {
        let path = entry.map_err(|error| error.to_string())?.path();
        let (Some(name), Some(kind)) = (path.file_name(), path.extension()) else { continue };
        let figure = page.with_file_name("").join("../figures").join(name);
        if kind == "md" {
            tables.push(std::fs::read_to_string(&path).map_err(|error| error.to_string())?);
        } else if kind == "svg" && figure.is_file() {
            std::fs::copy(&path, &figure).map_err(|error| format!("{}: {error}", figure.display()))?;
        }
    }
    let [table] = &tables[..] else {
        return Err(format!("it wrote {} tables (*.md); expected one", tables.len()));
    };
    Ok(format!(
        "\n\n{}\n\n{STAMP}{:.10}{}{} ({} cores), in {minutes:.1} min.\n\n",
        table.trim(),
        jiff::Timestamp::now().to_string(),
        of_commit(build),
        build.processor,
        build.cores
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# Page\n\n```measure\ncofferdam-lab rest a \\\n  --set 'b = c d'\n```\nold\n<!-- end of measurement -->\nafter\n";

    #[test]
    fn block_holds_the_words_of_its_command_and_all_down_to_its_end() {
        let found = blocks(PAGE).expect("blocks");
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].command, ["cofferdam-lab", "rest", "a", "--set", "b = c d"]);
        assert_eq!(&PAGE[found[0].body.clone()], "\nold\n");
    }

    #[test]
    fn malformed_blocks_are_refused_by_line() {
        let refusal = |text: &str| blocks(text).err().expect("a refusal");
        assert_eq!(
            refusal(&PAGE.replace("<!-- end of measurement -->", "")),
            "the block of line 3 lacks the line `<!-- end of measurement -->`; add it below"
        );
        assert!(refusal(&PAGE.replace("c d'", "c d")).contains("line 3: a quote is not closed"));
        assert!(
            refusal(&PAGE.replace("cofferdam-lab", "rm")).contains("expected a command of cofferdam-lab")
        );
        assert!(refusal("```measure\ncofferdam-lab").contains("is not closed"));
        let two = PAGE.replace("<!-- end of measurement -->", "") + PAGE;
        assert!(refusal(&two).contains("before the next block"));
    }

    #[test]
    fn page_without_blocks_has_none() {
        assert!(blocks("```\ncofferdam run\n```\n").expect("blocks").is_empty());
    }
}
