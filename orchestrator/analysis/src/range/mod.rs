//! The range of the results of a scene: over choices of the model, numerics, and what is unknown about the motion, one at a time and
//! all together.

mod factor;
mod figure;
mod plan;
mod quantities;
mod records;
mod results;
mod setting;
mod text;

use crate::context::Context;
use crate::parallel;
use crate::progress::Watch;
use crate::run::NOISE;
use crate::study::{self, Outcome, StudyError, StudyFolder, unfit};
use cofferdam_assembly::observer::{SLID_AWAY, SLIDES_AWAY};
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_report::{FactorKind, FailedRun, LeftOut, RangeRecord};
use cofferdam_scene::{DamFidelityScene, LoadedScene, Scene, SceneError};
use factor::Subject;
use plan::{Part, Planned};
use quantities::Results;
use setting::Factor;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Request of a range.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The scene, a file or a folder.
    pub scene: &'a Path,
    /// Changes of the scene.
    pub set: &'a [String],
    /// Folder for tables and figures; must be empty.
    pub output: &'a Path,
    /// Runs of the joint sample; 0 for one factor at a time only.
    pub samples: usize,
    /// Seed of the joint sample and of the noise.
    pub seed: u64,
    /// Perturbed replicates of the scene as it is.
    pub replicates: usize,
    /// Other records, `FILE` or `FILE,VERTICAL`.
    pub records: &'a [PathBuf],
    /// Whether a dam of elements keeps them, instead of reduced blocks.
    pub keep_fidelity: bool,
    /// Runs at the same time.
    pub threads: NonZeroUsize,
}

/// The runs of a scene: what they have in common.
struct Base {
    /// The scene as it is read, for the record.
    given: Scene,
    /// The scene that is varied.
    loaded: LoadedScene,
    /// The changes by which it is read.
    sets: Vec<String>,
    /// What is said of the model of the dam.
    model: String,
}

/// Runs a scene with one factor changed at a time and with all of them together, and writes tables, figures and `range.toml`.
///
/// Results do not depend on the number of threads. The text of `range.md` is reported as a line.
///
/// **Errors**: [`StudyError`], before any run if scene or options are wrong. A failure of the scene as it is ends the study; any other run
/// that fails is named and counted.
pub fn run(request: &Request<'_>, context: &Context<'_>) -> Result<RangeRecord, StudyError> {
    let base = Base::read(request)?;
    let records = records::read(request.records, &base.loaded)?;
    let half_step = base.half_step()?;
    let (replicates, loaded) = (request.replicates, &base.loaded);
    let subject = Subject { loaded, half_step, replicates, records: &records };
    let (factors, mut left_out) = factor::of(&subject);
    let planned =
        base.valid(request, plan::one_at_a_time(&factors, request.seed), &factors, &mut left_out)?;
    let folder = StudyFolder { path: request.output };
    folder.claim()?;
    for LeftOut { what, reason } in &left_out {
        context.line(format!("left out: {what}: {reason}"));
    }
    let joint = plan::joint(&factors, request.samples, request.seed);
    context.line(format!(
        "{}: {} runs: the scene as it is, {} with one change, {} of the joint sample",
        base.model,
        planned.len() + joint.len(),
        planned.len() - 1,
        joint.len()
    ));
    let mut runs = planned.into_iter().chain(joint);
    let mut finished = Vec::new();
    // Alone and first: if it fails, nothing else is worth its time.
    if let Some(first) = runs.next() {
        let (scene, outcome) = base.outcome(request, &first, request.threads, context)?;
        let results = quantities::of(&scene, &outcome.completed(&first.name)?);
        finished.push((first, Some(results)));
    }
    let (more, failed) = base.run_all(request, runs.collect(), context)?;
    finished.extend(more);
    let quantities = results::ranges(&factors, &finished);
    let record = RangeRecord {
        name: base.loaded.name.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model: base.model.clone(),
        samples: request.samples,
        seed: request.seed,
        runs: finished.len(),
        failed,
        notes: notes(&base.loaded, &finished),
        factors: factors.iter().map(|factor| factor.about.clone()).collect(),
        left_out,
        quantities,
        scene: base.given,
    };
    let markdown = text::markdown(&record, &study::quoted(request.scene));
    folder.write_table("range.csv", &text::runs(&factors, &finished, &record), context)?;
    for quantity in &record.quantities {
        let picture = study::svg(figure::size(quantity), |area| figure::draw(area, quantity))?;
        folder.write(&text::figure_name(&quantity.name), &picture, context)?;
    }
    let toml = toml::to_string(&record).map_err(|cause| StudyError::File {
        path: request.output.join(RangeRecord::FILE),
        cause: cause.into(),
    })?;
    folder.write(RangeRecord::FILE, &toml, context)?;
    folder.write("range.md", &markdown, context)?;
    context.line(format!("\n{markdown}"));
    Ok(record)
}

impl Base {
    /// Reads the scene, reduced if its dam has elements and need not keep them.
    fn read(request: &Request<'_>) -> Result<Self, StudyError> {
        let mut sets = request.set.to_vec();
        let mut loaded = read_scene(request.scene, &sets)?;
        let given = loaded.scene.clone();
        let Some(dam) = &given.dam else {
            return Err(unfit("a range needs a dam that can respond: the scene has [prescribed]"));
        };
        if given.is_open_loop() {
            return Err(unfit(
                "a range needs units that respond to changes: one of the scene's repeats a recorded run",
            ));
        }
        let can_be_reduced = dam.fidelity == DamFidelityScene::Dem && !dam.cracks.is_empty();
        let mut model = format!("dam.fidelity = \"{}\", as in the scene", dam.fidelity.word());
        if can_be_reduced && !request.keep_fidelity {
            if dam.damping.model.supports_modes() {
                sets.push("dam.fidelity=\"reduced\"".to_owned());
                loaded = read_scene(request.scene, &sets)?;
                model = "dam.fidelity = \"reduced\" in place of \"dem\"; the row `model of the dam` has its error".to_owned();
            } else {
                model += ", because local damping is not available with modes";
            }
        }
        Ok(Self { given, loaded, sets, model })
    }

    /// `dam.time_step_safety` for half the time step of the dam, if it is computed with cracks.
    fn half_step(&self) -> Result<Option<f64>, StudyError> {
        let scene = &self.loaded.scene;
        let cracked = |dam: &&cofferdam_scene::DamScene| !dam.cracks.is_empty() && !dam.fidelity.is_intact();
        match scene.computed_dam().filter(cracked) {
            Some(_) => Ok(Some(Assembly::of(scene).safety_of_part(2.0)?)),
            None => Ok(None),
        }
    }

    /// The scene of a run, with its motion.
    fn scene(&self, request: &Request<'_>, run: &Planned) -> Result<LoadedScene, SceneError> {
        let sets: Vec<String> = self.sets.iter().chain(&run.sets).cloned().collect();
        let mut loaded = read_scene(request.scene, &sets)?;
        if let Some(seed) = run.noise() {
            loaded.ground_motion = loaded.ground_motion.with_noise(NOISE, seed);
        }
        if let Some(dam) = &mut loaded.scene.dam {
            // Nobody reads them.
            dam.envelopes = false;
        }
        Ok(loaded)
    }

    /// The runs whose scene is valid; settings that make it invalid join what is `left_out`.
    ///
    /// **Errors**: a record that the user gave makes the scene invalid.
    fn valid(
        &self,
        request: &Request<'_>,
        planned: Vec<Planned>,
        factors: &[Factor],
        left_out: &mut Vec<LeftOut>,
    ) -> Result<Vec<Planned>, StudyError> {
        let mut valid = Vec::new();
        for run in planned {
            let of_user =
                matches!(run.part, Part::Alone(index) if factors[index].about.kind == FactorKind::Records);
            match self.scene(request, &run) {
                Ok(_) => valid.push(run),
                Err(error) if of_user => return Err(error.into()),
                Err(error) => left_out.push(LeftOut { what: run.name, reason: cause(&error) }),
            }
        }
        Ok(valid)
    }

    /// Runs a scene in memory.
    ///
    /// **Errors**: the scene, a unit, or an observer; a failure of the coupling comes with the outcome.
    fn outcome(
        &self,
        request: &Request<'_>,
        run: &Planned,
        threads: NonZeroUsize,
        context: &Context<'_>,
    ) -> Result<(Scene, Outcome), StudyError> {
        let loaded = self.scene(request, run)?;
        let outcome = study::run_scene(&loaded.scene, &loaded.ground_motion, threads, context)?;
        Ok((loaded.scene, outcome))
    }

    /// The results of a run, or why it failed.
    ///
    /// **Errors**: an observer, or the state of a unit, which no scene is to blame for.
    fn results(
        &self,
        request: &Request<'_>,
        run: &Planned,
        context: &Context<'_>,
    ) -> Result<Result<Results, String>, StudyError> {
        match self.outcome(request, run, NonZeroUsize::MIN, context) {
            Ok((scene, outcome)) => {
                let results = quantities::of(&scene, &outcome);
                // The coupling of a dam that slides away fails sooner or later.
                let failure = outcome.failure.filter(|_| results.away.is_empty());
                Ok(failure.map_or(Ok(results), |cause| Err(cause.to_string())))
            }
            Err(StudyError::Scene(error)) => Ok(Err(cause(&error))),
            Err(StudyError::Unit(cause)) => Ok(Err(cause.to_string())),
            Err(error) => Err(error),
        }
    }

    /// Runs all, long ones first, and returns them in their order, with the causes of those that failed.
    fn run_all(
        &self,
        request: &Request<'_>,
        planned: Vec<Planned>,
        context: &Context<'_>,
    ) -> Result<(Vec<results::Finished>, Vec<FailedRun>), StudyError> {
        let mut order: Vec<usize> = (0..planned.len()).collect();
        order.sort_by(|a, b| planned[*b].cost.total_cmp(&planned[*a].cost));
        let watch = Watch::new(planned.len(), context);
        let mut done = parallel::try_map(&order, request.threads, |index| {
            let results = self.results(request, &planned[*index], context)?;
            watch.tell(results.is_ok());
            Ok::<_, StudyError>((*index, results))
        })?;
        watch.end();
        done.sort_by_key(|(index, _)| *index);
        let (mut finished, mut failed) = (Vec::new(), Vec::new());
        for (run, (_, results)) in planned.into_iter().zip(done) {
            let results = results.map_err(|cause| {
                context.warning(format!("WARNING: {} failed: {cause}", run.name));
                failed.push(FailedRun { run: run.name.clone(), cause });
            });
            finished.push((run, results.ok()));
        }
        Ok((finished, failed))
    }
}

/// The first problem of a scene.
fn cause(error: &SceneError) -> String {
    error.problems.first().map_or_else(|| error.to_string(), ToString::to_string)
}

/// What is doubtful about the runs.
fn notes(loaded: &LoadedScene, finished: &[results::Finished]) -> Vec<String> {
    let mut notes = Vec::new();
    let complete = || finished.iter().filter_map(|(run, results)| Some((run, results.as_ref()?)));
    let moving = complete().filter(|(_, results)| !results.at_rest).count();
    if moving > 0 {
        let remedy = match loaded.scene.time.longest_quiet {
            None => "set `time.longest_quiet`",
            Some(_) => "increase `time.longest_quiet`",
        };
        notes.push(format!(
            "in {moving} of {} runs a block was not at rest at the end; their residual sliding is the mean over the last second: {remedy}",
            complete().count()
        ));
    }
    let away: Vec<String> = complete()
        .filter(|(_, results)| !results.away.is_empty())
        .map(|(run, results)| format!("{} ({})", run.name, results.away.join(", ")))
        .collect();
    if !away.is_empty() {
        notes.push(format!(
            "in {} of {} runs a joint slides away: more than {SLID_AWAY} m, or faster than {} mm/s at the end. Their sliding counts as \
             infinite, and their other quantities are left out: {}",
            away.len(),
            complete().count(),
            1e3 * SLIDES_AWAY,
            away.join("; ")
        ));
    }
    for (run, results) in complete() {
        notes.extend(results.doubts.iter().map(|doubt| format!("{}: {doubt}", run.name)));
    }
    if !loaded.scene.stop.is_empty() {
        notes.push("the limits of [[stop]] do not apply to these runs".to_owned());
    }
    notes
}

#[cfg(test)]
mod tests;
