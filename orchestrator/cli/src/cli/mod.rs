//! The command line.

pub mod accuracy;
pub mod bench;
pub mod cache;
pub mod check;
pub mod ensemble;
mod estimate;
pub mod export_fmu;
pub mod log;
mod modes;
mod output;
mod parallel;
mod parquet;
mod picture;
pub mod plan;
pub mod points;
pub mod replay;
pub mod report;
pub mod reservoir;
pub mod run;
mod section;
pub mod shell;
mod spectra;
mod start;
pub mod study;
mod table;
pub mod template;
pub mod unit;

pub use output::exit_status;

use clap::{Parser, Subcommand, ValueEnum};
use cofferdam_assembly::cache::Cache;
use cofferdam_assembly::units::{DAM, RESERVOIR, TAILWATER};
use cofferdam_assembly::{Assembly, AssemblyError, Making};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_log::Head;
use cofferdam_report::Build;
use cofferdam_scene::{ReservoirScene, Scene};
use interface::WetFace;
use output::{complain, say};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Seismic analysis of cracked concrete gravity dams with their reservoirs.
///
/// The reservoir (compressible water, boundary elements) and the dam (deformable blocks,
/// distinct elements) are two co-simulation units. Each communication step is repeated until
/// the pressure and the motion of the wet face agree, and every exchange is logged.
#[derive(Parser)]
// Help is wrapped by hand.
#[command(name = "cofferdam", version, arg_required_else_help = true, term_width = 0)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,

    /// Folder for prepared operators of the water; by default `cofferdam` in the user's folder for caches
    ///
    /// What was prepared once is read from there, and the bits are the same. `cofferdam cache` says what it holds.
    #[arg(long, global = true, hide_short_help = true, value_name = "DIR", env = "COFFERDAM_CACHE")]
    pub cache: Option<PathBuf>,

    /// Prepare anew, and keep nothing
    #[arg(long, global = true, hide_short_help = true)]
    pub no_cache: bool,
}

/// The cache of this process; none without [`use_cache`].
static CACHE: OnceLock<Option<Cache>> = OnceLock::new();

/// Uses the cache that was asked for: in this `folder`, or the user's; none if it is not `wanted`.
pub fn use_cache(folder: Option<PathBuf>, wanted: bool) {
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.map(|folder| std::path::absolute(&folder).unwrap_or(folder));
    CACHE.get_or_init(|| folder.map(Cache::at).or_else(Cache::of_user).filter(|_| wanted));
}

/// The cache in use.
fn used_cache() -> Option<&'static Cache> {
    CACHE.get().and_then(Option::as_ref)
}

/// Making units on these threads, with the cache in use.
fn making(threads: NonZeroUsize) -> Making<'static> {
    Making { threads, cache: used_cache() }
}

/// The subcommands.
#[derive(Subcommand)]
pub enum Command {
    /// Run a scene: crest motion, sliding, rotation, pressure; histories and a log of every exchange
    #[command(after_long_help = RUN_HELP)]
    Run(Run),
    /// Go on with a run that was interrupted; it ends as if it had not been, bit for bit
    #[command(after_long_help = run::resume::HELP)]
    Resume(run::resume::Arguments),
    /// Try a run otherwise from one of its steps on
    #[command(after_long_help = run::branch::HELP)]
    Branch(run::branch::Arguments),
    /// Write the report of a run, of two side by side, or of an ensemble: one HTML page
    #[command(after_long_help = report::HELP)]
    Report(report::Arguments),
    /// Check scenes without running them: every mistake at its line, and warnings about doubtful choices
    #[command(after_long_help = CHECK_HELP)]
    Check(Check),
    /// Say what a run of a scene will model and what it leaves out, each by its number; expected errors, time and disk
    #[command(after_long_help = plan::HELP)]
    Plan(plan::Arguments),
    /// Repeat the requests in the log of a run with new units: are the answers equal, bit for bit?
    #[command(after_long_help = replay::HELP)]
    Replay(replay::Arguments),
    /// Pack a unit of a scene as an FMU (FMI 3.0), for other programs to simulate
    #[command(after_long_help = export_fmu::HELP)]
    ExportFmu(export_fmu::Arguments),
    /// Print the points of the wet face at which the units of a scene exchange
    #[command(after_long_help = points::HELP)]
    Points(points::Arguments),
    /// Write a folder from which to make a reservoir or a dam of your own: an FMU in C, or a process in Python
    #[command(subcommand)]
    Template(template::Command),
    /// Inspect and compare the logs of runs
    #[command(subcommand)]
    Log(log::Command),
    /// Response of the water alone: in the frequency domain, to an impulse, to a record, in the field
    #[command(subcommand)]
    Reservoir(reservoir::Command),
    /// Series of runs: convergence of the coupling, accuracy and cost of models and tolerances
    #[command(subcommand)]
    Study(study::Command),
    /// Many runs of a scene: records, levels of shaking, parameters; medians, fragility, what the variance comes from
    #[command(after_long_help = ensemble::HELP)]
    Ensemble(ensemble::Arguments),
    /// Where the time of runs goes, beside another build of this program
    #[command(after_long_help = bench::HELP)]
    Bench(bench::Arguments),
    /// The cache of prepared operators of the water: where it is, what it holds; clear it
    #[command(after_long_help = cache::HELP)]
    Cache(cache::Arguments),
    /// Print the completions of this command for a shell
    #[command(after_long_help = shell::COMPLETIONS_HELP)]
    Completions(shell::Completions),
    /// Write the manual pages, one for each command
    #[command(after_long_help = shell::MAN_HELP)]
    Man(shell::Man),
    /// Serve one of the units of a run; started by `run`
    #[command(hide = true, long_about = UNIT_HELP)]
    Unit(Unit),
}

/// Exit status when answers or logs that should be identical are not.
const DIFFERENT: u8 = 5;

/// Arguments of `cofferdam run`.
#[derive(clap::Args)]
pub struct Run {
    /// Folder that holds scene.toml, or a .toml file
    ///
    /// scenes/README.md explains every key of a scene, with units and defaults. All mistakes in a
    /// scene are reported at once, with their lines, before anything is computed; doubtful choices
    /// give warnings, and the run starts. `cofferdam check` reports the same without running.
    pub scene: PathBuf,

    /// Change a value of the scene; may be given several times
    ///
    /// Such as dam.element_size=2.5 or dam.cracks.0.elevation=60. The manifest of the results shows the scene as it was run.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Folder for the results; by default runs/SCENE-TIME
    ///
    /// It is created if necessary. A folder that is not empty is refused: nothing is overwritten.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    /// Which exchanges are logged, of every iteration, accepted ones or none: short for --set log.exchanges=…
    ///
    /// Accepted ones take half of the disk, and are all that replays, branches and resumed runs need. Without any, for series
    /// of runs, a run can only be run again.
    #[arg(long, value_name = "WHICH", value_parser = ["every", "accepted", "none"])]
    pub log: Option<String>,

    /// Also run N twins whose motion differs by noise of 1 %, and give each number its band: 16 %, median, 84 %
    ///
    /// One run of a cracked dam is one draw. Twins run with the reduced dam where the run has the full one.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(3..=10_000))]
    pub band: Option<u16>,

    /// Choose the numerics for this accuracy: 5%, or crest=2%,history=5%,sliding=20%
    ///
    /// A pilot of cheap twins finds the cheapest level whose error against the reference is expected to be small enough; the run then
    /// says what it chose, and whether the accuracy is kept, not kept, or cannot be kept because 1 % of shaking changes the answer by
    /// more. Elements, communication step, fidelity of the dam and method of the water are chosen; nothing physical is changed.
    /// docs/accuracy.md says what each quantity means.
    #[arg(long, value_name = "SHARE", value_parser = accuracy::asked)]
    pub accuracy: Option<accuracy::Asked>,

    #[command(flatten)]
    pub options: Options,
}

/// What `run`, `resume` and `branch` share.
#[derive(clap::Args)]
pub struct Options {
    /// End the run at this time, s; `resume` goes on from there
    ///
    /// No bit before is changed by it. `time.duration` of the scene changes what the water is computed for.
    #[arg(long, value_name = "SECONDS", value_parser = time)]
    pub until: Option<f64>,

    /// Threads for preparing the reservoir's operator, and for large meshes of the dam; by default one per core
    ///
    /// Results are equal, bit for bit, for any number.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,

    /// How the units exchange
    #[arg(long, value_enum, env = "COFFERDAM_TRANSPORT", default_value_t = Transport::SharedMemory)]
    pub transport: Transport,

    /// Longest time in seconds that a unit may take for a step before its process is ended
    ///
    /// Preparation and initialisation may take sixty times as long. No effect with --transport in-process.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub deadline: f64,

    /// No progress line
    #[arg(short, long)]
    pub quiet: bool,

    /// Do not write report.html; `cofferdam report` makes it later
    #[arg(long)]
    pub no_report: bool,

    /// Print the results as one line of JSON on standard output; all words go to standard error
    ///
    /// docs/running.md has its members. A run that fails prints one too, with the exit status beside it.
    #[arg(long)]
    pub json: bool,
}

/// How the units exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Transport {
    /// Each unit is a process of its own, connected by shared memory (iceoryx2)
    SharedMemory,
    /// All units run in this process; results are equal, bit for bit
    InProcess,
}

/// Arguments of `cofferdam unit`.
#[derive(clap::Args)]
pub struct Unit {
    /// Which of them
    pub unit: BuiltIn,
}

/// The built-in units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BuiltIn {
    /// The dam
    Dam,
    /// The reservoir
    Reservoir,
    /// The tailwater
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
    fn water(self, scene: &Scene) -> &ReservoirScene {
        let tailwater = scene.tailwater.as_ref().filter(|_| self == Self::Tailwater);
        tailwater.unwrap_or(&scene.reservoir)
    }

    /// The points at which this unit of `scene` exchanges.
    ///
    /// **Errors**: those of the wet face.
    fn face(self, scene: &Scene) -> Result<WetFace, AssemblyError> {
        Ok(Assembly::of(scene).place(self.into())?.face)
    }
}

/// The requested number of threads, or one per core.
pub fn threads(asked: Option<u16>) -> NonZeroUsize {
    let asked = asked.and_then(|n| NonZeroUsize::new(n.into()));
    asked.or(std::thread::available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN)
}

/// What a unit has answered; nothing if it has no such variable.
fn known(read: Result<Vec<f64>, ParticipantError>) -> Result<Vec<f64>, ParticipantError> {
    match read {
        Err(ParticipantError::Missing { .. }) => Ok(Vec::new()),
        answered => answered,
    }
}

/// How the program or the machine differs from that of a log.
fn other_build(head: &Head) -> Option<String> {
    let here = Build::here();
    let pairs = [
        ("version", &*here.version, &head.version),
        ("commit", &here.commit, &head.commit),
        ("profile", &here.profile, &head.profile),
        ("processor's features", &here.features, &head.features),
        ("system", &here.system, &head.system),
    ];
    let other = pairs.into_iter().find(|(_, now, then)| now != then)?;
    let (what, now, then) = other;
    Some(format!("the run was made by another {what} ({then:?}, here {now:?})"))
}

fn time(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "a number of seconds is wanted".to_owned())?;
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err("it must be a time of the run".to_owned()) }
}

fn seconds(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "a number of seconds is wanted".to_owned())?;
    if (0.1..=1e6).contains(&value) { Ok(value) } else { Err("it must lie from 0.1 to 1e6 s".to_owned()) }
}

const UNIT_HELP: &str = "\
Be one of a run's units: what `run` starts by itself, once for the dam and once for each water.

The process reads its task, one line of JSON, from standard input, makes its unit, says on standard
output that it is ready, and answers requests over shared memory until a line `end` comes. It ends
when standard input closes: when the orchestrator dies. docs/shared-memory.md describes the protocol
for those who want to put a unit of their own in its place.";

/// Arguments of `cofferdam check`.
#[derive(clap::Args)]
pub struct Check {
    /// Folders that hold scene.toml, or .toml files
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,

    /// Change a value of every scene before it is checked; may be given several times
    ///
    /// As in `cofferdam run`; an error in a changed value is shown in the KEY=VALUE itself.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Draw the section to scale into this .svg: mesh, cracks, water, wet points; of one scene
    #[arg(short, long, value_name = "FILE")]
    pub picture: Option<PathBuf>,

    /// Write the dam's mode shapes to modes.vtu in this folder, for ParaView; of one scene
    #[arg(short, long, value_name = "FOLDER")]
    pub modes: Option<PathBuf>,
}

const CHECK_HELP: &str = "\
Errors, each at its line: invalid TOML, unknown, misplaced and missing keys, wrong types and
words, values and geometry that cannot be computed, a record that cannot be read.

Warnings, which `cofferdam run` shows too: elements or communication steps too coarse for the
record's frequencies, a record that drifts, no rest after it for the residual sliding, values that
seem to be in another unit. scenes/README.md lists the thresholds.

Natural frequencies are those of the intact dam: empty, and full, with the mass of the water as if it were
incompressible. modes.vtu holds the shapes as point data mode_1_empty, mode_1_full and so on, each with a
modal mass of 1, and the frequencies as field data. Files that exist are replaced.

Examples:
  cofferdam check scenes/koyna-northridge-1994
      Prints the number of steps of a run, or the errors that prevent it.
  cofferdam check scenes/koyna-northridge-1994 --set dam.element_size=25
      Would that mesh be fine enough?
  cofferdam check scenes/koyna-northridge-1994 --picture koyna.svg --modes modes
      Is the section drawn as it was meant?
  cofferdam check scenes/*/scene.toml
      All scenes.

Exit status: 0 every scene can be run, 1 a file cannot be written, 2 a scene or an option is wrong.";

const RUN_HELP: &str = "\
Results, in the output folder:
  report.html     all that follows on one page, for screen and paper
  log.mcap        every request and answer of every iteration (MCAP, protobuf);
                  open it with Foxglove, PlotJuggler, Rerun or Python's mcap package
  histories.csv   time histories of all scalar results
  response_spectra.csv, .svg
                  response spectra of ground and crest, 5 % damping
  snapshots.pvd   with [snapshots] in the scene: the dam's fields over time, for ParaView
  dam-*.csv, reservoir-*.csv, with [tailwater] tailwater-*.csv
                  motion and pressure of the wet faces, one column per point
  manifest.toml   the scene with all defaults, versions, machine, and the summary

Examples:
  cofferdam run scenes/koyna-northridge-1994
      The cracked Koyna dam under the Northridge earthquake of 1994.
  cofferdam run scenes/rigid-dam-ramp --output /tmp/ramp
      A rigid dam under a ramp of acceleration, which has a closed-form answer.
  cofferdam run scenes/koyna-northridge-1994 --set dam.element_size=1.25
      The same dam on a finer mesh.
  cofferdam run scenes/koyna-northridge-1994 --band 16
      How far the numbers scatter if the motion differs by 1 %.
  cofferdam run scenes/koyna-intact --accuracy 5%
      The cheapest run whose crest is within 5 %.

  cofferdam run scenes/koyna-northridge-1994 --json | jq .key_figures
      The numbers that matter first, for a program.

Ctrl-C ends a run after the current step; log and histories stay readable, and the summary is
marked as partial. Press it twice to exit immediately.

Exit status: 0 completed, 1 results could not be written, 2 the scene is wrong,
3 a step did not converge, 4 a unit failed, 130 interrupted; with --accuracy, completed:
0 it is kept, 6 it is not kept, 7 it cannot be kept.";
