//! A sample: its hash, its run, and its file.

use super::EnsembleError;
use crate::context::Context;
use crate::variables::known;
use cofferdam_assembly::build_info::SOURCES;
use cofferdam_assembly::observer::{HistoriesWriter, Limits, Rest};
use cofferdam_assembly::simulation::crest_at_rest;
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::units::DAM;
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::observer::{Observer, Status, Until};
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_fmi::import::sha256_of;
use cofferdam_log::Log;
use cofferdam_motion::Component;
use cofferdam_report::{Quantity, Summary};
use cofferdam_scene::{LoadedScene, Scene, Source};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::Permissions;
use std::num::NonZeroUsize;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use tempfile::NamedTempFile;

/// The kept results of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// Status at the end.
    pub status: String,
    /// Simulated time that it reached, s.
    pub simulated_time: f64,
    /// Warnings of the run, without those of its scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The quantities of its table.
    pub quantities: Vec<Quantity>,
}

impl Kept {
    /// Whether the run reached its end.
    pub fn is_complete(&self) -> bool {
        self.status == Status::Completed.to_string()
    }

    /// The value of a quantity, NaN where the run has none.
    pub fn value(&self, name: &str) -> f64 {
        self.quantities.iter().find(|number| number.name == name).map_or(f64::NAN, |number| number.value)
    }
}

/// Contents of the files that scenes refer to, each read once.
#[derive(Default)]
pub struct Contents(Mutex<BTreeMap<PathBuf, String>>);

impl Contents {
    /// SHA-256 of an FMU or of a run's log.
    fn of(&self, source: Source<'_>) -> Result<String, EnsembleError> {
        let Some(path) = source.file() else { return Ok(String::new()) };
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(hash) = known.get(path) {
            return Ok(hash.clone());
        }
        let file = if matches!(source, Source::Log(_)) { Log::file(path) } else { path.to_owned() };
        let hash = sha256_of(&file).map_err(|cause| EnsembleError::Unreadable { path: file, cause })?;
        known.insert(path.to_owned(), hash.clone());
        Ok(hash)
    }
}

/// Hash of the inputs of a sample: SHA-256 of this program's sources, the scene with all its defaults, the files of other programs' units
/// and past runs, and the motion, independent of the paths of the files.
pub fn hash(loaded: &LoadedScene, contents: &Contents) -> Result<String, EnsembleError> {
    let mut hash = Sha256::new();
    let scene =
        toml::to_string(&anywhere(&loaded.scene)).map_err(|cause| EnsembleError::Format(cause.into()))?;
    hash.update(format!("{}\n{scene}", SOURCES));
    for source in loaded.scene.sources() {
        hash.update(contents.of(source)?);
    }
    for sample in loaded.ground_motion.components().flat_map(Component::acceleration) {
        hash.update(sample.to_le_bytes());
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// A scene whose files have their names alone.
fn anywhere(scene: &Scene) -> Scene {
    let name = |path: &mut PathBuf| *path = path.file_name().map_or_else(PathBuf::new, PathBuf::from);
    let mut scene = scene.clone();
    scene.ground_motion.files_mut().for_each(name);
    if let Some(dam) = &mut scene.dam {
        dam.mesh.iter_mut().for_each(|mesh| name(&mut mesh.file));
        dam.fmu.iter_mut().for_each(|fmu| name(&mut fmu.file));
        dam.log.iter_mut().for_each(|log| name(&mut log.file));
    }
    for water in std::iter::once(&mut scene.reservoir).chain(&mut scene.tailwater) {
        water.fmu.iter_mut().for_each(|fmu| name(&mut fmu.file));
        water.log.iter_mut().for_each(|log| name(&mut log.file));
    }
    scene
}

/// Runs a scene in this process, up to `until` (s) if that is given, or until it is `interrupted`, and keeps its table.
///
/// **Errors**: a unit cannot be made or an observer fails. A failure of the coupling is the run's status.
pub fn run(
    loaded: &LoadedScene,
    context: &Context<'_>,
    threads: NonZeroUsize,
    until: Option<f64>,
    interrupted: &AtomicBool,
) -> Result<Kept, EnsembleError> {
    let mut scene = loaded.scene.clone();
    if let Some(dam) = &mut scene.dam {
        // Nobody reads them.
        dam.envelopes = false;
    }
    let scene = &scene;
    let mut graph = Assembly::with(scene, context.making(threads)).graph()?;
    let mut stress_points = Vec::new();
    for name in ["stress_point_x", "stress_point_y"] {
        stress_points.push(known(graph[DAM].read(name)).map_err(AssemblyError::from)?);
    }
    let stress_points: Vec<[f64; 2]> =
        stress_points[0].iter().zip(&stress_points[1]).map(|(x, y)| [*x, *y]).collect();
    let wrong = |cause| EnsembleError::Run { title: scene.title.clone(), cause: Box::new(cause) };
    let mut simulation = simulation_of(scene, &loaded.ground_motion, graph).map_err(wrong)?;
    let (mut histories, mut rest) = (HistoriesWriter::in_memory(), Rest::new(&scene.time));
    let (mut limits, mut end) = (Limits::new(&scene.stop), Until::new(until));
    let mut observers: Vec<&mut dyn Observer> = vec![&mut histories, &mut limits, &mut rest, &mut end];
    let (ending, failure) = simulation.run(&mut observers, interrupted);
    if let Some(error @ (SimulationError::Observer(_) | SimulationError::State(_))) = failure {
        return Err(wrong(error));
    }
    let crest = crest_at_rest(&simulation);
    let mut summary =
        Summary::of(loaded, &histories.histories, &ending, crest, &stress_points, [&[], &[]], &[]);
    summary.add_equilibria(&loaded.scene, &Assembly::of(&loaded.scene).equilibria()?);
    let of_scene: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    let warnings = summary.notes.iter().filter_map(|note| note.strip_prefix("WARNING: "));
    Ok(Kept {
        warnings: warnings.filter(|said| !of_scene.iter().any(|of| of == said)).map(str::to_owned).collect(),
        status: summary.status,
        simulated_time: summary.simulated_time,
        quantities: summary.quantities,
    })
}

/// The file of a sample in the ensemble's folder.
pub fn path(folder: &Path, hash: &str) -> PathBuf {
    folder.join("samples").join(format!("{hash}.toml"))
}

/// The last line of a sample's file: TOML that is cut short between two keys is TOML still.
const END: &str = "# end\n";

/// The kept results of a sample; `None` if it has not been run or its file is damaged.
pub fn kept(folder: &Path, hash: &str) -> Option<Kept> {
    let text = std::fs::read_to_string(path(folder, hash)).ok()?;
    toml::from_str(text.strip_suffix(END)?).ok()
}

/// A file in `folder` that is written and then gets its name; who may read it is the user's choice, by the umask.
pub fn beside(folder: &Path, prefix: &str) -> std::io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(prefix).permissions(Permissions::from_mode(0o666)).tempfile_in(folder)
}

/// Keeps what a sample gave: whole or not at all, whoever else writes it.
pub fn keep(folder: &Path, hash: &str, kept: &Kept) -> Result<(), EnsembleError> {
    let path = path(folder, hash);
    let failed = |cause: std::io::Error| EnsembleError::File { path: path.clone(), cause: cause.into() };
    let text = toml::to_string(kept).map_err(|cause| EnsembleError::Format(cause.into()))?;
    let beside = beside(path.parent().unwrap_or(folder), ".tmp").map_err(failed)?;
    std::fs::write(beside.path(), text + END).map_err(failed)?;
    beside.persist(&path).map_err(|error| failed(error.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_assembly::read_scene;

    #[test]
    fn a_sample_is_another_if_a_file_is_and_the_same_elsewhere() {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/koyna-coarse");
        let place = tempfile::tempdir().expect("a folder");
        let hash_in = |folder: &str, content: &str| {
            let folder = place.path().join(folder);
            std::fs::create_dir_all(&folder).expect("a folder");
            let file = folder.join("water.fmu");
            std::fs::write(&file, content).expect("a file");
            let set = [
                "reservoir.fidelity=\"fmu\"".to_owned(),
                format!("reservoir.fmu={{file={:?}}}", file.display().to_string()),
            ];
            let loaded = read_scene(scene.as_ref(), &set).expect("a scene");
            hash(&loaded, &Contents::default()).expect("a hash")
        };
        let first = hash_in("a", "one");
        assert_eq!(first, hash_in("b", "one"));
        assert_ne!(first, hash_in("a", "another"));
    }

    #[test]
    fn a_sample_comes_back_bit_for_bit_and_a_torn_one_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("samples")).expect("a folder");
        let number = |value| Quantity {
            name: "peak, \"x\"".into(),
            value,
            unit: "mm".into(),
            time: Some(0.7),
            ..Quantity::default()
        };
        let sample = Kept {
            status: "completed".into(),
            simulated_time: 0.1 + 0.2,
            warnings: vec!["the pressure falls".into()],
            quantities: vec![number(1.0 / 3.0), number(-5e-324), number(1e300)],
        };
        keep(folder.path(), "a", &sample).expect("a file");
        assert_eq!(kept(folder.path(), "a"), Some(sample));
        assert_eq!(kept(folder.path(), "b"), None);
        let whole = std::fs::read(path(folder.path(), "a")).expect("a file");
        for torn in 0..whole.len() {
            std::fs::write(path(folder.path(), "b"), &whole[..torn]).expect("a file");
            assert_eq!(kept(folder.path(), "b"), None, "{torn} bytes");
        }
    }
}
