//! `cofferdam-lab`: studies that give the tables and figures of the documentation, and comparisons of builds.

mod accuracy;
mod ambient;
mod bench;
mod context;
mod fidelity;
mod figure;
mod ledger;
mod meshes;
mod paper;
mod resolution;
mod rest;
mod seek;
mod stability;
mod study;
mod terminal;
mod tolerance;
mod windows;

use clap::Parser;
use cofferdam_analysis::accuracy::AccuracyError;
use std::path::PathBuf;
use std::process::ExitCode;
use study::{Arguments, StudyError};
use terminal::warn;

/// As in `cofferdam`, so that times are those of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Studies of Cofferdam's accuracy, convergence and cost, for its developers.
#[derive(Parser)]
// Help is wrapped by hand.
#[command(name = "cofferdam-lab", version, arg_required_else_help = true, term_width = 0)]
struct Lab {
    /// What to do.
    #[command(subcommand)]
    command: Command,

    /// Folder for prepared operators of the water; by default `cofferdam` in the user's folder for caches
    #[arg(long, global = true, hide_short_help = true, value_name = "DIR", env = "COFFERDAM_CACHE")]
    cache: Option<PathBuf>,

    /// Prepare anew, and keep nothing
    #[arg(long, global = true, hide_short_help = true)]
    no_cache: bool,
}

/// The studies, and `bench`.
#[derive(clap::Subcommand)]
enum Command {
    /// Where each acceleration converges: densities, steps, meshes, water
    #[command(after_long_help = stability::HELP)]
    Stability(Arguments),
    /// Errors of all levels of numerics, and whether `run --accuracy` keeps what it promises
    #[command(after_long_help = accuracy::HELP)]
    Accuracy(accuracy::AccuracyArguments),
    /// Accuracy and cost of the tolerance
    #[command(after_long_help = tolerance::HELP)]
    Tolerance(Arguments),
    /// Accuracy and cost of the models of the water
    #[command(after_long_help = fidelity::HELP)]
    Fidelity(Arguments),
    /// How fine the elements of the wet face must be: errors against the closed form, and time
    #[command(after_long_help = resolution::HELP)]
    Resolution(Arguments),
    /// How the error of the energy balance falls with the time step
    #[command(after_long_help = ledger::HELP)]
    Ledger(Arguments),
    /// One crack in five meshes, beside what a little more or less shaking does
    #[command(after_long_help = meshes::HELP)]
    Meshes(Arguments),
    /// What the block does after the ground has stopped, beside what eigenvalues say
    #[command(after_long_help = rest::HELP)]
    Rest(Arguments),
    /// Whether energy drifts in minutes of ambient vibration
    #[command(after_long_help = ambient::HELP)]
    Ambient(Arguments),
    /// How fast a step is found in a long log
    #[command(after_long_help = seek::HELP)]
    Seek(seek::SeekArguments),
    /// The paper's figures from our runs, beside what its text states
    #[command(after_long_help = paper::HELP)]
    Paper(paper::PaperArguments),
    /// Errors of the paper's short windows and of its missing condition at the far end
    #[command(after_long_help = windows::HELP)]
    Windows(Arguments),
    /// Where the time of runs goes, beside another build of the program
    #[command(after_long_help = bench::HELP)]
    Bench(bench::Arguments),
}

fn main() -> ExitCode {
    // Options and paths in messages are not broken, so that they can be copied.
    let whole_words = miette::MietteHandlerOpts::new()
        .break_words(false)
        .word_separator(textwrap::WordSeparator::AsciiSpace)
        .word_splitter(textwrap::WordSplitter::NoHyphenation);
    // It fails only if a handler is set already.
    let _ = miette::set_hook(Box::new(move |_| Box::new(whole_words.clone().build())));
    cofferdam_assembly::build_info::set_commit(env!("COFFERDAM_COMMIT"));
    let Lab { command, cache, no_cache } = Lab::parse();
    context::use_cache(cache, !no_cache);
    let done = match &command {
        Command::Stability(arguments) => stability::run(arguments),
        Command::Accuracy(arguments) => accuracy::run(arguments),
        Command::Tolerance(arguments) => tolerance::run(arguments),
        Command::Ambient(arguments) => ambient::run(arguments),
        Command::Fidelity(arguments) => fidelity::run(arguments),
        Command::Resolution(arguments) => resolution::run(arguments),
        Command::Ledger(arguments) => ledger::run(arguments),
        Command::Meshes(arguments) => meshes::run(arguments),
        Command::Paper(arguments) => paper::run(arguments),
        Command::Rest(arguments) => rest::run(arguments),
        Command::Seek(arguments) => seek::run(arguments),
        Command::Windows(arguments) => windows::run(arguments),
        Command::Bench(arguments) => return bench::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match &error {
                StudyError::Scene(_) | StudyError::Unfit { .. } | StudyError::Record { .. } => 2,
                StudyError::Run { .. } => 3,
                StudyError::Accuracy(AccuracyError::Scene(_) | AccuracyError::Unfit { .. }) => 2,
                StudyError::Accuracy(AccuracyError::Run { .. }) => 3,
                StudyError::Accuracy(AccuracyError::Unit(_)) => 4,
                StudyError::Unit(_) => 4,
                StudyError::File { .. } | StudyError::OutputTaken { .. } => 1,
            };
            warn(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}
