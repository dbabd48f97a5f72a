//! `cofferdam unit`.

use super::{Unit, making};
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::participant::Participant;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::Scene;
use cofferdam_shared_memory::{Task, host};
use std::num::NonZeroUsize;
use std::process::ExitCode;

#[derive(Debug, thiserror::Error)]
enum UnitError {
    #[error("the scene in the task is not complete: {0}")]
    Scene(#[from] toml::de::Error),
    #[error(transparent)]
    Registry(#[from] AssemblyError),
}

/// Makes the unit of the orchestrator's task and serves it until the run is over.
pub fn unit(arguments: &Unit) -> ExitCode {
    // Who ends a run asks the orchestrator, which ends its units; job schedulers signal to all processes at once.
    let _ = ctrlc::set_handler(|| ());
    host(|task| make(arguments.unit.into(), task))
}

fn make(id: UnitId, task: &Task) -> Result<Box<dyn Participant>, UnitError> {
    let scene: Scene = toml::from_str(&task.scene)?;
    let threads = NonZeroUsize::new(task.threads).unwrap_or(NonZeroUsize::MIN);
    Ok(Assembly::with(&scene, making(threads)).unit(id)?)
}
