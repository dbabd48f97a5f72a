//! `cofferdam ensemble`: many runs of a scene, and what they say together.

mod control;
mod figure;
mod limits;
mod manifest;
mod methods;
mod plan;
mod runs;
pub mod sample;
mod tables;
mod target;

use super::{complain, parallel, report, say, threads};
use cofferdam_analysis::statistics::{Declined, LEAST_CLUSTERS};
use cofferdam_assembly::{Assembly, AssemblyError, read_scene};
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_motion::{GroundMotion, RecordError, TargetError};
use cofferdam_scene::{LoadedScene, Scene, SceneError};
use miette::Diagnostic;
use plan::{Intensity, Measure, Model, Plan, Sample};
use sample::{Contents, Kept};
use std::error::Error;
use std::fs::DirEntry;
use std::io::{ErrorKind, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use target::Scaled;

/// Arguments of `cofferdam ensemble`.
#[derive(clap::Args)]
pub struct Arguments {
    /// File that says what is varied; docs/ensembles.md explains its keys
    plan: PathBuf,

    /// Folder for samples, tables and pictures
    ///
    /// Samples that lie in it already are not run again, so that the same command goes on after an interruption, on this
    /// machine or another one.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Run only this share of the samples, such as 3/16: number 3, 19, 35, … of all; no tables
    ///
    /// For several machines with a common folder. The command without this option runs what is missing, and writes the tables.
    #[arg(long, value_name = "PART/PARTS", value_parser = part)]
    part: Option<Part>,

    /// Runs at the same time; by default one per core
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,

    /// Do not write report.html; `cofferdam report` makes it later
    #[arg(long)]
    no_report: bool,
}

/// A share of the samples, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    number: usize,
    of: usize,
}

fn part(text: &str) -> Result<Part, String> {
    let parsed = text.split_once('/').and_then(|(number, of)| {
        let (number, of) = (number.parse::<usize>().ok()?, of.parse::<usize>().ok()?);
        Some(Part { number: number.checked_sub(1)?, of })
    });
    let sound = parsed.filter(|part| part.number < part.of);
    sound
        .ok_or_else(|| "two whole numbers are wanted, the first from 1 up to the second, such as 3/16".into())
}

pub const HELP: &str = "\
Runs a scene with every record, level of shaking, polarity and variation of a plan, as many at once as there are cores, each in
this process and without log; with [dear] some of them by a dearer model, too. Results do not depend on the number of threads, nor
on interruptions, bit for bit.

Writes into the output folder:
  samples/         a file for each run, named by the SHA-256 of what it was computed from
  results.csv, .parquet
                   a row for each run
  ensemble.md      median, 16 and 84 % of each quantity, fragility of each limit, what the variance comes from, whether
                   methods agree
  control.csv, dear.csv
                   with [dear]: distribution by the dear model from few dear runs and all cheap ones, with the saving that is
                   predicted, or why it is not used; a row for each dear run
  statistics.csv, fragility.csv, limits.csv, exceedance.csv, variance.csv, methods.csv
                   the same with all quantities and digits
  target.csv, spectra.svg
                   with intensity.target: factor and misfit of each record, its scaled spectrum
  polarities.csv   with both polarities: which of them governs
  ida.svg          incremental dynamic analysis: the first limit's quantity over intensity, for each record
  fragility.svg    probability of exceeding each limit, with its 95 % band
  ensemble.toml    what it was made from: records, levels, what varies, hashes, program, machine
  report.html      all of this on one page; `cofferdam report` writes it anew

Examples:
  cofferdam ensemble scenes/koyna-northridge-1994/ensemble.toml --output ensembles/koyna
  cofferdam ensemble plan.toml --output /shared/study --part 3/16
      The third of sixteen shares, as a job of an array.

Exit status: 0, 1 results could not be written, 2 the plan or its scene is wrong, 4 a unit cannot be made. Runs that fail are
listed, and left out of the statistics.";

/// Why an ensemble ended early.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum EnsembleError {
    /// The plan.
    #[error("{}: {cause}", path.display())]
    Plan { path: PathBuf, cause: String },
    /// A value of the plan.
    #[error("{}: `{key}` is {value}; {remedy}", path.display())]
    Value { path: PathBuf, key: String, value: String, remedy: String },
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
    /// A run that could not go on for a reason that is not its own.
    #[error("{title}: {cause}")]
    Run { title: String, cause: Box<SimulationError> },
    /// A folder with something else in it.
    #[error(
        "{} holds no ensemble or one of another plan; choose another --output, nothing is overwritten", path.display()
    )]
    OutputTaken { path: PathBuf },
    /// A file.
    #[error("{}: {cause}; choose another --output", path.display())]
    File { path: PathBuf, cause: Box<dyn Error + Send + Sync> },
    /// A file that a unit rests on.
    #[error("{}: {cause}; give a file that can be read", path.display())]
    Unreadable { path: PathBuf, cause: std::io::Error },
    /// The page.
    #[error("the report: {0}")]
    Report(#[from] report::Failure),
    /// Numbers that cannot be written as text, or a picture that cannot be drawn.
    #[error("{0}; this is a mistake of the program")]
    Format(Box<dyn Error + Send + Sync>),
}

/// Runs an ensemble and reports the result.
pub fn run(arguments: &Arguments) -> ExitCode {
    match carry_out(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = match error {
                EnsembleError::Plan { .. }
                | EnsembleError::Value { .. }
                | EnsembleError::Record(_)
                | EnsembleError::Target(_)
                | EnsembleError::Unreadable { .. }
                | EnsembleError::Scene(_) => 2,
                EnsembleError::Unit(_) => 4,
                EnsembleError::Run { .. }
                | EnsembleError::OutputTaken { .. }
                | EnsembleError::File { .. }
                | EnsembleError::Report(_)
                | EnsembleError::Format(_) => 1,
            };
            complain(format!("{:?}", miette::Report::new(error)));
            ExitCode::from(status)
        }
    }
}

/// An ensemble that is ready to be run.
struct Ensemble {
    plan: Plan,
    /// The file's folder.
    folder: PathBuf,
    /// Name of the intensity measure.
    measure: String,
    /// How the records were scaled to a target spectrum.
    scaled: Option<Scaled>,
    samples: Vec<Sample>,
    /// SHA-256 of each.
    hashes: Vec<String>,
    /// Numbers of the samples that run dear, too.
    dear: Vec<usize>,
    /// SHA-256 of these runs.
    dear_hashes: Vec<String>,
}

/// A run: number of its sample, model, SHA-256.
#[derive(Clone, Copy)]
struct Job<'a> {
    sample: usize,
    model: Model,
    hash: &'a str,
}

fn carry_out(arguments: &Arguments) -> Result<(), EnsembleError> {
    let (plan, text) = Plan::read(&arguments.plan)?;
    let folder = arguments.plan.parent().unwrap_or(Path::new("")).to_owned();
    let workers = threads(arguments.threads);
    let ensemble = Ensemble::of(plan, folder, workers)?;
    ensemble.check_dear(&arguments.plan)?;
    ensemble.check_limits(&arguments.plan, workers)?;
    take_folder(&arguments.output, &text)?;
    ensemble.warnings()?.iter().for_each(|warning| complain(format!("WARNING: {warning}")));
    let mine = |index: usize| arguments.part.is_none_or(|part| index % part.of == part.number);
    let jobs = ensemble.jobs().enumerate();
    let mut wanted: Vec<Job> = jobs.filter(|(index, _)| mine(*index)).map(|(_, job)| job).collect();
    let all = wanted.len();
    // Equal samples are run once.
    let mut seen = std::collections::BTreeSet::new();
    wanted.retain(|job| seen.insert(job.hash) && sample::kept(&arguments.output, job.hash).is_none());
    // Long ones first, so that no thread has one left when the others are done.
    wanted.sort_by_key(|job| job.model == Model::Cheap);
    say(format!("{} samples, {} of them to be run", all, wanted.len()));
    let watch = Watch::new(wanted.len());
    parallel::try_map(&wanted, workers, |job| {
        let began = Instant::now();
        let loaded = ensemble.scene(job.sample, job.model)?;
        let kept = sample::run(&loaded, NonZeroUsize::MIN, None, &AtomicBool::new(false))?;
        sample::keep(&arguments.output, job.hash, &kept)?;
        watch.tell(&kept, job.model, began.elapsed());
        Ok::<_, EnsembleError>(())
    })?;
    watch.end(ensemble.plan.dear.as_ref().map(plan::Dear::cost));
    if arguments.part.is_some() {
        say("the command without --part writes the tables when all parts are done");
        return Ok(());
    }
    let lost = |hash: &str| EnsembleError::File {
        path: sample::path(&arguments.output, hash),
        cause: "it was removed while the ensemble ran".into(),
    };
    let kept = ensemble
        .jobs()
        .map(|job| sample::kept(&arguments.output, job.hash).ok_or_else(|| lost(job.hash)))
        .collect::<Result<Vec<_>, _>>()?;
    let (cheap, dear) = kept.split_at(ensemble.samples.len());
    tables::write(&ensemble, cheap, dear, &text, &arguments.output)?;
    let page = if arguments.no_report { None } else { Some(report::of_ensemble(&arguments.output)?) };
    let report = page.map_or("", |_| ", report.html");
    say(format!("tables, pictures{report} are in {}", arguments.output.display()));
    Ok(())
}

impl Ensemble {
    /// Checks every sample's scene.
    fn of(plan: Plan, folder: PathBuf, workers: NonZeroUsize) -> Result<Self, EnsembleError> {
        let mut ensemble = Self {
            plan,
            folder,
            measure: String::new(),
            scaled: None,
            samples: Vec::new(),
            hashes: Vec::new(),
            dear: Vec::new(),
            dear_hashes: Vec::new(),
        };
        let Plan { records, intensity, .. } = &ensemble.plan;
        let motions = records.iter().map(|record| {
            let (start, end) = (record.start.unwrap_or(0.0), record.end.unwrap_or(f64::INFINITY));
            GroundMotion::from_record(&ensemble.folder.join(&record.file), record.units, start, end, 1.0)
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
        let numbers: Vec<usize> = (0..ensemble.samples.len()).collect();
        ensemble.dear = ensemble.plan.dear_samples(&ensemble.samples);
        let contents = Contents::default();
        let hashes = |numbers: &[usize], model| {
            let hash = |index: &usize| sample::hash(&ensemble.scene(*index, model)?, &contents);
            parallel::try_map(numbers, workers, hash)
        };
        (ensemble.hashes, ensemble.dear_hashes) =
            (hashes(&numbers, Model::Cheap)?, hashes(&ensemble.dear, Model::Dear)?);
        Ok(ensemble)
    }

    /// All runs: the cheap ones of all samples, then the dear ones.
    fn jobs(&self) -> impl Iterator<Item = Job<'_>> {
        let cheap = self.hashes.iter().enumerate().map(|(sample, hash)| (sample, Model::Cheap, hash));
        let dear = self.dear.iter().zip(&self.dear_hashes).map(|(sample, hash)| (*sample, Model::Dear, hash));
        cheap.chain(dear).map(|(sample, model, hash)| Job { sample, model, hash })
    }

    /// The scene of sample number `index`, with its motion.
    fn scene(&self, index: usize, model: Model) -> Result<LoadedScene, SceneError> {
        let sample = &self.samples[index];
        let sets = self.plan.sets(sample, model, &self.folder);
        let mut loaded = read_scene(&self.folder.join(&self.plan.scene), &sets)?;
        loaded.ground_motion = self.plan.motion(sample, loaded.ground_motion);
        Ok(loaded)
    }

    /// What is doubtful about the scene with each record, once; what only some records have begins with the name of the first of them.
    fn warnings(&self) -> Result<Vec<String>, SceneError> {
        let records = &self.plan.records;
        let mut of_records = Vec::new();
        for (number, record) in records.iter().enumerate() {
            // Every record has a sample.
            let Some(index) = self.samples.iter().position(|sample| sample.record == number) else {
                continue;
            };
            let texts: Vec<String> =
                self.scene(index, Model::Cheap)?.warnings.iter().map(ToString::to_string).collect();
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
        warnings.extend(self.warnings_of_dear()?);
        warnings.extend(self.scaled.iter().flat_map(|scaled| scaled.warnings(records)));
        Ok(warnings)
    }

    /// What is doubtful about the first dear run's scene and not about the same cheap one, and where there are too few dear runs.
    fn warnings_of_dear(&self) -> Result<Vec<String>, SceneError> {
        let Some(first) = self.dear.first() else { return Ok(Vec::new()) };
        let of_model = |model| {
            let warnings = self.scene(*first, model)?.warnings;
            Ok(warnings.iter().map(ToString::to_string).collect::<Vec<String>>())
        };
        let (cheap, dear) = (of_model(Model::Cheap)?, of_model(Model::Dear)?);
        let own = dear.into_iter().filter(|text| !cheap.contains(text));
        let mut warnings: Vec<String> = own.map(|text| format!("dear runs: {text}")).collect();
        let clusters = self.clusters();
        let with_dear: std::collections::BTreeSet<usize> = self.dear.iter().map(|i| clusters[*i]).collect();
        if with_dear.len() < LEAST_CLUSTERS {
            let few = Declined::TooFew { clusters: with_dear.len() };
            warnings.push(format!("the dear runs will be used alone: {few}"));
        }
        Ok(warnings)
    }

    /// What is drawn together with dear runs, by sample: records of a pair, or draws of a single record.
    fn clusters(&self) -> Vec<usize> {
        let of_record = self.plan.clusters();
        let alone = of_record.len() == 1;
        let of = |sample: &Sample| if alone { sample.draw } else { of_record[sample.record] };
        self.samples.iter().map(of).collect()
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

    /// Whether dear runs are others than the cheap ones of the same motions.
    fn check_dear(&self, path: &Path) -> Result<(), EnsembleError> {
        let equal = self.dear.iter().zip(&self.dear_hashes).any(|(index, hash)| self.hashes[*index] == *hash);
        match self.plan.dear.as_ref().filter(|_| equal) {
            None => Ok(()),
            Some(dear) => Err(EnsembleError::Value {
                path: path.to_owned(),
                key: "dear.set".into(),
                value: format!("{:?}", dear.set),
                remedy:
                    "the scene has these values already, so that dear runs are the cheap ones; change others"
                        .into(),
            }),
        }
    }

    /// Whether every limit's quantity is one of a run: the first sample's first step says which there are.
    fn check_limits(&self, path: &Path, workers: NonZeroUsize) -> Result<(), EnsembleError> {
        let loaded = self.scene(0, Model::Cheap)?;
        let first = sample::run(
            &loaded,
            workers,
            Some(loaded.scene.time.communication_step),
            &AtomicBool::new(false),
        )?;
        let mut names: Vec<&str> = first.quantities.iter().map(|number| &*number.name).collect();
        // What there is only at rest has the names of the peaks.
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

/// Makes the folder, or finds in it what is left of the same plan. Parts that begin at the same time all find the plan whole.
fn take_folder(folder: &Path, text: &str) -> Result<(), EnsembleError> {
    let failed = |cause: std::io::Error| EnsembleError::File { path: folder.to_owned(), cause: cause.into() };
    let (plan, samples) = (folder.join("plan.toml"), folder.join("samples"));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let is_ours = |entry: std::io::Result<DirEntry>| {
        entry.is_ok_and(|entry| {
            let name = entry.file_name();
            name == "plan.toml" || name == "samples" || name.to_string_lossy().starts_with(DRAFT)
        })
    };
    if !plan.exists() && !std::fs::read_dir(folder).map_err(failed)?.all(is_ours) {
        return Err(EnsembleError::OutputTaken { path: folder.to_owned() });
    }
    if !plan.exists() {
        let mut draft = sample::beside(folder, DRAFT).map_err(failed)?;
        draft.write_all(text.as_bytes()).map_err(failed)?;
        // Another part may have been faster.
        draft.persist_noclobber(&plan).map(drop).or_else(|error| match error.error.kind() {
            ErrorKind::AlreadyExists => Ok(()),
            _ => Err(failed(error.error)),
        })?;
    }
    if std::fs::read_to_string(&plan).ok().as_deref() != Some(text) {
        return Err(EnsembleError::OutputTaken { path: folder.to_owned() });
    }
    std::fs::create_dir_all(samples).map_err(failed)
}

/// How the name of a plan begins that is being written.
const DRAFT: &str = ".plan-";

/// Tells how far the ensemble is, every few seconds.
struct Watch {
    began: Instant,
    wanted: usize,
    done: Mutex<Done>,
}

#[derive(Default)]
struct Done {
    runs: usize,
    failed: usize,
    told: Duration,
    /// Number of cheap and of dear runs, and the time that each kind took, s.
    kinds: [(usize, f64); 2],
}

/// Time between two lines.
const BETWEEN: Duration = Duration::from_secs(5);

impl Watch {
    fn new(wanted: usize) -> Self {
        Self { began: Instant::now(), wanted, done: Mutex::default() }
    }

    fn tell(&self, kept: &Kept, model: Model, taken: Duration) {
        let Ok(mut done) = self.done.lock() else { return };
        let (runs, time) = &mut done.kinds[usize::from(model == Model::Dear)];
        *runs += 1;
        *time += taken.as_secs_f64();
        done.runs += 1;
        done.failed += usize::from(!kept.is_complete());
        let elapsed = self.began.elapsed();
        if elapsed >= done.told + BETWEEN {
            done.told = elapsed;
            let left = elapsed.as_secs_f64() * (self.wanted - done.runs) as f64 / done.runs as f64;
            say(format!("{} of {}, {} failed, {left:.0} s left", done.runs, self.wanted, done.failed));
        }
    }

    /// `cost` is what the plan says of a dear run.
    fn end(&self, cost: Option<f64>) {
        let elapsed = self.began.elapsed().as_secs_f64();
        if self.wanted > 0 {
            say(format!("{} runs in {elapsed:.1} s", self.wanted));
        }
        let Ok(done) = self.done.lock() else { return };
        let [cheap, dear] = done.kinds.map(|(runs, time)| time / runs as f64);
        if let Some(cost) = cost.filter(|_| (dear / cheap).is_finite()) {
            let ratio = dear / cheap;
            say(format!("a dear run took {ratio:.1} times as long as a cheap one; `dear.cost` is {cost}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_begin_at_once_share_a_folder_and_others_find_it_taken() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("out");
        let taken = std::thread::scope(|scope| {
            let parts: Vec<_> = (0..8).map(|_| scope.spawn(|| take_folder(&folder, "a plan"))).collect();
            parts.into_iter().map(|part| part.join().expect("no panic")).collect::<Vec<_>>()
        });
        assert!(taken.iter().all(Result::is_ok), "{taken:?}");
        assert_eq!(std::fs::read_to_string(folder.join("plan.toml")).ok().as_deref(), Some("a plan"));
        assert!(matches!(take_folder(&folder, "another"), Err(EnsembleError::OutputTaken { .. })));
        std::fs::write(place.path().join("x"), "mine").expect("a file");
        assert!(matches!(take_folder(place.path(), "a plan"), Err(EnsembleError::OutputTaken { .. })));
    }
}
