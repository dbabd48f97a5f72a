//! `cofferdam log diff`.

use super::{Failure, agreement};
use crate::terminal::print;
use cofferdam_log::{Agreement, Comparison, Log, compare};
use std::path::PathBuf;

/// Arguments of `cofferdam log diff`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The log.mcap of a run, or the run's folder
    a: PathBuf,
    /// The other log
    b: PathBuf,
    /// Compare what was accepted at the ends of steps, and allow this relative difference
    #[arg(short, long, value_name = "SHARE", value_parser = share)]
    tolerance: Option<f64>,
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "a number is wanted, such as 1e-6".to_owned())?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("it must lie from 0 to 1".to_owned()) }
}

pub const HELP: &str = "\
Different settings are listed first. Wall times, the version of the program and messages of the units are not compared.

Without --tolerance, exchanges are compared in their order, requests and answers, every value bit for bit, up to the
first difference.

With it, what was accepted at each end of a step that both runs have is compared, whatever their steps and iterations
were: answers, and of requests what no unit answers, such as ground_acceleration. So runs with other couplings, in open
and closed loop, or with units that have other variables can be compared. The difference of a variable is its largest
absolute one over all points of an array, relative to the largest magnitude of the variable in both runs
(energy_balance_error: of input_work). Shown are

  beyond     the first step in which a variable differs by more than the tolerance
  growth     where the largest relative difference so far enters each power of ten, and its largest growth in one step
  variables  the largest difference of each variable
  parted     the first step of another length, with other iterations or convergence, with other numbers of sticking,
             slipping or open contacts, and how far apart the runs were before: a difference of the last digits that
             grew, or an event that parted them

Examples:
  cofferdam log diff runs/before runs/after
  cofferdam log diff runs/iqn-ils runs/aitken --tolerance 1e-6

Exit status: 0 the exchanges are identical, or the accepted values within the tolerance; 1 a log cannot be read to the first
difference, with --tolerance to its end; 5 they differ, or there is nothing in common to compare.";

/// Compares; true if the logs are equal in what is compared.
pub fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let logs = [Log::of_exchanges(&arguments.a)?, Log::of_exchanges(&arguments.b)?];
    for (name, log) in ["a", "b"].into_iter().zip(&logs) {
        print(format!("{name}: {}", log.path().display()));
    }
    match arguments.tolerance {
        None => bit_for_bit(logs.each_ref()),
        Some(tolerance) => within(logs.each_ref(), tolerance),
    }
}

fn within(logs: [&Log; 2], tolerance: f64) -> Result<bool, Failure> {
    let agreement = Agreement::of(logs)?;
    print(agreement::report(&agreement, tolerance));
    let within = agreement::within(&agreement, tolerance);
    agreement.error.map_or(Ok(within), |error| Err(error.into()))
}

fn bit_for_bit(logs: [&Log; 2]) -> Result<bool, Failure> {
    let comparison = compare(logs)?;
    for setting in &comparison.settings {
        print(format!("  {setting}"));
    }
    print(verdict(&comparison));
    let identical = comparison.identical();
    comparison.error.map_or(Ok(identical), |error| Err(error.into()))
}

pub fn verdict(comparison: &Comparison) -> String {
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
