//! `cofferdam`: couples a reservoir and a cracked dam under an earthquake.

mod arguments;
mod cache;
mod check;
mod context;
mod ensemble;
mod export_fmu;
mod export_ssp;
mod fmu_input;
mod log;
mod modes;
mod options;
mod plan;
mod points;
mod range;
mod replay;
mod report;
mod reservoir;
mod run;
mod shell;
mod stability;
mod template;
mod terminal;
mod unit;

use arguments::{Arguments, Command};
use clap::{CommandFactory, Parser};
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
    cofferdam_assembly::build_info::set_commit(env!("COFFERDAM_COMMIT"));
    let Arguments { command, cache, no_cache } = Arguments::parse();
    context::use_cache(cache, !no_cache);
    terminal::exit_status(match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Resume(arguments) => run::resume::run(&arguments),
        Command::Branch(arguments) => run::branch::run(&arguments),
        Command::Unit(arguments) => unit::unit(&arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::ExportFmu(arguments) => export_fmu::run(&arguments),
        Command::ExportSsp(arguments) => export_ssp::run(&arguments),
        Command::FmuInput(arguments) => fmu_input::run(&arguments),
        Command::Stability(arguments) => stability::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Points(arguments) => points::run(&arguments),
        Command::Template(command) => template::run(&command),
        Command::Report(arguments) => report::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Log(command) => log::run(&command),
        Command::Reservoir(command) => reservoir::run(&command),
        Command::Cache(arguments) => cache::run(&arguments),
        Command::Ensemble(arguments) => ensemble::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments, Arguments::command()),
        Command::Man(arguments) => shell::man(&arguments, Arguments::command()),
        Command::Range(arguments) => range::run(&arguments),
    })
}
