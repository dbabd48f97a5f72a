//! A built-in unit in another executable than `cofferdam`, for scenes that name it as a command: the dam with all elements and
//! contacts, or compressible water.

use cofferdam_assembly::units::{DAM, RESERVOIR};
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_scene::{DamFidelityScene, FidelityScene, Scene};
use cofferdam_shared_memory::{Task, host};
use std::num::NonZeroUsize;
use std::process::ExitCode;

fn main() -> ExitCode {
    host(|task: &Task| -> Result<_, AssemblyError> {
        let mut scene: Scene = toml::from_str(&task.scene).expect("a scene");
        let id = match (&*task.unit, &mut scene.dam) {
            ("dam", Some(dam)) => {
                dam.fidelity = DamFidelityScene::Dem;
                DAM
            }
            _ => {
                scene.reservoir.fidelity = FidelityScene::Compressible;
                RESERVOIR
            }
        };
        Assembly::with(&scene, NonZeroUsize::MIN).unit(id)
    })
}
