//! `cofferdam-lab`: studies that give the tables and figures of the documentation, and comparisons of builds.

mod accuracy;
mod ambient;
mod bench;
mod context;
mod fidelity;
mod figure;
mod ledger;
mod measure;
mod meshes;
mod paper;
mod resolution;
mod rest;
mod seek;
mod stability;
mod study;
mod terminal;
mod tolerance;
mod variants;
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

/// Studies of Cofferdam's accuracy, convergence and cost, for its developers
#[derive(Parser)]
// Help is wrapped by hand.
#[command(name = "cofferdam-lab", version, arg_required_else_help = true, term_width = 0)]
struct Lab {
    /// What to do.
    #[command(subcommand)]
    command: Command,

    /// Folder of the cache of prepared water operators (default: `cofferdam` in the user's cache folder)
    #[arg(long, global = true, hide_short_help = true, value_name = "DIR", env = "COFFERDAM_CACHE")]
    cache: Option<PathBuf>,

    /// Prepare the water operators again; neither read nor write the cache
    #[arg(long, global = true, hide_short_help = true)]
    no_cache: bool,
}

/// The studies, and `bench`.
#[derive(clap::Subcommand)]
enum Command {
    /// Map where each acceleration converges: densities, steps, meshes, water
    #[command(after_long_help = stability::HELP)]
    Stability(Arguments),
    /// Measure the errors of all levels of numerics, and check the results of `run --accuracy`
    #[command(after_long_help = accuracy::HELP)]
    Accuracy(accuracy::AccuracyArguments),
    /// Measure accuracy and cost over the tolerance
    #[command(after_long_help = tolerance::HELP)]
    Tolerance(Arguments),
    /// Compare accuracy and cost of the models of the water
    #[command(after_long_help = fidelity::HELP)]
    Fidelity(Arguments),
    /// Measure the errors of the wet-face elements against the closed form, and their cost
    #[command(after_long_help = resolution::HELP)]
    Resolution(Arguments),
    /// Measure how the error of the energy balance decreases with the time step
    #[command(after_long_help = ledger::HELP)]
    Ledger(Arguments),
    /// Compare one crack in five meshes with the effect of slightly different shaking
    #[command(after_long_help = meshes::HELP)]
    Meshes(Arguments),
    /// Compare the motion of the block after the earthquake with the eigenvalue analysis
    #[command(after_long_help = rest::HELP)]
    Rest(Arguments),
    /// Check for drift of energy in minutes of ambient vibration
    #[command(after_long_help = ambient::HELP)]
    Ambient(Arguments),
    /// Measure the time to find a step in a long log
    #[command(after_long_help = seek::HELP)]
    Seek(seek::SeekArguments),
    /// Reproduce the paper's figures and compare with the statements in its text
    #[command(after_long_help = paper::HELP)]
    Paper(paper::PaperArguments),
    /// Measure the errors of the paper's short windows and of its missing far-end condition
    #[command(after_long_help = windows::HELP)]
    Windows(Arguments),
    /// Compare a scene with changes of its keys, one run each
    #[command(after_long_help = variants::HELP)]
    Variants(variants::VariantArguments),
    /// Run the commands of measured blocks of pages and write their tables there
    #[command(after_long_help = measure::HELP)]
    Measure(measure::Arguments),
    /// Measure where the time of runs goes, compared with another build
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
        Command::Variants(arguments) => variants::run(arguments),
        Command::Windows(arguments) => windows::run(arguments),
        Command::Measure(arguments) => return measure::run(arguments),
        Command::Bench(arguments) => return bench::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match &error {
                StudyError::Scene(_)
                | StudyError::Unfit { .. }
                | StudyError::Option { .. }
                | StudyError::Record { .. } => 2,
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
