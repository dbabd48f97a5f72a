//! docs/reference/cli.md is what the command says of itself.

use std::process::Command;
use whole_chain::generated;
use whole_chain::scenario::binary;

/// The `--help` of a command, 80 columns wide.
pub fn help(command: &[String]) -> String {
    let mut called = Command::new(binary());
    called.args(command).arg("--help").env("COLUMNS", "80").env_remove("COFFERDAM_CACHE");
    let done = called.output().expect("cofferdam runs");
    assert!(done.status.success(), "{command:?}: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).expect("UTF-8")
}

/// All commands below `parent`, itself included, by their arguments.
pub fn commands(parent: &[String]) -> Vec<Vec<String>> {
    let text = help(parent);
    let listed =
        text.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    let below = names.flat_map(|name| commands(&[parent, &[name.to_owned()]].concat()));
    std::iter::once(parent.to_vec()).chain(below).collect()
}

#[test]
fn the_reference_of_the_command_line_is_its_help() {
    let mut text = "# The command line\n\nWritten from `cofferdam … --help` by `INSTA_UPDATE=always cargo test --release -p \
                    whole-chain cli_reference::`.\n"
        .to_owned();
    let all = commands(&[]);
    assert!(all.len() > 30, "{} commands", all.len());
    for command in all {
        let name =
            std::iter::once("cofferdam".to_owned()).chain(command.clone()).collect::<Vec<_>>().join(" ");
        let help = help(&command);
        let lines: Vec<&str> = help.trim().lines().map(str::trim_end).collect();
        text += &format!("\n## `{name}`\n\n```text\n{}\n```\n", lines.join("\n"));
    }
    generated::whole("docs/reference/cli.md", &text);
}
