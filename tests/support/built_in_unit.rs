//! A built-in unit in another executable than `cofferdam`, for scenes that name it as a command: the dam with all elements and
//! contacts, or compressible water.

use orchestrator::participant::{Task, host};
use orchestrator::registry::{self, RegistryError};
use orchestrator::scene::{DamFidelityScene, FidelityScene, Scene};
use orchestrator::scheme::UnitId;
use std::num::NonZeroUsize;
use std::process::ExitCode;

fn main() -> ExitCode {
    host(|task: &Task| -> Result<_, RegistryError> {
        let mut scene: Scene = toml::from_str(&task.scene).expect("a scene");
        let id = match (&*task.unit, &mut scene.dam) {
            ("dam", Some(dam)) => {
                dam.fidelity = DamFidelityScene::Dem;
                UnitId::DAM
            }
            _ => {
                scene.reservoir.fidelity = FidelityScene::Compressible;
                UnitId::RESERVOIR
            }
        };
        registry::unit(id, &scene, NonZeroUsize::MIN)
    })
}
