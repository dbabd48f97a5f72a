//! Options and values that several commands share.

use clap::ValueEnum;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::{run, start};
use cofferdam_assembly::units::{DAM, RESERVOIR, TAILWATER};
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_scene::{ReservoirScene, Scene};
use cofferdam_unit::WetFace;

/// Common options of `run`, `resume` and `branch`.
#[derive(clap::Args)]
pub struct Options {
    /// End the run at this time, s; `resume` continues it
    ///
    /// Earlier results are unaffected. `time.duration` of the scene, in contrast, also changes the duration
    /// for which the water is prepared.
    #[arg(long, value_name = "SECONDS", value_parser = time)]
    pub until: Option<f64>,

    /// Threads for preparing the water operator and for large dam meshes (default: one per core)
    ///
    /// Results are bit-identical for any number of threads.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// How the units exchange data
    #[arg(long, value_enum, env = "COFFERDAM_TRANSPORT", default_value_t = Transport::SharedMemory)]
    pub transport: Transport,

    /// Maximum wall time of a unit per step, s; the process of a slower unit is terminated
    ///
    /// The limit for preparation and initialisation is 60 times as long. Has no effect with --transport
    /// in-process.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub deadline: f64,

    /// Do not show the progress line
    #[arg(short, long)]
    pub quiet: bool,

    /// Do not write report.html; `cofferdam report` can write it later
    #[arg(long)]
    pub no_report: bool,

    /// Print the results as one line of JSON on standard output; all other output goes to standard error
    ///
    /// docs/guide/running.md lists its members. A run that fails prints a line too; if it failed before the
    /// first step, the line holds the status and the exit status only.
    #[arg(long)]
    pub json: bool,
}

/// How the units exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Transport {
    /// One process per unit, connected by shared memory (iceoryx2)
    SharedMemory,
    /// All units in this process; results are bit-identical
    InProcess,
}

impl From<Transport> for start::Transport {
    fn from(transport: Transport) -> Self {
        match transport {
            Transport::SharedMemory => Self::SharedMemory,
            Transport::InProcess => Self::InProcess,
        }
    }
}

impl Options {
    /// The same for the library.
    pub fn of_run(&self) -> run::Options {
        run::Options {
            until: self.until,
            threads: threads(self.threads),
            transport: self.transport.into(),
            deadline: self.deadline,
            report: !self.no_report,
        }
    }
}

/// The built-in units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BuiltIn {
    /// Dam
    Dam,
    /// Reservoir
    Reservoir,
    /// Tailwater
    Tailwater,
}

impl From<BuiltIn> for UnitId {
    fn from(unit: BuiltIn) -> Self {
        match unit {
            BuiltIn::Dam => DAM,
            BuiltIn::Reservoir => RESERVOIR,
            BuiltIn::Tailwater => TAILWATER,
        }
    }
}

impl BuiltIn {
    /// The water of a scene that this unit is, or with which it exchanges.
    pub fn water(self, scene: &Scene) -> &ReservoirScene {
        let tailwater = scene.tailwater.as_ref().filter(|_| self == Self::Tailwater);
        tailwater.unwrap_or(&scene.reservoir)
    }

    /// The points at which this unit of `scene` exchanges.
    ///
    /// **Errors**: those of the wet face.
    pub fn face(self, scene: &Scene) -> Result<WetFace, AssemblyError> {
        Ok(Assembly::of(scene).place(self.into())?.face)
    }
}

/// A time of a run, s.
pub fn time(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err("must be finite and at least 0 s".to_owned())
    }
}

/// A time limit, s.
pub fn seconds(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if (0.1..=1e6).contains(&value) { Ok(value) } else { Err("must be between 0.1 and 1e6 s".to_owned()) }
}
