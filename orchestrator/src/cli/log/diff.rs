//! `cofferdam log diff`.

use super::Failure;
use crate::cli::say;
use orchestrator::log::{Comparison, Log, compare};
use std::path::PathBuf;

/// Arguments of `cofferdam log diff`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    a: PathBuf,
    /// The other log
    b: PathBuf,
}

pub const HELP: &str = "\
Exchanges are compared in their order, requests and answers, every value bit for bit. Different settings
are listed first. Wall times, the version of the program and messages of the units are not compared.

Example:
  cofferdam log diff runs/before runs/after

Exit status: 0 the exchanges are identical, 1 a log cannot be read to the first difference, 5 the exchanges differ.";

/// Compares; true if the logs are equal in what is compared.
pub fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let logs = [Log::open(&arguments.a)?, Log::open(&arguments.b)?];
    for (name, log) in ["a", "b"].into_iter().zip(&logs) {
        say(format!("{name}: {}", log.path().display()));
    }
    bit_for_bit(logs.each_ref())
}

fn bit_for_bit(logs: [&Log; 2]) -> Result<bool, Failure> {
    let comparison = compare(logs)?;
    for setting in &comparison.settings {
        say(format!("  {setting}"));
    }
    say(verdict(&comparison));
    let identical = comparison.identical();
    comparison.error.map_or(Ok(identical), |error| Err(error.into()))
}

fn verdict(comparison: &Comparison) -> String {
    let Comparison { identical, endings, divergence, .. } = comparison;
    match (divergence, endings) {
        (Some(divergence), _) => divergence.report(["a", "b"]).to_string(),
        (None, [Some(a), Some(b)]) if [a, b] == ["completed"; 2] => {
            format!("identical: {identical} exchanges")
        }
        (None, [Some(a), Some(b)]) => format!("identical: {identical} exchanges; a: {a}; b: {b}"),
        (None, [Some(a), None]) => format!("a is shorter ({a}): {identical} identical exchanges, b goes on"),
        (None, [None, Some(b)]) => format!("b is shorter ({b}): {identical} identical exchanges, a goes on"),
        (None, [None, None]) => format!("{identical} identical exchanges before the damage"),
    }
}
