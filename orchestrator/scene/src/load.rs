use super::conform::Conformed;
use super::document::{Node, Place};
use super::validate::Shaking;
use super::{
    Invalid, Scene, SceneError, SceneProblem, SceneWarning, Side, UnitChecks, foreign, validate, version,
    warning,
};
use cofferdam_motion::text_file;
use cofferdam_motion::{Component, GroundMotion, RecordFile};
use miette::NamedSource;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene, read, completed by its defaults and found valid.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Name of the case: its folder's name.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// The scene with all defaults.
    pub scene: Scene,
    /// What moves the ground.
    pub ground_motion: GroundMotion,
    /// What is doubtful about it.
    pub warnings: Vec<SceneWarning>,
    /// Defaults that it takes and that have moved since the version that it names, each in a sentence.
    pub moved_defaults: Vec<String>,
}

impl LoadedScene {
    /// Reads the scene at `path`: a `.toml` file, also the manifest of a run, or a folder that holds `scene.toml` or
    /// `manifest.toml`.
    ///
    /// Each of `overrides`, `key=value` such as `dam.element_size=2.5`, takes the place of what is written there;
    /// what is wrong with it is shown in the override itself. `units` are asked whether they can be made.
    ///
    /// **Errors**: every problem of the scene at once, each at its place, in the order of the lines.
    pub fn read(path: &Path, overrides: &[String], units: &UnitChecks) -> Result<Self, SceneError> {
        let [scene, manifest] = ["scene.toml", "manifest.toml"].map(|name| path.join(name));
        let file = match path.is_dir() {
            false => path.to_owned(),
            true if manifest.exists() && !scene.exists() => manifest,
            true => scene,
        };
        let source = text_file::read(&file).map_err(|cause| {
            SceneError::without_place(&file, Invalid::Unreadable { path: file.clone(), cause })
        })?;
        let mut draft = Draft::new(&file, &source, overrides);
        let Some(mut scene) = draft.scene.take() else { return Err(draft.error()) };
        let folder = file.parent().unwrap_or(Path::new(""));
        let unsound = std::mem::take(&mut draft.conformed.unsound);
        let (findings, shaking) = validate::judge(&scene, folder, unsound, units);
        draft.add(findings);
        let Shaking { motion: ground_motion, shocks } = match shaking {
            Some(shaking) if draft.problems.is_empty() => shaking,
            _ => return Err(draft.error()),
        };
        resolve(&mut scene, &ground_motion, &shocks, folder);
        let warnings = draft.warnings(&scene, &ground_motion);
        let given = |key: &str| draft.conformed.places.contains_key(key);
        let moved_defaults = version::moved(scene.scene_version, given);
        let name = draft.name.take().unwrap_or_else(|| name(&file, folder));
        Ok(Self { name, path: file, scene, ground_motion, warnings, moved_defaults })
    }

    /// The scene of a log, `source` with all defaults, under the ground motion of that run; `file` is what its warnings name.
    ///
    /// **Errors**: as [`Scene::resolved`].
    pub fn of_log(
        name: String,
        source: &str,
        overrides: &[String],
        file: &Path,
        ground_motion: GroundMotion,
    ) -> Result<Self, SceneError> {
        let mut draft = Draft::new(file, source, overrides);
        let Some(scene) = draft.scene.take() else { return Err(draft.error()) };
        let unsound = std::mem::take(&mut draft.conformed.unsound);
        draft.add(validate::judge_without_record(&scene, unsound));
        if !draft.problems.is_empty() {
            return Err(draft.error());
        }
        let warnings = draft.warnings(&scene, &ground_motion);
        Ok(Self { name, path: file.to_owned(), scene, ground_motion, warnings, moved_defaults: Vec::new() })
    }

    /// Number of communication steps that reach the end of the simulated time.
    pub fn steps(&self) -> u64 {
        self.scene.steps()
    }
}

impl Scene {
    /// A scene with all defaults, as logs and manifests hold it, with `overrides` as in [`LoadedScene::read`]; its
    /// record is not read. `file` is what problems name.
    ///
    /// **Errors**: as [`LoadedScene::read`], but for those of the record.
    pub fn resolved(source: &str, overrides: &[String], file: &Path) -> Result<Self, SceneError> {
        let mut draft = Draft::new(file, source, overrides);
        let Some(scene) = draft.scene.take() else { return Err(draft.error()) };
        let unsound = std::mem::take(&mut draft.conformed.unsound);
        draft.add(validate::judge_without_record(&scene, unsound));
        if draft.problems.is_empty() { Ok(scene) } else { Err(draft.error()) }
    }
}

/// A scene that has its shape, and what was wrong so far.
struct Draft<'a> {
    file: &'a Path,
    texts: Texts,
    /// Name of the case, where the text is a manifest.
    name: Option<String>,
    /// `None` where too little is left of it.
    scene: Option<Scene>,
    conformed: Conformed,
    problems: Vec<(Place, Invalid)>,
}

impl<'a> Draft<'a> {
    fn new(file: &'a Path, source: &str, overrides: &[String]) -> Self {
        let texts = Texts::new(file, source, overrides);
        let (tree, mut problems) = Node::read(source);
        let (mut name, mut scene, mut conformed) = (None, None, Conformed::default());
        if let Some((of_case, mut tree)) = tree.map(Node::of_manifest) {
            name = of_case;
            for (index, text) in overrides.iter().enumerate() {
                if tree.set(text, index + 1).is_none() {
                    let place = Place { text: index + 1, start: 0, end: text.len() };
                    problems.push((place, Invalid::Override { text: text.clone() }));
                }
            }
            let folder = file.parent().unwrap_or(Path::new(""));
            problems.append(&mut super::mesh::complete(&mut tree, folder));
            (scene, conformed) = Conformed::read(&tree);
            let cracks = scene.iter_mut().filter_map(|scene: &mut Scene| scene.dam.as_mut());
            let cracks = cracks.flat_map(|dam| dam.cracks.iter_mut().enumerate());
            cracks.for_each(|(number, crack)| crack.number = number);
            problems.append(&mut conformed.problems);
        }
        Self { file, texts, name, scene, conformed, problems }
    }

    fn add(&mut self, findings: Vec<(String, Invalid)>) {
        let place = |(key, invalid): (String, Invalid)| (self.conformed.place(&key), invalid);
        self.problems.extend(findings.into_iter().map(place));
    }

    /// What is doubtful, in the order of the lines.
    fn warnings(&self, scene: &Scene, ground_motion: &GroundMotion) -> Vec<SceneWarning> {
        let doubts = warning::doubts(scene, ground_motion).into_iter();
        let mut doubts: Vec<_> = doubts.map(|(key, warning)| (self.conformed.place(&key), warning)).collect();
        doubts.sort_by(|a, b| a.0.cmp(&b.0));
        doubts.into_iter().map(|(place, warning)| self.texts.warning(&place, warning)).collect()
    }

    fn error(mut self) -> SceneError {
        self.problems.sort_by(|a, b| a.0.cmp(&b.0));
        let problems = self.problems.into_iter().map(|(place, invalid)| self.texts.problem(&place, invalid));
        SceneError { path: self.file.to_owned(), problems: problems.collect() }
    }
}

/// Fills in what follows from the rest, so that the scene stands for itself and can be run from anywhere.
fn resolve(scene: &mut Scene, ground_motion: &GroundMotion, shocks: &[GroundMotion], folder: &Path) {
    scene.time.duration = Some(validate::duration(scene, ground_motion));
    scene.coupling.scheme = Some(scene.scheme());
    for water in std::iter::once(&mut scene.reservoir).chain(&mut scene.tailwater) {
        foreign::resolve(folder, (&mut water.fmu, &mut water.command, &mut water.log));
    }
    if let Some(dam) = &mut scene.dam {
        foreign::resolve(folder, (&mut dam.fmu, &mut dam.command, &mut dam.log));
        if let Some(mesh) = &mut dam.mesh {
            let file = folder.join(&mesh.file);
            mesh.file = file.canonicalize().unwrap_or(file);
        }
        // The order in which the dam's results come.
        dam.cracks.sort_by(|a, b| a.mean_elevation().total_cmp(&b.mean_elevation()));
    }
    for side in Side::BOTH {
        let (size, distance) = (scene.boundary_element_size(side), scene.far_end_distance(side));
        let water = match side {
            Side::Upstream => Some(&mut scene.reservoir),
            Side::Downstream => scene.tailwater.as_mut(),
        };
        if let Some(water) = water.filter(|water| water.fidelity.is_solved()) {
            (water.element_size, water.far_end_distance) = (Some(size), Some(distance));
        }
    }
    for ((record, vertical), shock) in scene.ground_motion.shocks_mut().zip(shocks) {
        let shares_file = vertical.as_ref().is_some_and(|vertical| vertical.file.is_none());
        let file = folder.join(&record.file);
        record.file = file.canonicalize().unwrap_or(file);
        record.column = record.column.or(shares_file.then_some(1));
        if let Some(RecordFile { units, sha256 }) = shock.file() {
            (record.units, record.sha256) = (Some(*units), Some(sha256.clone()));
        }
        if let Some(vertical) = vertical {
            let file = vertical.file.as_ref().map(|file| folder.join(file));
            let file = file.map(|file| file.canonicalize().unwrap_or(file));
            vertical.file = Some(file.unwrap_or_else(|| record.file.clone()));
            if let Some(RecordFile { units, sha256 }) = shock.vertical().and_then(Component::file) {
                (vertical.units, vertical.sha256) = (Some(*units), Some(sha256.clone()));
            }
        }
    }
}

fn name(file: &Path, folder: &Path) -> String {
    let folder_name =
        folder.canonicalize().ok().and_then(|f| Some(f.file_name()?.to_string_lossy().into_owned()));
    let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned());
    stem.filter(|s| s != "scene").or(folder_name).unwrap_or_else(|| "scene".to_owned())
}

/// The file and the overrides, as they are shown.
struct Texts(Vec<NamedSource<Arc<String>>>);

impl Texts {
    fn new(file: &Path, source: &str, overrides: &[String]) -> Self {
        let named =
            |name: &str, text: &str| NamedSource::new(name, Arc::new(text.to_owned())).with_language("TOML");
        let first = named(&file.to_string_lossy(), source);
        Self(std::iter::once(first).chain(overrides.iter().map(|text| named("--set", text))).collect())
    }

    fn problem(&self, place: &Place, invalid: Invalid) -> SceneProblem {
        let span = Some((place.start..place.end).into());
        SceneProblem { invalid, source_code: self.0[place.text].clone(), span }
    }

    fn warning(&self, place: &Place, warning: super::Warning) -> SceneWarning {
        let span = (place.start..place.end).into();
        SceneWarning { warning, source_code: self.0[place.text].clone(), span }
    }
}
