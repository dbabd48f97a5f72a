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
    /// Remove all entries
    Clear,
}

pub const HELP: &str = "\
Preparing the operator of compressible water takes seconds to minutes. The
cache stores prepared operators by a hash of all their inputs: water, section,
points, communication step, the duration (for convolutions only), and the
program's sources. A run with the same inputs reads the entry and gives
bit-identical results. Damaged entries are prepared again. Operators that are
quick to prepare are not stored. When the cache is full, the least recently
used entries are evicted first.

Examples:
  cofferdam cache
      Shows the location and the size of the cache.
  cofferdam cache clear
  cofferdam run scenes/koyna-northridge-1994 --no-cache
      Prepares the operator again and does not store it.

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
