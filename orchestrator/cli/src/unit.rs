//! `cofferdam unit`.

use crate::context::making;
use crate::options::BuiltIn;
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::participant::Participant;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::Scene;
use cofferdam_shared_memory::{Task, host};
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// Arguments of `cofferdam unit`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Unit to serve
    pub unit: BuiltIn,
}

pub const HELP: &str = "\
Serve one unit of a run. `run` starts this command once for the dam and once
for each water.

The process reads its task, one line of JSON, from standard input, creates the
unit, reports on standard output that it is ready, and serves requests over
shared memory until it reads the line `end`. It also ends when standard input
closes, because the orchestrator has then died. docs/reference/protocol.md
describes the protocol for replacing it with a unit of your own.";

#[derive(Debug, thiserror::Error)]
enum UnitError {
    #[error("the scene in the task is not complete: {0}")]
    Scene(#[from] toml::de::Error),
    #[error(transparent)]
    Registry(#[from] AssemblyError),
}

/// Makes the unit of the orchestrator's task and serves it until the run is over.
pub fn unit(arguments: &Arguments) -> ExitCode {
    // A run is ended through the orchestrator, which ends its units; job schedulers signal all processes at once.
    let _ = ctrlc::set_handler(|| ());
    host(|task| make(arguments.unit.into(), task))
}

fn make(id: UnitId, task: &Task) -> Result<Box<dyn Participant>, UnitError> {
    let scene: Scene = toml::from_str(&task.scene)?;
    let threads = NonZeroUsize::new(task.threads).unwrap_or(NonZeroUsize::MIN);
    Ok(Assembly::with(&scene, making(threads)).unit(id)?)
}
