//! Creates the units of a scene, including those of other programs, in this process or in separate processes.

use crate::context::Context;
use cofferdam_assembly::units::unit_name;
use cofferdam_assembly::{Assembly, AssemblyError, Home};
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::Scene;
use cofferdam_shared_memory::{Deadlines, Starting, UnitCommand};
use std::num::NonZeroUsize;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Transport of the units. Results are bit-identical.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transport {
    /// Each unit is a process of its own, connected by shared memory.
    #[default]
    SharedMemory,
    /// All units run in this process.
    InProcess,
}

/// Reason why units cannot be created.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// A unit of the scene.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A process that does not become a unit.
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    /// The program that would host the units.
    #[error("the program's own file cannot be found: {0}; use --transport in-process")]
    Program(std::io::Error),
}

/// Ratio of the time limits of preparation and initialisation to that of a step.
const PREPARATION: u32 = 60;

/// The time limits of units that are given `seconds` for a step.
pub fn deadlines(seconds: f64) -> Deadlines {
    let step = Duration::from_secs_f64(seconds);
    Deadlines { preparation: PREPARATION * step, step }
}

/// Settings for the creation of units.
pub struct Start<'a> {
    /// Inputs of the units.
    pub scene: &'a Scene,
    /// The scene as TOML.
    pub resolved: &'a str,
    /// Transport.
    pub transport: Transport,
    /// For preparing the reservoir's operator, and for large meshes of the dam.
    pub threads: NonZeroUsize,
    /// Time limits of processes.
    pub deadlines: Deadlines,
    /// Set to end the preparation early.
    pub interrupted: &'a AtomicBool,
    /// Whether a line names the processes.
    pub announce: bool,
    /// Cache, program, reporter.
    pub context: Context<'a>,
}

impl Start<'_> {
    /// Makes these units of the scene, in this order.
    ///
    /// **Errors**: [`StartError`].
    pub fn units(&self, ids: &[UnitId]) -> Result<Vec<Box<dyn Participant>>, StartError> {
        let program = match self.context.program {
            Some(program) => program.to_owned(),
            None => std::env::current_exe().map_err(StartError::Program)?,
        };
        let mut commands = Vec::new();
        for &id in ids {
            let name = unit_name(id).to_owned();
            match Assembly::of(self.scene).home(id) {
                Home::Process if self.transport == Transport::SharedMemory => {
                    let mut command = Command::new(&program);
                    command.args(["unit", &name]);
                    match self.context.cache {
                        Some(cache) => command.arg("--cache").arg(cache.folder()),
                        None => command.arg("--no-cache"),
                    };
                    commands.push((id, UnitCommand { name, command, brief: None }));
                }
                Home::Command(scene) => {
                    let [program, arguments @ ..] = &scene.argv[..] else { continue };
                    let mut command = Command::new(program);
                    command.args(arguments);
                    if let Some(folder) = &scene.folder {
                        command.current_dir(folder);
                    }
                    let brief = Some(Assembly::of(self.scene).brief(id, scene)?);
                    commands.push((id, UnitCommand { name, command, brief }));
                }
                Home::Here | Home::Process => (),
            }
        }
        let (own, commands): (Vec<UnitId>, Vec<UnitCommand>) = commands.into_iter().unzip();
        let mut started = Vec::new();
        if !commands.is_empty() {
            let starting = Starting::new(commands, self.resolved, self.threads.get(), self.deadlines)?;
            if self.announce {
                let processes: Vec<String> =
                    starting.processes().map(|(name, id)| format!("{name} {id}")).collect();
                self.context.line(format!("processes  {}", processes.join(", ")));
            }
            started = starting.wait(self.interrupted)?;
        }
        let mut started = own.into_iter().zip(started).collect::<Vec<_>>().into_iter().peekable();
        let mut units: Vec<Box<dyn Participant>> = Vec::with_capacity(ids.len());
        for &id in ids {
            let process = started.next_if(|(own, _)| *own == id).map(|(_, process)| Box::new(process));
            units.push(match (process, Assembly::of(self.scene).home(id)) {
                (Some(process), Home::Command(_)) => Assembly::of(self.scene).adapted(id, process)?,
                (Some(process), _) => process,
                (None, _) => Assembly::with(self.scene, self.context.making(self.threads)).unit(id)?,
            });
        }
        Ok(units)
    }
}
