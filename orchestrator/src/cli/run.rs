//! `cofferdam run`.

use super::start::{Start, StartError, deadlines};
use super::{Run, Transport, check, complain, known, say, spectra};
use crate::registry::{self, RegistryError};
use miette::Diagnostic;
use orchestrator::ground_motion::{GroundMotion, STANDARD_GRAVITY};
use orchestrator::log::{LogError, LogWriter, Preamble};
use orchestrator::observer::{HistoriesWriter, Limits, Observer, Progress, Rest, Snapshots, Status};
use orchestrator::participant::{ParticipantError, Starting};
use orchestrator::report::{Build, Manifest, ManifestError, Summary, Unit, WaterFace};
use orchestrator::scene::{
    DamFidelityScene, DampingModelScene, FidelityScene, LoadedScene, MethodScene, Scene, SceneError, Side,
};
use orchestrator::scheme::{CouplingError, Graph, UnitId, interface_points};
use orchestrator::simulation::{Simulation, SimulationError};
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Why a run ended without a result, or with a partial one.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum RunError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error("{}: {cause}; choose another --output", path.display())]
    Output { path: PathBuf, cause: std::io::Error },
    #[error("{} is not empty; choose another --output, nothing is overwritten", path.display())]
    OutputTaken { path: PathBuf },
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    #[error(transparent)]
    Unit(#[from] RegistryError),
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error(transparent)]
    Start(#[from] StartError),
    #[error("the response spectra: {0}; free some space or choose another --output")]
    Spectra(Box<dyn std::error::Error + Send + Sync>),
    #[error("Ctrl-C cannot be caught: {0}; it takes a thread: allow more (`ulimit -u`)")]
    Signal(#[from] ctrlc::Error),
}

impl RunError {
    fn exit_status(&self) -> u8 {
        match self {
            Self::Scene(_) => 2,
            Self::Participant(ParticipantError::Interrupted)
            | Self::Start(StartError::Participant(ParticipantError::Interrupted)) => INTERRUPTED,
            Self::Simulation(SimulationError::Coupling(
                CouplingError::NotConverged { .. }
                | CouplingError::Hopeless { .. }
                | CouplingError::BlewUp { .. },
            )) => 3,
            Self::Start(StartError::Program(_)) => 1,
            Self::Unit(_)
            | Self::Start(_)
            | Self::Participant(_)
            | Self::Simulation(SimulationError::Coupling(_)) => 4,
            _ => 1,
        }
    }
}

const INTERRUPTED: u8 = 130;

/// Runs a scene; reports the result on the terminal and by the exit status.
pub fn run(arguments: &Run) -> ExitCode {
    match execute(arguments) {
        Ok(Status::Interrupted) => ExitCode::from(INTERRUPTED),
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            let status = error.exit_status();
            complain(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

fn execute(arguments: &Run) -> Result<Status, RunError> {
    let loaded = registry::read(&arguments.scene, &arguments.set)?;
    let started = jiff::Timestamp::now();
    if arguments.transport == Transport::SharedMemory {
        Starting::check()?;
    }
    let interrupted = catch_interrupt()?;
    let (folder, manifest_path) = match &arguments.output {
        Some(folder) => claim(folder.clone())?,
        None => claim_new(&format!("runs/{}-{}", loaded.name, started.strftime("%Y%m%dT%H%M%SZ")))?,
    };
    check::warn(&loaded.warnings);

    let mut manifest = Manifest {
        name: loaded.name.clone(),
        started: started.to_string(),
        status: "preparing".to_owned(),
        build: Build::here(),
        wet_face: Vec::new(),
        reservoir_wet_face: None,
        further_wet_faces: Vec::new(),
        units: Vec::new(),
        result: None,
        scene: loaded.scene.clone(),
    };
    manifest.write(&manifest_path)?;
    let preamble = Preamble {
        scene: toml::to_string(&loaded.scene).map_err(ManifestError::from)?,
        version: manifest.build.version.to_owned(),
        commit: manifest.build.commit.to_owned(),
        profile: manifest.build.profile.to_owned(),
        processor: manifest.build.processor.clone(),
        features: manifest.build.features.clone(),
        system: manifest.build.system.clone(),
        started: manifest.started.clone(),
        parent: None,
        checkpoint_share: 0.05,
    };
    let mut log = LogWriter::create(&folder.join("log.mcap"), &preamble)?;
    let mut histories = HistoriesWriter::new(&folder);
    let mut progress = Progress::new(arguments.quiet);
    let mut limits = Limits::new(&loaded.scene.stop);
    let mut rest = Rest::new(&loaded.scene.time);
    let mut snapshots = loaded.scene.snapshots.map(|plan| Snapshots::new(&folder, plan));

    say(&loaded.scene.title);
    if !arguments.set.is_empty() {
        say(format!("but {}", arguments.set.join(", ")));
    }
    let began = Instant::now();
    let made = graph(arguments, &loaded.scene, &preamble.scene, &interrupted);
    if let Err(error) = &made {
        manifest.status = format!("failed: {error}");
        manifest.write(&manifest_path)?;
    }
    let mut graph = made?;
    for unit in graph.units() {
        let description = unit.description();
        let (name, solver) = (description.name.clone(), description.solver.clone());
        say(format!("{name:<10} {solver}"));
        let fingerprint = description.fingerprint.to_string();
        manifest.units.push(Unit { name, solver, fingerprint });
    }
    for (index, interface) in graph.interfaces().to_vec().iter().enumerate() {
        let [dam, own] = interface_points(&mut graph, interface)?;
        let own = Some(own).filter(|points| *points != dam);
        if index == 0 {
            (manifest.wet_face, manifest.reservoir_wet_face) = (dam, own);
        } else {
            let water = graph[interface.fluid.unit].description().name.clone();
            manifest.further_wet_faces.push(WaterFace { water, points: dam, own_points: own });
        }
    }
    "running".clone_into(&mut manifest.status);
    manifest.write(&manifest_path)?;
    let dam = dam_lines(&loaded, &mut graph)?;
    let stress_points = stress_points(&mut graph)?;
    let natural_frequencies = known(graph[UnitId::DAM].read("natural_frequency"))?;
    let recursion = recursion(&loaded.scene, &mut graph)?;
    say(ground_line(&loaded.ground_motion));
    say(format!("prepared in {:.2} s; results go to {}", began.elapsed().as_secs_f64(), folder.display()));

    let fits = Simulation::of_scene(&loaded.scene, &loaded.ground_motion, graph);
    if let Err(error) = &fits {
        manifest.status = format!("failed: {error}");
        manifest.write(&manifest_path)?;
    }
    let mut simulation = fits?;
    let mut observers: Vec<&mut dyn Observer> =
        vec![&mut log, &mut histories, &mut progress, &mut limits, &mut rest];
    observers.extend(snapshots.as_mut().map(|snapshots| snapshots as &mut dyn Observer));
    let (ending, failure) = simulation.run(&mut observers, &interrupted);
    let mut summary = Summary::of(
        &loaded,
        &histories.histories,
        &ending,
        simulation.static_crest_displacement,
        &stress_points,
        &natural_frequencies,
        &recursion,
    );
    summary.notes.extend(limits.flags().into_iter().map(|flag| format!("WARNING: {flag}")));
    let table = summary.to_string();
    manifest.status.clone_from(&summary.status);
    manifest.result = Some(summary);
    let written = manifest.write(&manifest_path);
    say(format!("\n{table}{dam}"));
    say(ending.wall);
    say(format!("log, histories and manifest are in {}", folder.display()));
    let spectra = spectra::write(&folder, &histories.histories);
    if let Some(error) = failure {
        return Err(error.into());
    }
    written?;
    spectra.map_err(RunError::Spectra)?;
    Ok(ending.status)
}

/// The units of a scene, of which `resolved` is the TOML.
fn graph(
    arguments: &Run,
    scene: &Scene,
    resolved: &str,
    interrupted: &AtomicBool,
) -> Result<Graph, RunError> {
    let start = Start {
        scene,
        resolved,
        transport: arguments.transport,
        threads: super::threads(arguments.threads),
        deadlines: deadlines(arguments.deadline),
        interrupted,
        announce: true,
    };
    let units = start.units(&registry::units(scene))?;
    Ok(Graph::new(units, registry::interfaces(scene)).map_err(RegistryError::from)?)
}

/// Creates the output folder, or takes an empty one; creates the manifest in it and returns both paths.
fn claim(folder: PathBuf) -> Result<(PathBuf, PathBuf), RunError> {
    let failed = |cause| RunError::Output { path: folder.clone(), cause };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    if std::fs::read_dir(&folder).map_err(failed)?.next().is_some() {
        return Err(RunError::OutputTaken { path: folder });
    }
    let manifest = folder.join("manifest.toml");
    match std::fs::File::create_new(&manifest) {
        Ok(_) => Ok((folder, manifest)),
        // Another run was faster.
        Err(cause) if cause.kind() == ErrorKind::AlreadyExists => Err(RunError::OutputTaken { path: folder }),
        Err(cause) => Err(failed(cause)),
    }
}

/// The same with the folder `name`, or, where runs of the same second have taken it, `name-2`, `name-3`, …
fn claim_new(name: &str) -> Result<(PathBuf, PathBuf), RunError> {
    let numbered = (2..).map(|number: u32| format!("{name}-{number}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    loop {
        match claim(names.next().unwrap_or_default().into()) {
            Err(RunError::OutputTaken { .. }) => (),
            claimed => return claimed,
        }
    }
}

/// A flag that the first Ctrl-C sets; the second Ctrl-C ends the process.
fn catch_interrupt() -> Result<Arc<AtomicBool>, RunError> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(interrupted)
}

/// Points where the dam outputs stress, m; none if it does not.
fn stress_points(graph: &mut Graph) -> Result<Vec<[f64; 2]>, ParticipantError> {
    let (x, y) = (
        known(graph[UnitId::DAM].read("stress_point_x"))?,
        known(graph[UnitId::DAM].read("stress_point_y"))?,
    );
    Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
}

/// Error and loss of the recursion of each water that has one and tells them.
fn recursion(scene: &Scene, graph: &mut Graph) -> Result<Vec<(Side, [f64; 2])>, ParticipantError> {
    let mut found = Vec::new();
    for (id, (side, water)) in graph.ids().skip(1).zip(scene.waters()) {
        if (water.fidelity, water.method) != (FidelityScene::Compressible, MethodScene::Recursive) {
            continue;
        }
        let [error, loss] = ["recursion_error", "recursion_loss"].map(|name| known(graph[id].read(name)));
        if let ([error], [loss]) = (&error?[..], &loss?[..]) {
            found.push((side, [*error, *loss]));
        }
    }
    Ok(found)
}

/// Source and peak of the ground motion.
fn ground_line(motion: &GroundMotion) -> String {
    let samples = motion.acceleration().iter().enumerate();
    let (index, peak) = samples.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, &0.0));
    let (source, time) = (motion.source(), index as f64 * motion.interval());
    format!("{:<10} {source}: peak {:.3} g at {time:.2} s", "ground", peak / STANDARD_GRAVITY)
}

/// Lines that name the damping model, which belongs to every value of sliding, and the fidelity if it is not the full one.
fn dam_lines(loaded: &LoadedScene, graph: &mut Graph) -> Result<String, ParticipantError> {
    let Some(dam) = loaded.scene.dam.as_ref().filter(|dam| !dam.fidelity.is_foreign()) else {
        return Ok(String::new());
    };
    let percent = 100.0 * dam.damping.ratio;
    let mut frequencies = graph[UnitId::DAM].read("damping_frequency_low")?;
    frequencies.extend(graph[UnitId::DAM].read("damping_frequency_high")?);
    let frequencies: Vec<String> = frequencies.iter().map(|f| format!("{f:.2}")).collect();
    let frequency = frequencies.first().map_or("", String::as_str);
    let damping = match dam.damping.model {
        _ if dam.damping.ratio == 0.0 => "none".to_owned(),
        DampingModelScene::Rayleigh => {
            format!("Rayleigh, {percent} % at {} rad/s", frequencies.join(" and "))
        }
        DampingModelScene::Mass => format!("of mass, {percent} % at {frequency} rad/s"),
        DampingModelScene::Stiffness => format!("of stiffness, {percent} % at {frequency} rad/s"),
        DampingModelScene::Local => format!("local, {percent} %"),
    };
    let fidelity_line = match dam.fidelity {
        DamFidelityScene::RigidBlocks => format!("{:<52} rigid blocks: unsafe\n", "fidelity of the dam"),
        DamFidelityScene::Dem => String::new(),
        fidelity => format!("{:<52} {}\n", "fidelity of the dam", fidelity.word()),
    };
    Ok(format!("{:<52} {damping}\n{fidelity_line}", "damping model of the dam"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_the_same_second_have_folders_of_their_own() -> Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let name = place.path().join("runs/case").to_string_lossy().into_owned();
        for suffix in ["", "-2", "-3"] {
            let (folder, manifest) = claim_new(&name)?;
            assert_eq!(folder, PathBuf::from(format!("{name}{suffix}")));
            assert!(manifest.exists());
        }
        Ok(())
    }
}
