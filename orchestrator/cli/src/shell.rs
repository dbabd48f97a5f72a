//! `cofferdam completions` and `man`: for the shell, from the definitions of the commands themselves.

use crate::terminal::{print, warn};
use clap_complete::Shell;
use std::path::PathBuf;
use std::process::ExitCode;

pub const COMPLETIONS_HELP: &str = "\
Examples:
  cofferdam completions bash \\
    > ~/.local/share/bash-completion/completions/cofferdam
  cofferdam completions fish > ~/.config/fish/completions/cofferdam.fish
      The Tab key completes commands and options in the next shell.";

pub const MAN_HELP: &str = "\
Writes cofferdam.1 for the program and one page for each of its commands, such
as cofferdam-run.1. Existing files are replaced.

Example:
  cofferdam man ~/.local/share/man/man1
      `man cofferdam-run` then shows the same text as `cofferdam run --help`.

Exit status: 0 written, 1 a file cannot be written.";

/// Arguments of `cofferdam completions`.
#[derive(clap::Args)]
pub struct Completions {
    /// Shell
    shell: Shell,
}

/// Arguments of `cofferdam man`.
#[derive(clap::Args)]
pub struct Man {
    /// Folder for the pages; created if necessary
    folder: PathBuf,
}

/// Prints completions.
pub fn completions(arguments: &Completions, mut whole: clap::Command) -> ExitCode {
    let mut script = Vec::new();
    let name = whole.get_name().to_owned();
    clap_complete::generate(arguments.shell, &mut whole, name, &mut script);
    print(String::from_utf8_lossy(&script).trim_end());
    ExitCode::SUCCESS
}

/// Writes the manual.
pub fn man(arguments: &Man, whole: clap::Command) -> ExitCode {
    let Man { folder } = arguments;
    let written = std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(whole, folder));
    match written {
        Ok(()) => {
            print(format!("wrote {}", folder.join("cofferdam.1").display()));
            ExitCode::SUCCESS
        }
        Err(cause) => {
            warn(format!("{}: {cause}; choose another folder", folder.display()));
            ExitCode::FAILURE
        }
    }
}
