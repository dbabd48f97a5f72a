//! `cofferdam`: couples a reservoir and a cracked dam under an earthquake.

mod cli;
mod registry;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli::Arguments { command } = cli::Arguments::parse();
    match command {
        cli::Command::Run(arguments) => cli::run::run(&arguments),
    }
}
