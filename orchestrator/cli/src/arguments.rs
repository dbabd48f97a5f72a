//! The command line: all commands with their help.

use crate::{
    cache, check, ensemble, export_fmu, log, plan, points, replay, report, reservoir, run, shell, study,
    template, unit,
};
use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Seismic analysis of cracked concrete gravity dams with their reservoirs.
///
/// The reservoir (compressible water, boundary elements) and the dam (deformable blocks,
/// distinct elements) are two co-simulation units. Each communication step is repeated until
/// the pressure and the motion of the wet face agree, and every exchange is logged.
#[derive(Parser)]
// Help is wrapped by hand.
#[command(name = "cofferdam", version, arg_required_else_help = true, term_width = 0)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,

    /// Folder for prepared operators of the water; by default `cofferdam` in the user's folder for caches
    ///
    /// What was prepared once is read from there, and the bits are the same. `cofferdam cache` says what it holds.
    #[arg(long, global = true, hide_short_help = true, value_name = "DIR", env = "COFFERDAM_CACHE")]
    pub cache: Option<PathBuf>,

    /// Prepare anew, and keep nothing
    #[arg(long, global = true, hide_short_help = true)]
    pub no_cache: bool,
}

/// The subcommands.
#[derive(Subcommand)]
pub enum Command {
    /// Run a scene: crest motion, sliding, rotation, pressure; histories and a log of every exchange
    #[command(after_long_help = run::HELP)]
    Run(run::Arguments),
    /// Go on with a run that was interrupted; it ends as if it had not been, bit for bit
    #[command(after_long_help = run::resume::HELP)]
    Resume(run::resume::Arguments),
    /// Try a run otherwise from one of its steps on
    #[command(after_long_help = run::branch::HELP)]
    Branch(run::branch::Arguments),
    /// Write the report of a run, of two side by side, or of an ensemble: one HTML page
    #[command(after_long_help = report::HELP)]
    Report(report::Arguments),
    /// Check scenes without running them: every mistake at its line, and warnings about doubtful choices
    #[command(after_long_help = check::HELP)]
    Check(check::Arguments),
    /// Say what a run of a scene will model and what it leaves out, each by its number; expected errors, time and disk
    #[command(after_long_help = plan::HELP)]
    Plan(plan::Arguments),
    /// Repeat the requests in the log of a run with new units: are the answers equal, bit for bit?
    #[command(after_long_help = replay::HELP)]
    Replay(replay::Arguments),
    /// Pack a unit of a scene as an FMU (FMI 3.0), for other programs to simulate
    #[command(after_long_help = export_fmu::HELP)]
    ExportFmu(export_fmu::Arguments),
    /// Print the points of the wet face at which the units of a scene exchange
    #[command(after_long_help = points::HELP)]
    Points(points::Arguments),
    /// Write a folder from which to make a reservoir or a dam of your own: an FMU in C, or a process in Python
    #[command(subcommand)]
    Template(template::Command),
    /// Inspect and compare the logs of runs
    #[command(subcommand)]
    Log(log::Command),
    /// Response of the water alone: in the frequency domain, to an impulse, to a record, in the field
    #[command(subcommand)]
    Reservoir(reservoir::Command),
    /// Series of runs: how much the results depend on mesh, time steps and modelling choices
    #[command(subcommand)]
    Study(study::Command),
    /// Many runs of a scene: records, levels of shaking, parameters; medians, fragility, what the variance comes from
    #[command(after_long_help = ensemble::HELP)]
    Ensemble(ensemble::Arguments),
    /// The cache of prepared operators of the water: where it is, what it holds; clear it
    #[command(after_long_help = cache::HELP)]
    Cache(cache::Arguments),
    /// Print the completions of this command for a shell
    #[command(after_long_help = shell::COMPLETIONS_HELP)]
    Completions(shell::Completions),
    /// Write the manual pages, one for each command
    #[command(after_long_help = shell::MAN_HELP)]
    Man(shell::Man),
    /// Serve one of the units of a run; started by `run`
    #[command(hide = true, long_about = unit::HELP)]
    Unit(unit::Arguments),
}
