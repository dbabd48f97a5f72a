//! Ensembles: many runs of a scene, and their statistics.

use cofferdam_assembly::{Assembly, AssemblyError, read_scene};
mod figure;
mod folder;
mod joints;
mod limits;
mod manifest;
mod methods;
mod plan;
mod polarities;
mod runs;
pub mod sample;
mod tables;
mod target;
mod variance;
mod write;

pub use plan::{Intensity, Limit, Measure, Perturbation, Plan, RecordEntry, Sample, Target, Variation};

use crate::context::Context;
use crate::parallel;
use crate::progress::Watch;
use crate::statistics::is_apart;
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_motion::{Component, Excerpt, GroundMotion, RecordError, TargetError};
use cofferdam_report::page::{self, PageError};
use cofferdam_scene::{LoadedScene, Scene, SceneError};
use folder::{added, keep_added, take_folder};
use miette::Diagnostic;
use runs::Runs;
use sample::{Contents, Kept};
use std::error::Error;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::AtomicBool;
use target::Scaled;

/// Request of an ensemble: plan and output.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The file that says what is varied.
    pub plan: &'a Path,
    /// Folder for samples, tables and pictures. Samples that lie in it already are not run again.
    pub output: &'a Path,
    /// The share of the samples that is run; with one, no tables are written.
    pub part: Option<Part>,
    /// Runs at the same time.
    pub threads: NonZeroUsize,
    /// Whether `report.html` is written.
    pub report: bool,
    /// Whether levels that curves lack are added to those of the plan; not with a part.
    pub add_levels: bool,
}

/// Result of an ensemble.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// Samples of the plan, or of the part.
    pub samples: usize,
    /// Number of samples that were run now.
    pub run: usize,
    /// The text of `ensemble.md`; none of a part.
    pub text: Option<String>,
}

/// A share of the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its number, from 0.
    pub number: usize,
    /// Number of shares.
    pub of: usize,
}

impl FromStr for Part {
    type Err = String;

    /// Reads such as `3/16`, which counts from 1.
    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(number, of)| {
            let (number, of) = (number.parse::<usize>().ok()?, of.parse::<usize>().ok()?);
            Some(Self { number: number.checked_sub(1)?, of })
        });
        let sound = parsed.filter(|part| part.number < part.of);
        sound.ok_or_else(|| "give two integers, the first between 1 and the second, such as 3/16".into())
    }
}

/// Reason why an ensemble ended early.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum EnsembleError {
    /// The plan.
    #[error("{}: {cause}", path.display())]
    Plan {
        /// The plan.
        path: PathBuf,
        /// The cause.
        cause: String,
    },
    /// A value of the plan.
    #[error("{}: `{key}` is {value}; {remedy}", path.display())]
    Value {
        /// The plan.
        path: PathBuf,
        /// The key.
        key: String,
        /// Its value.
        value: String,
        /// The remedy.
        remedy: String,
    },
    /// A record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The target spectrum.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The scene, with one of the samples' values.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A unit.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// A run that could not continue for an external reason.
    #[error("{title}: {cause}")]
    Run {
        /// Title of the scene.
        title: String,
        /// The cause.
        cause: Box<SimulationError>,
    },
    /// The levels that were added to the plan.
    #[error("{}: {cause}; correct the levels, or remove the file for those of the plan alone", path.display())]
    Added {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: String,
    },
    /// A folder with something else in it.
    #[error(
        "{} contains no ensemble or one of another plan; choose another --output, nothing is overwritten", path.display()
    )]
    OutputTaken {
        /// The folder.
        path: PathBuf,
    },
    /// A file.
    #[error("{}: {cause}; choose another --output", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: Box<dyn Error + Send + Sync>,
    },
    /// A file that a unit rests on.
    #[error("{}: {cause}; give a file that can be read", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: std::io::Error,
    },
    /// The page.
    #[error("the report: {0}")]
    Report(#[from] PageError),
    /// Numbers that cannot be written as text, or a picture that cannot be drawn.
    #[error("{0}; this is a bug in the program")]
    Format(Box<dyn Error + Send + Sync>),
}

/// An ensemble that is ready to be run.
struct Ensemble {
    plan: Plan,
    /// Levels that the plan has in addition to those of its file.
    added: Vec<f64>,
    /// The file's folder.
    folder: PathBuf,
    /// Name of the intensity measure.
    measure: String,
    /// Scaling of the records to a target spectrum.
    scaled: Option<Scaled>,
    samples: Vec<Sample>,
    /// SHA-256 of each.
    hashes: Vec<String>,
}

/// Runs the samples of a plan that its folder does not hold yet, and writes tables, pictures and page. Levels that were added to the plan before
/// belong to it.
///
/// Results do not depend on the number of threads, nor on interruptions, bit for bit. The text of `ensemble.md` is reported as a line.
///
/// **Errors**: [`EnsembleError`]. A run that fails is listed, and left out of the statistics.
pub fn run(request: &Request<'_>, context: &Context<'_>) -> Result<Done, EnsembleError> {
    let Request { plan: path, output, part, threads, report, add_levels } = *request;
    let (plan, text) = Plan::read(path)?;
    if add_levels && plan.limits.is_empty() {
        return Err(EnsembleError::Value {
            path: path.to_owned(),
            key: "limits".into(),
            value: "an empty list".into(),
            remedy: "give the limits whose curves lack levels, or leave out --add-levels".into(),
        });
    }
    let mut ensemble = Ensemble::of(plan, added(output)?, path, threads)?;
    ensemble.check_limits(path, threads, context)?;
    take_folder(output, &text)?;
    ensemble.warnings()?.iter().for_each(|warning| context.warning(format!("WARNING: {warning}")));
    let mut run = ensemble.run_missing(request, context)?;
    let mut done = Done { samples: ensemble.part(part).count(), run, text: None };
    if part.is_some() {
        context.line("the command without --part writes the tables when all parts are done");
        return Ok(done);
    }
    if add_levels {
        let new = ensemble.missing_levels(&ensemble.kept(output)?);
        if new.is_empty() {
            context.line("no levels are missing");
        } else {
            let names = limits::names(&new, &ensemble.plan.intensity).join(", ");
            context.line(format!("levels that are added: {names}"));
            let mut all = [&ensemble.added[..], &new].concat();
            all.sort_by(f64::total_cmp);
            let (plan, _) = Plan::read(path)?;
            ensemble = Ensemble::of(plan, all.clone(), path, threads)?;
            keep_added(output, &all)?;
            run += ensemble.run_missing(request, context)?;
            done = Done { samples: ensemble.samples.len(), run, text: None };
        }
    }
    let words = write::all(&ensemble, &ensemble.kept(output)?, &text, output, context)?;
    let page = if report { Some(page::file::write_ensemble(output)?) } else { None };
    let report = page.map_or("", |()| ", report.html");
    context.line(format!("tables, pictures{report} are in {}", output.display()));
    Ok(Done { text: Some(words), ..done })
}

impl Ensemble {
    /// Checks every sample's scene, of the plan of this file with levels that are added to it.
    fn of(
        mut plan: Plan,
        added: Vec<f64>,
        path: &Path,
        workers: NonZeroUsize,
    ) -> Result<Self, EnsembleError> {
        if !added.is_empty() {
            plan.intensity.add(&added);
            plan.check(path)?;
        }
        let mut ensemble = Self {
            plan,
            added,
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            measure: String::new(),
            scaled: None,
            samples: Vec::new(),
            hashes: Vec::new(),
        };
        ensemble.check_vertical()?;
        let Plan { records, intensity, .. } = &ensemble.plan;
        let motions = records.iter().map(|record| {
            let (start, end) = (record.start.unwrap_or(0.0), record.end.unwrap_or(f64::INFINITY));
            let (path, units, column) = (ensemble.folder.join(&record.file), record.units, record.column());
            Component::from_record(&Excerpt { column, units, start, end, ..Excerpt::whole(&path) })
                .map(GroundMotion::from)
        });
        let motions = motions.collect::<Result<Vec<_>, _>>()?;
        let period = match intensity {
            Intensity { measure: Measure::Sa, period: None, .. }
            | Intensity { target: Some(_), period: None, .. } => ensemble.first_period()?,
            Intensity { period, .. } => period.unwrap_or(f64::NAN),
        };
        let measures: Vec<f64> = motions.iter().map(|motion| intensity.of(motion, period)).collect();
        ensemble.measure = intensity.name(period);
        if let Some(target) = &intensity.target {
            let scaled = Scaled::to(target, &ensemble.folder, period, &motions)?;
            for (record, fit) in ensemble.plan.records.iter_mut().zip(&scaled.fits) {
                record.factor = fit.factor;
            }
            ensemble.scaled = Some(scaled);
        }
        ensemble.samples = ensemble.plan.samples(&measures);
        ensemble.check_sequence()?;
        let numbers: Vec<usize> = (0..ensemble.samples.len()).collect();
        let contents = Contents::default();
        let hash = |index: &usize| sample::hash(&ensemble.scene(*index)?, &contents);
        ensemble.hashes = parallel::try_map(&numbers, workers, hash)?;
        Ok(ensemble)
    }

    /// Numbers and hashes of the samples of a part, or of all.
    fn part(&self, part: Option<Part>) -> impl Iterator<Item = (usize, &String)> {
        let mine = move |index: usize| part.is_none_or(|part| index % part.of == part.number);
        self.hashes.iter().enumerate().filter(move |(index, _)| mine(*index))
    }

    /// Runs the samples that the output lacks; returns their number.
    fn run_missing(&self, request: &Request<'_>, context: &Context<'_>) -> Result<usize, EnsembleError> {
        let Request { output, part, threads, .. } = *request;
        let mut wanted: Vec<(usize, &String)> = self.part(part).collect();
        let all = wanted.len();
        // Equal samples are run once.
        let mut seen = std::collections::BTreeSet::new();
        wanted.retain(|(_, hash)| seen.insert(*hash) && sample::kept(output, hash).is_none());
        context.line(format!("{} samples, {} of them to be run", all, wanted.len()));
        let watch = Watch::new(wanted.len(), context);
        parallel::try_map(&wanted, threads, |(index, hash)| {
            let loaded = self.scene(*index)?;
            let kept = sample::run(&loaded, context, NonZeroUsize::MIN, None, &AtomicBool::new(false))?;
            sample::keep(output, hash, &kept)?;
            watch.tell(kept.is_complete());
            Ok::<_, EnsembleError>(())
        })?;
        watch.end();
        Ok(wanted.len())
    }

    /// The results of all samples.
    fn kept(&self, output: &Path) -> Result<Vec<Kept>, EnsembleError> {
        let lost = |hash: &str| EnsembleError::File {
            path: sample::path(output, hash),
            cause: "it was removed while the ensemble ran".into(),
        };
        self.hashes.iter().map(|hash| sample::kept(output, hash).ok_or_else(|| lost(hash))).collect()
    }

    /// The levels that the curves of all limits lack; those next to each other are one.
    fn missing_levels(&self, kept: &[Kept]) -> Vec<f64> {
        let mut known = self.plan.intensity.values();
        let mut new = Vec::new();
        for level in Runs::of(self, kept).limits().iter().flat_map(|limit| &limit.proposal.levels) {
            if is_apart(*level, &known) {
                known.push(*level);
                new.push(*level);
            }
        }
        new.sort_by(f64::total_cmp);
        new
    }

    /// The scene of sample number `index`, with its motion.
    fn scene(&self, index: usize) -> Result<LoadedScene, SceneError> {
        let sample = &self.samples[index];
        let sets = self.plan.sets(sample, &self.folder);
        let mut loaded = read_scene(&self.folder.join(&self.plan.scene), &sets)?;
        loaded.ground_motion = self.plan.motion(sample, loaded.ground_motion);
        Ok(loaded)
    }

    /// Warnings of the scene with each record, without repetition; a warning of only some records begins with the name of the first.
    fn warnings(&self) -> Result<Vec<String>, SceneError> {
        let records = &self.plan.records;
        let mut of_records = Vec::new();
        for (number, record) in records.iter().enumerate() {
            // Every record has a sample.
            let Some(index) = self.samples.iter().position(|sample| sample.record == number) else {
                continue;
            };
            let texts: Vec<String> = self.scene(index)?.warnings.iter().map(ToString::to_string).collect();
            of_records.push((&record.name, texts));
        }
        let mut warnings: Vec<String> = Vec::new();
        for (name, texts) in &of_records {
            for text in texts {
                let everywhere = of_records.iter().all(|(_, others)| others.contains(text));
                let said = if everywhere { text.clone() } else { format!("{name}: {text}") };
                if !warnings.contains(&said) {
                    warnings.push(said);
                }
            }
        }
        warnings.extend(self.scaled.iter().flat_map(|scaled| scaled.warnings(records)));
        Ok(warnings)
    }

    /// Period of the intact dam's first mode with the water, or without where there is none, s.
    fn first_period(&self) -> Result<f64, EnsembleError> {
        let scene: Scene = read_scene(&self.folder.join(&self.plan.scene), &self.plan.set)?.scene;
        let modes = match Assembly::of(&scene).natural_modes_in_water(1)? {
            Some(modes) => Some(modes),
            None => Assembly::of(&scene).natural_modes(1)?,
        };
        let frequency = modes.and_then(|modes| modes.frequencies.first().copied());
        frequency.map(|frequency| std::f64::consts::TAU / frequency).ok_or_else(|| EnsembleError::Value {
            path: self.folder.join(&self.plan.scene),
            key: "intensity.period".into(),
            value: "not given, and the scene's dam has no natural frequency".into(),
            remedy: "give the period in the plan".into(),
        })
    }

    /// Whether each record has a vertical component if the scene has one, which is that of another record.
    fn check_vertical(&self) -> Result<(), EnsembleError> {
        let Some(record) = self.plan.records.iter().find(|record| record.vertical.is_none()) else {
            return Ok(());
        };
        match read_scene(&self.folder.join(&self.plan.scene), &self.plan.set) {
            Ok(own) if own.scene.ground_motion.vertical.is_some() => Err(EnsembleError::Value {
                path: self.folder.join(&self.plan.scene),
                key: "[ground_motion.vertical]".into(),
                value: format!("the vertical component of another record than {:?}", record.name),
                remedy: "give `vertical` in each of the plan's `records`, or leave it out of the scene"
                    .into(),
            }),
            _ => Ok(()),
        }
    }

    /// Whether the scene has no shocks after its own record, which the records of the plan replace.
    fn check_sequence(&self) -> Result<(), EnsembleError> {
        match self.scene(0)?.scene.ground_motion.sequence.len() {
            0 => Ok(()),
            count => Err(EnsembleError::Value {
                path: self.folder.join(&self.plan.scene),
                key: "[[ground_motion.sequence]]".into(),
                value: format!("{count} further shocks, which belong to the scene's own record"),
                remedy: "leave the sequence out of the scene: the plan's `records` are single shocks".into(),
            }),
        }
    }

    /// Whether every limit's quantity is one of a run: the first sample's first step says which there are.
    fn check_limits(
        &self,
        path: &Path,
        workers: NonZeroUsize,
        context: &Context<'_>,
    ) -> Result<(), EnsembleError> {
        let loaded = self.scene(0)?;
        let first = sample::run(
            &loaded,
            context,
            workers,
            Some(loaded.scene.time.communication_step),
            &AtomicBool::new(false),
        )?;
        let mut names: Vec<&str> = first.quantities.iter().map(|number| &*number.name).collect();
        // Quantities that exist only at rest have the names of the peaks.
        let residual: Vec<String> = names
            .iter()
            .filter_map(|name| name.strip_prefix("peak sliding"))
            .map(|of_crack| format!("residual sliding{of_crack}"))
            .collect();
        names.extend(residual.iter().map(String::as_str));
        let unknown = self.plan.limits.iter().find(|limit| !names.contains(&&*limit.quantity));
        let Some(limit) = unknown else { return Ok(()) };
        let like = |name: &&&str| strsim::jaro_winkler(name, &limit.quantity);
        let meant = names.iter().max_by(|a, b| like(a).total_cmp(&like(b))).copied().unwrap_or_default();
        Err(EnsembleError::Value {
            path: path.to_owned(),
            key: "limits.quantity".into(),
            value: format!("{:?}", limit.quantity),
            remedy: format!("did you mean {meant:?}? The runs have {}", names.join("; ")),
        })
    }
}
