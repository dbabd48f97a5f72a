//! `cofferdam`: couples a reservoir and a cracked dam under an earthquake.

mod cli;

use clap::Parser;
use std::process::ExitCode;
use std::sync::Arc;

/// A run allocates some hundred small lists a step, and its threads free each other's: by the system's allocator that takes a
/// twelfth of a reduced run.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Number of the signal on Linux.
const SIGXFSZ: i32 = 25;

fn main() -> ExitCode {
    // Options and paths in messages are not broken, so that they can be copied.
    let whole_words = miette::MietteHandlerOpts::new()
        .break_words(false)
        .word_separator(textwrap::WordSeparator::AsciiSpace)
        .word_splitter(textwrap::WordSplitter::NoHyphenation);
    // It fails only if a handler is set already.
    let _ = miette::set_hook(Box::new(move |_| Box::new(whole_words.clone().build())));
    // So that writing beyond the limit of file sizes is an error like that of a full disk, and not the end of the process. If
    // it fails, it ends the process as before.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    let cli::Arguments { command, cache, no_cache } = cli::Arguments::parse();
    cli::use_cache(cache, !no_cache);
    cli::exit_status(match command {
        cli::Command::Run(arguments) => cli::run::run(&arguments),
        cli::Command::Resume(arguments) => cli::run::resume::run(&arguments),
        cli::Command::Branch(arguments) => cli::run::branch::run(&arguments),
        cli::Command::Unit(arguments) => cli::unit::unit(&arguments),
        cli::Command::Check(arguments) => cli::check::check(&arguments),
        cli::Command::ExportFmu(arguments) => cli::export_fmu::run(&arguments),
        cli::Command::Plan(arguments) => cli::plan::run(&arguments),
        cli::Command::Points(arguments) => cli::points::run(&arguments),
        cli::Command::Template(command) => cli::template::run(&command),
        cli::Command::Report(arguments) => cli::report::run(&arguments),
        cli::Command::Replay(arguments) => cli::replay::run(&arguments),
        cli::Command::Log(command) => cli::log::run(&command),
        cli::Command::Reservoir(command) => cli::reservoir::run(&command),
        cli::Command::Bench(arguments) => cli::bench::run(&arguments),
        cli::Command::Cache(arguments) => cli::cache::run(&arguments),
        cli::Command::Ensemble(arguments) => cli::ensemble::run(&arguments),
        cli::Command::Completions(arguments) => cli::shell::completions(&arguments),
        cli::Command::Man(arguments) => cli::shell::man(&arguments),
        cli::Command::Study(command) => cli::study::run(&command),
    })
}
