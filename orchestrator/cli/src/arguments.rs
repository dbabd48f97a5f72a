//! The command line: all commands with their help.

use crate::{
    cache, check, ensemble, export_fmu, export_ssp, fmu_input, log, plan, points, range, replay, report,
    reservoir, run, shell, stability, template, unit,
};
use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Seismic analysis of cracked concrete gravity dams with their reservoirs
///
/// The reservoir (compressible water, boundary elements) and the dam (deformable blocks, distinct
/// elements) are two co-simulation units. Every communication step is iterated until the pressure and
/// the motion of the wet face have converged. Every exchange is logged.
#[derive(Parser)]
// Help is wrapped by hand.
#[command(name = "cofferdam", version, arg_required_else_help = true, term_width = 0)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,

    /// Folder of the cache of prepared water operators (default: `cofferdam` in the user's cache folder)
    ///
    /// An operator that was prepared before is read from the cache; results are bit-identical. `cofferdam
    /// cache` shows the contents.
    #[arg(long, global = true, hide_short_help = true, value_name = "DIR", env = "COFFERDAM_CACHE")]
    pub cache: Option<PathBuf>,

    /// Prepare the water operators again; neither read nor write the cache
    #[arg(long, global = true, hide_short_help = true)]
    pub no_cache: bool,
}

/// The subcommands.
#[derive(Subcommand)]
pub enum Command {
    /// Run a scene: write results, histories, a report and a log of every exchange
    #[command(after_long_help = run::HELP)]
    Run(run::Arguments),
    /// Resume an interrupted run; results are bit-identical to an uninterrupted run
    #[command(after_long_help = run::resume::HELP)]
    Resume(run::resume::Arguments),
    /// Branch off a run at one of its steps, with changed settings
    #[command(after_long_help = run::branch::HELP)]
    Branch(run::branch::Arguments),
    /// Write the HTML report of a run, of two runs compared, or of an ensemble
    #[command(after_long_help = report::HELP)]
    Report(report::Arguments),
    /// Check scenes without running them: errors with their lines, warnings about doubtful choices
    #[command(after_long_help = check::HELP)]
    Check(check::Arguments),
    /// Print factors of safety of every joint for each load combination, beside those an authority requires
    #[command(after_long_help = stability::HELP)]
    Stability(stability::Arguments),
    /// Show what a run will model and neglect, with numerical errors, run time and disk space
    #[command(after_long_help = plan::HELP)]
    Plan(plan::Arguments),
    /// Replay the requests in the log of a run and compare the responses bit for bit
    #[command(after_long_help = replay::HELP)]
    Replay(replay::Arguments),
    /// Export a unit of a scene as an FMU (FMI 2.0 or 3.0) for other programs
    #[command(after_long_help = export_fmu::HELP)]
    ExportFmu(export_fmu::Arguments),
    /// Export dam and water as an SSP archive for importers that do not iterate
    #[command(after_long_help = export_ssp::HELP)]
    ExportSsp(export_ssp::Arguments),
    /// Print the ground motion of a scene as an input table for FMUs in FMPy
    #[command(after_long_help = fmu_input::HELP)]
    FmuInput(fmu_input::Arguments),
    /// Print the interface points of a unit on the wet face
    #[command(after_long_help = points::HELP)]
    Points(points::Arguments),
    /// Create a template for a unit of your own: an FMU in C or a process in Python
    #[command(subcommand)]
    Template(template::Command),
    /// Inspect, export and compare the logs of runs
    #[command(subcommand)]
    Log(log::Command),
    /// Compute the response of the reservoir alone, with a rigid dam
    #[command(subcommand)]
    Reservoir(reservoir::Command),
    /// Compute the range of the results over models, numerics and motion, and what dominates it
    #[command(after_long_help = range::HELP)]
    Range(range::Arguments),
    /// Run an ensemble of records, intensities and parameters; compute fragility and variance shares
    #[command(after_long_help = ensemble::HELP)]
    Ensemble(ensemble::Arguments),
    /// Show or clear the cache of prepared water operators
    #[command(after_long_help = cache::HELP)]
    Cache(cache::Arguments),
    /// Print the completion script for a shell
    #[command(after_long_help = shell::COMPLETIONS_HELP)]
    Completions(shell::Completions),
    /// Write the manual pages, one per command
    #[command(after_long_help = shell::MAN_HELP)]
    Man(shell::Man),
    /// Serve one of the units of a run; started by `run`
    #[command(hide = true, long_about = unit::HELP)]
    Unit(unit::Arguments),
}
