//! A sample: its hash, its run, and its file.

use super::EnsembleError;
use crate::cli::{known, making};
use crate::registry;
use orchestrator::observer::{HistoriesWriter, Limits, Observer, Rest, Status, Until};
use orchestrator::report::{Quantity, Summary};
use orchestrator::scene::LoadedScene;
use orchestrator::scheme::UnitId;
use orchestrator::simulation::{Simulation, SimulationError};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// What is kept of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// How it ended.
    pub status: String,
    /// Simulated time that it reached, s.
    pub simulated_time: f64,
    /// What it warned of; not what its scene warns of.
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

/// What a sample is computed from: SHA-256 of this program's sources, the scene with all its defaults, and the motion; not of where
/// the files lie.
pub fn hash(loaded: &LoadedScene) -> Result<String, EnsembleError> {
    let mut scene = loaded.scene.clone();
    if let Some(record) = &mut scene.ground_motion.record {
        record.file = record.file.file_name().map_or_else(PathBuf::new, PathBuf::from);
    }
    let scene = toml::to_string(&scene).map_err(|cause| EnsembleError::Format(cause.into()))?;
    let mut hash = Sha256::new();
    hash.update(format!("{}\n{scene}", env!("COFFERDAM_SOURCES")));
    for sample in loaded.ground_motion.acceleration() {
        hash.update(sample.to_le_bytes());
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Runs a scene in this process, up to `until` (s) if that is given, or until it is `interrupted`, and keeps its table.
///
/// **Errors**: a unit cannot be made or an observer fails. A failure of the coupling is the run's status.
pub fn run(
    loaded: &LoadedScene,
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
    let mut graph = registry::graph(scene, making(threads))?;
    let mut stress_points = Vec::new();
    for name in ["stress_point_x", "stress_point_y"] {
        stress_points.push(known(graph[UnitId::DAM].read(name)).map_err(registry::RegistryError::from)?);
    }
    let stress_points: Vec<[f64; 2]> =
        stress_points[0].iter().zip(&stress_points[1]).map(|(x, y)| [*x, *y]).collect();
    let wrong = |cause| EnsembleError::Run { title: scene.title.clone(), cause: Box::new(cause) };
    let mut simulation = Simulation::of_scene(scene, &loaded.ground_motion, graph).map_err(wrong)?;
    let (mut histories, mut rest) = (HistoriesWriter::in_memory(), Rest::new(&scene.time));
    let (mut limits, mut end) = (Limits::new(&scene.stop), Until::new(until));
    let mut observers: Vec<&mut dyn Observer> = vec![&mut histories, &mut limits, &mut rest, &mut end];
    let (ending, failure) = simulation.run(&mut observers, interrupted);
    if let Some(error @ (SimulationError::Observer(_) | SimulationError::State(_))) = failure {
        return Err(wrong(error));
    }
    let crest = simulation.static_crest_displacement;
    let mut summary =
        Summary::of(loaded, &histories.histories, &ending, crest, &stress_points, [&[], &[]], &[]);
    summary.add_equilibria(&loaded.scene, &registry::equilibria(&loaded.scene)?);
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

/// What was kept of a sample; none if it has not been run or its file is damaged.
pub fn kept(folder: &Path, hash: &str) -> Option<Kept> {
    let text = std::fs::read_to_string(path(folder, hash)).ok()?;
    toml::from_str(text.strip_suffix(END)?).ok()
}

/// Keeps what a sample gave: whole or not at all, whoever else writes it.
pub fn keep(folder: &Path, hash: &str, kept: &Kept) -> Result<(), EnsembleError> {
    let path = path(folder, hash);
    let failed = |cause: std::io::Error| EnsembleError::File { path: path.clone(), cause: cause.into() };
    let text = toml::to_string(kept).map_err(|cause| EnsembleError::Format(cause.into()))?;
    let beside = tempfile::NamedTempFile::new_in(path.parent().unwrap_or(folder)).map_err(failed)?;
    std::fs::write(beside.path(), text + END).map_err(failed)?;
    beside.persist(&path).map_err(|error| failed(error.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

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
