//! `cofferdam log`.

mod agreement;
mod bisect;
mod contacts;
pub mod diff;
mod error;
mod export;
mod info;
mod layout;
mod messages;
mod plot;
mod recover;
mod show;
mod worst;

use crate::terminal::{DIFFERENT, warn};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_log::Log;
use error::Failure;
use std::process::ExitCode;

/// The commands for logs.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Show the contents of a log and how its run ended
    #[command(after_long_help = info::HELP)]
    Info(info::Arguments),
    /// List the messages of the units
    #[command(after_long_help = messages::HELP)]
    Messages(messages::Arguments),
    /// Show one step: all iterations with the requests and responses of the units, and how it ended
    #[command(after_long_help = show::HELP)]
    Show(show::Arguments),
    /// Plot time histories as SVG
    #[command(after_long_help = plot::HELP)]
    Plot(plot::Arguments),
    /// Export the values in a log as CSV or Parquet tables
    #[command(after_long_help = export::HELP)]
    Export(export::Arguments),
    /// Write a plot layout for Foxglove or PlotJuggler
    #[command(after_long_help = layout::HELP)]
    Layout(layout::Arguments),
    /// List the communication steps with the most iterations
    #[command(after_long_help = worst::HELP)]
    Worst(worst::Arguments),
    /// Find when the outcome became inevitable, by perturbed reruns from checkpoints
    #[command(after_long_help = bisect::HELP)]
    Bisect(bisect::Arguments),
    /// Recover the intact parts of a damaged or truncated log
    #[command(after_long_help = recover::HELP)]
    Recover(recover::Arguments),
    /// Compare two logs: bit for bit, or by how much and from when on the runs differ
    #[command(after_long_help = diff::HELP)]
    Diff(diff::Arguments),
}

/// Runs the command; reports the result on the terminal and by the exit status.
pub fn run(command: &Command) -> ExitCode {
    let done = match command {
        Command::Info(arguments) => info::run(arguments).map(|()| true),
        Command::Messages(arguments) => messages::run(arguments).map(|()| true),
        Command::Show(arguments) => show::run(arguments).map(|()| true),
        Command::Plot(arguments) => plot::run(arguments).map(|()| true),
        Command::Export(arguments) => export::run(arguments).map(|()| true),
        Command::Layout(arguments) => layout::run(arguments).map(|()| true),
        Command::Worst(arguments) => worst::run(arguments).map(|()| true),
        Command::Bisect(arguments) => bisect::run(arguments).map(|()| true),
        Command::Recover(arguments) => recover::run(arguments).map(|()| true),
        Command::Diff(arguments) => diff::run(arguments),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(DIFFERENT),
        Err(failure) => {
            let status = failure.exit_status();
            warn(format!("{:?}", miette::Report::msg(failure)));
            ExitCode::from(status)
        }
    }
}

/// The unit `name` of a log.
///
/// **Errors**: there is none of this name.
fn unit_named(log: &Log, name: &str) -> Result<UnitId, Failure> {
    let units = &log.head().units;
    units.iter().position(|unit| unit.name == name).map(UnitId).ok_or_else(|| Failure::Unit {
        path: log.path().to_owned(),
        unit: name.to_owned(),
        known: units.iter().map(|unit| unit.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}
