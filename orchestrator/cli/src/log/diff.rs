//! `cofferdam log diff`.

use super::{Failure, agreement};
use crate::terminal::print;
use cofferdam_log::{Agreement, Comparison, Log, compare};
use std::path::PathBuf;

/// Arguments of `cofferdam log diff`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    a: PathBuf,
    /// Log to compare with
    b: PathBuf,
    /// Compare the accepted values at the ends of steps, with this relative tolerance
    #[arg(short, long, value_name = "SHARE", value_parser = share)]
    tolerance: Option<f64>,
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number, such as 1e-6".to_owned())?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("must be between 0 and 1".to_owned()) }
}

pub const HELP: &str = "\
Lists different settings first. Wall times, the version of the program and
messages of the units are not compared.

Without --tolerance, the exchanges are compared in order, requests and
responses, every value bit for bit, up to the first difference.

With --tolerance, the accepted values are compared at each end of a step that
both runs have in common, whatever their steps and iterations: all responses,
and those requests that are not responses of another unit, such as
ground_acceleration. This allows runs to be compared that differ in the
coupling, in open or closed loop, or in the variables of their units. The
difference of a variable is the largest absolute difference over all points of
an array, relative to the largest magnitude of the variable in both runs
(energy_balance_error: relative to input_work). The output has these sections:

  beyond     the first step in which a variable exceeds the tolerance
  growth     where the largest relative difference so far reaches each power of
             ten, and its largest growth in one step
  variables  the largest difference of each variable
  parted     the first step with another length, with other iterations or
             convergence, or with other numbers of sticking, slipping or open
             contacts, and the difference of the runs before that step: whether
             rounding differences grew, or an event separated the runs

Examples:
  cofferdam log diff runs/before runs/after
  cofferdam log diff runs/iqn-ils runs/aitken --tolerance 1e-6

Exit status: 0 the exchanges are identical, or the accepted values are within
the tolerance; 1 a log cannot be read up to the first difference, with
--tolerance to its end; 5 they differ, or there is nothing in common to
compare.";

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
        (None, [Some(a), None]) => {
            format!("a is shorter ({a}): {identical} identical exchanges, b continues")
        }
        (None, [None, Some(b)]) => {
            format!("b is shorter ({b}): {identical} identical exchanges, a continues")
        }
        (None, [None, None]) => format!("{identical} identical exchanges before the damage"),
    }
}
