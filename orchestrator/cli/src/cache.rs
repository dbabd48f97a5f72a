//! `cofferdam cache`.

use crate::context::used_cache;
use crate::terminal::{print, warn};
use cofferdam_assembly::cache::{Cache, Content};
use std::process::ExitCode;

/// Arguments of `cofferdam cache`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Remove all that it holds
    Clear,
}

pub const HELP: &str = "\
Preparing compressible water takes seconds to minutes. What was prepared is kept, under the hash of all that it was
made from (water, section, points, communication step, and for convolutions the duration; the program's own sources
too). A run with the same finds it and gives the same bits. Damaged entries are made anew. What is quickly made is
not kept. When the cache is full, what was not used for longest goes.

Examples:
  cofferdam cache
      Where is it, and how large?
  cofferdam cache clear
  cofferdam run scenes/koyna-northridge-1994 --no-cache
      Prepare anew, and keep nothing.

Exit status: 0 done, 1 the folder cannot be read or written.";

pub fn run(arguments: &Arguments) -> ExitCode {
    let Some(cache) = used_cache() else {
        print("no cache is used");
        return ExitCode::SUCCESS;
    };
    let (done, what) = match arguments.command {
        None => (cache.content(), "of"),
        Some(Command::Clear) => (cache.clear(), "removed, of"),
    };
    match done {
        Ok(Content { entries, bytes }) => {
            let mega = |bytes: u64| bytes as f64 / 1e6;
            print(format!(
                "{}: {entries} entries, {:.1} MB {what} at most {:.0} MB",
                cache.folder().display(),
                mega(bytes),
                mega(Cache::LARGEST)
            ));
            ExitCode::SUCCESS
        }
        Err(error) => {
            warn(format!(
                "{}: {error}; remove the folder by hand, or use --cache DIR",
                cache.folder().display()
            ));
            ExitCode::FAILURE
        }
    }
}
