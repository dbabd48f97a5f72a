//! Common parts of runs, resumed runs and branches: results, units, observers, report.

use super::background::Background;
use super::model::{dam_model, ground_line, recursion, stress_points, waters};
use super::place::{Fork, hand_over, place, same_units, same_variables, until};
use super::{Options, RunError, RunOutcome, band};
use crate::accuracy::Promise;
use crate::context::Context;
use crate::spectra;
use crate::start::{Start, StartError, deadlines};
use crate::variables::known;
use cofferdam_assembly::log::{ground_motion_of, scene_of};
use cofferdam_assembly::observer::{HistoriesWriter, Limits, OutlineWriter, Rest, Snapshots};
use cofferdam_assembly::simulation::crest_at_rest;
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::units::DAM;
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::observer::{Ending, Observer, Status, Until};
use cofferdam_coupling::scheme::{Graph, interface_points};
use cofferdam_coupling::simulation::{Course, Simulation};
use cofferdam_log::{LastCheckpoint, Log, LogWriter, Parent, Preamble};
use cofferdam_report::Summary;
use cofferdam_report::page;
use cofferdam_report::{Build, Envelopes, Manifest, ManifestError, Quantity, Unit, WaterFace, text};
use cofferdam_scene::{LoadedScene, Scene};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Indent below the name of a unit.
const UNDER_NAME: &str = "           ";

/// A run that is about to start or to continue.
pub struct Job<'a> {
    pub loaded: &'a LoadedScene,
    pub options: &'a Options,
    /// Number of replicates for a band.
    pub band: Option<u16>,
    /// The requested accuracy.
    pub accuracy: Option<&'a Promise>,
    /// Where its results go.
    pub folder: &'a Path,
    /// When it began, in UTC.
    pub started: String,
    /// Settings that differ from those of the named scene.
    pub settings: &'a [String],
    /// Set to end the run after its step.
    pub interrupted: &'a AtomicBool,
    /// Cache, program, reporter.
    pub context: &'a Context<'a>,
}

/// Where a run begins.
pub enum Beginning {
    /// At its initialisation.
    Initialisation,
    /// At the last checkpoint of its log, whose place the new log takes; without one at initialisation.
    Resumed(Log, Option<LastCheckpoint>),
    /// Where it leaves another run.
    Branch(Fork),
}

/// The observers of a run.
struct Watch<'a, 'b> {
    log: LogWriter,
    histories: HistoriesWriter,
    /// Those of the caller.
    further: &'a mut [&'b mut dyn Observer],
    limits: Limits,
    rest: Rest,
    until: Until,
    outline: OutlineWriter,
    snapshots: Option<Snapshots>,
}

impl Watch<'_, '_> {
    fn all(&mut self) -> Vec<&mut dyn Observer> {
        let Self { log, histories, further, limits, rest, until, outline, snapshots } = self;
        let mut all: Vec<&mut dyn Observer> = vec![log, histories];
        all.extend(further.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
        let own: [&mut dyn Observer; 4] = [limits, rest, until, outline];
        all.extend(own);
        all.extend(snapshots.as_mut().map(|snapshots| snapshots as &mut dyn Observer));
        all
    }
}

impl Job<'_> {
    /// Runs to the end, with `further` observers.
    pub fn carry_out(
        &self,
        beginning: Beginning,
        further: &mut [&mut dyn Observer],
    ) -> Result<RunOutcome, RunError> {
        let Self { loaded, options, folder, interrupted, context, .. } = *self;
        let scene = &loaded.scene;
        let manifest_path = folder.join("manifest.toml");
        let mut manifest = Manifest {
            name: loaded.name.clone(),
            started: self.started.clone(),
            status: "preparing".to_owned(),
            build: Build::here(),
            wet_face: Vec::new(),
            reservoir_wet_face: None,
            further_wet_faces: Vec::new(),
            outline: Vec::new(),
            units: Vec::new(),
            result: None,
            accuracy: self.accuracy.map(|promise| promise.record.clone()),
            plan: self.accuracy.map_or_else(Vec::new, |promise| promise.plan.clone()),
            scene: scene.clone(),
        };
        manifest.write(&manifest_path)?;
        let preamble = self.preamble(&manifest.build, &beginning)?;
        let path = folder.join("log.mcap");
        let (waters, not_shown) = waters(scene);
        let mut watch = Watch {
            log: match beginning {
                Beginning::Resumed(..) => LogWriter::beside(&path, &preamble)?,
                _ => LogWriter::create(&path, &preamble)?,
            },
            histories: HistoriesWriter::new(folder),
            further,
            limits: Limits::new(&scene.stop),
            rest: Rest::new(&scene.time),
            until: Until::new(options.until),
            outline: OutlineWriter::new(folder),
            snapshots: scene.snapshots.map(|plan| Snapshots::new(folder, plan, waters)),
        };

        context.line(&scene.title);
        if !self.settings.is_empty() {
            context.line(format!("but {}", self.settings.join(", ")));
        }
        let began = Instant::now();
        let failed = |error: &dyn std::fmt::Display, manifest: &mut Manifest| {
            manifest.status = format!("failed: {error}");
            manifest.write(&manifest_path)
        };
        let mut graph = match self.graph(scene, true) {
            Ok(graph) => graph,
            Err(error) => {
                failed(&error, &mut manifest)?;
                return Err(error);
            }
        };
        for unit in graph.units() {
            let description = unit.description();
            let (name, solver) = (description.name.clone(), description.solver.clone());
            context.line(text::wrapped(&format!("{name:<10} {solver}"), UNDER_NAME));
            let fingerprint = description.fingerprint.to_string();
            manifest.units.push(Unit { name, solver, fingerprint });
        }
        for (index, interface) in graph.interfaces().to_vec().iter().enumerate() {
            let [dam, own] = interface_points(&mut graph, interface)?.unwrap_or_default();
            let own = Some(own).filter(|points| *points != dam);
            if index == 0 {
                (manifest.wet_face, manifest.reservoir_wet_face) = (dam, own);
            } else {
                let water = graph[interface.second.unit].description().name.clone();
                manifest.further_wet_faces.push(WaterFace { water, points: dam, own_points: own });
            }
        }
        manifest.outline = watch.outline.find(&mut graph[DAM])?.to_vec();
        "running".clone_into(&mut manifest.status);
        manifest.write(&manifest_path)?;
        let dam = dam_model(loaded, &mut graph)?;
        let stress_points = stress_points(&mut graph)?;
        let natural_frequencies = known(graph[DAM].read("natural_frequency"))?;
        let background = Background::begin(scene, natural_frequencies.len());
        let recursion = recursion(scene, &mut graph)?;
        context.line(text::wrapped(&ground_line(&loaded.ground_motion), UNDER_NAME));
        context.line(format!(
            "prepared in {:.2} s; results go to {}",
            began.elapsed().as_secs_f64(),
            folder.display()
        ));

        let mut simulation = match simulation_of(scene, &loaded.ground_motion, graph) {
            Ok(simulation) => simulation,
            Err(error) => {
                failed(&error, &mut manifest)?;
                return Err(error.into());
            }
        };
        let mut course = simulation.course();
        let begun = match self.begin(&mut simulation, &mut course, &beginning, &mut watch, &path) {
            Err(RunError::Simulation(error)) => Err(error),
            Err(error) => {
                failed(&error, &mut manifest)?;
                return Err(error);
            }
            Ok(()) => Ok(()),
        };
        let (ending, failure) = simulation.conclude(&mut course, begun, &mut watch.all(), interrupted);
        let histories = &watch.histories.histories;
        let mut summary = background.summary(context, |in_water| {
            Summary::of(
                loaded,
                histories,
                &ending,
                crest_at_rest(&simulation),
                &stress_points,
                [&natural_frequencies, in_water],
                &recursion,
            )
        });
        match self.envelopes(&mut simulation, &ending) {
            Ok(quantities) => summary.quantities.extend(quantities),
            Err(why) => summary.notes.push(format!("WARNING: no envelopes: {why}")),
        }
        summary.notes.extend(not_shown);
        summary.notes.extend(watch.limits.flags().into_iter().map(|flag| format!("WARNING: {flag}")));
        let band = match self.band {
            Some(twins) if ending.status == Status::Completed => {
                band::add(loaded, twins, context, interrupted, &mut summary)
            }
            Some(_) => {
                Err("the run did not reach the end of its scene, which the replicates require".to_owned())
            }
            None => Ok(()),
        };
        summary.notes.extend(band.err().map(|why| format!("WARNING: no band: {why}")));
        if let Some(promise) = self.accuracy {
            promise.note(&mut summary);
        }
        manifest.status.clone_from(&summary.status);
        manifest.result = Some(summary.clone());
        let written = manifest.write(&manifest_path);
        let spectra = spectra::write(folder, histories);
        let page = match options.report {
            true => Some(page::file::write_run(folder, &manifest, histories)),
            false => None,
        };
        let has_report = matches!(page, Some(Ok(())));
        let mut page = page.unwrap_or(Ok(()));
        let mut page_failure = None;
        let failure = match failure {
            Some(error) => {
                page_failure = std::mem::replace(&mut page, Ok(())).err();
                Err(error.into())
            }
            None => (written.map_err(RunError::from))
                .and_then(|()| spectra.map_err(RunError::Spectra))
                .and_then(|()| Ok(page?)),
        };
        Ok(RunOutcome {
            status: ending.status,
            folder: folder.to_owned(),
            summary,
            model: dam,
            wall: ending.wall,
            parent: if let Beginning::Branch(fork) = beginning { Some(fork.log) } else { None },
            has_report,
            page_failure,
            failure: failure.err(),
        })
    }

    /// Writes the envelopes of the dam, and returns their quantities for the whole section. A run that ends within a step has
    /// no envelopes, not even of an earlier part.
    fn envelopes(&self, simulation: &mut Simulation, ending: &Ending) -> Result<Vec<Quantity>, String> {
        let failed = |error: std::io::Error| format!("{}: {error}; free some space", self.folder.display());
        Envelopes::remove(self.folder).map_err(failed)?;
        let read = Envelopes::read(&mut simulation.graph[DAM], ending.time);
        let Some(envelopes) = read.map_err(|error| error.to_string())? else { return Ok(Vec::new()) };
        envelopes.write(self.folder).map_err(failed)?;
        Ok(envelopes.quantities())
    }

    /// The preamble of the log.
    fn preamble(&self, build: &Build, beginning: &Beginning) -> Result<Preamble, RunError> {
        let scene = toml::to_string(&self.loaded.scene).map_err(ManifestError::from)?;
        let parent = match beginning {
            Beginning::Initialisation => None,
            Beginning::Resumed(log, _) => log.head().parent.clone(),
            Beginning::Branch(Fork { log, step, settings, .. }) => Some(Parent {
                log: absolute(log.path()),
                step: step.saturating_sub(1),
                settings: settings.join("\n"),
            }),
        };
        Ok(Preamble {
            scene,
            version: build.version.clone().into_owned(),
            commit: build.commit.clone().into_owned(),
            profile: build.profile.clone().into_owned(),
            processor: build.processor.clone(),
            features: build.features.clone(),
            system: build.system.clone(),
            started: self.started.clone(),
            parent,
            content: self.loaded.scene.log,
            window: self.loaded.scene.coupling.window,
        })
    }

    /// The units of a scene.
    fn graph(&self, scene: &Scene, announce: bool) -> Result<Graph, RunError> {
        let start = Start {
            scene,
            resolved: &toml::to_string(scene).map_err(ManifestError::from)?,
            transport: self.options.transport,
            threads: self.options.threads,
            deadlines: deadlines(self.options.deadline),
            interrupted: self.interrupted,
            announce,
            context: *self.context,
        };
        let units = start.units(&Assembly::of(scene).units()).map_err(|error| match error {
            StartError::Unit(error) => RunError::Unit(error),
            StartError::Participant(error) => RunError::Participant(error),
            error @ StartError::Program(_) => RunError::Start(error),
        })?;
        Ok(Graph::new(units, Assembly::of(scene).interfaces()).map_err(AssemblyError::from)?)
    }

    /// Begins, or puts everything where it was.
    fn begin(
        &self,
        simulation: &mut Simulation,
        course: &mut Course,
        beginning: &Beginning,
        watch: &mut Watch<'_, '_>,
        path: &Path,
    ) -> Result<(), RunError> {
        match beginning {
            Beginning::Initialisation => Ok(simulation.begin(course, &mut watch.all())?),
            Beginning::Resumed(log, None) => {
                self.context.line("the log has no checkpoint: the run starts again");
                same_units(log, &simulation.graph)?;
                simulation.begin(course, &mut watch.all())?;
                Ok(watch.log.replace(path)?)
            }
            Beginning::Resumed(log, Some(checkpoint)) => {
                same_units(log, &simulation.graph)?;
                simulation.retell(until(log, checkpoint)?, &mut watch.all())?;
                watch.log.replace(path)?;
                place(simulation, course, log, checkpoint, self.context)?;
                self.context
                    .line(format!("continues after step {}, t = {:.4} s", checkpoint.step, checkpoint.time));
                Ok(())
            }
            Beginning::Branch(fork) => self.leave(simulation, course, fork, watch),
        }
    }

    /// Follows the run that is left up to its last common step, then continues with `simulation`.
    fn leave(
        &self,
        simulation: &mut Simulation,
        course: &mut Course,
        fork: &Fork,
        watch: &mut Watch<'_, '_>,
    ) -> Result<(), RunError> {
        same_variables(fork, &simulation.graph)?;
        let mut before = match fork.settings.is_empty() {
            true => None,
            false => {
                let scene = scene_of(&fork.log)?;
                let graph = self.graph(&scene, false)?;
                same_units(&fork.log, &graph)?;
                Some(simulation_of(&scene, &ground_motion_of(&fork.log), graph)?)
            }
        };
        // The units of the branch, not those that it leaves, stand in its log.
        simulation.tell_start(&mut watch.all())?;
        let leader = before.as_mut().unwrap_or(&mut *simulation);
        match &fork.checkpoint {
            Some(checkpoint) => {
                leader.tell_past(until(&fork.log, checkpoint)?, &mut watch.all())?;
                place(leader, course, &fork.log, checkpoint, self.context)?;
            }
            None => leader.initialise(course, &mut watch.all())?,
        }
        let ends = |step: u64| {
            let why = format!("the run ends after step {step}; branch from an earlier step");
            Err(RunError::NoWayOn { log: fork.log.path().to_owned(), why })
        };
        while course.steps() + 1 < fork.step {
            if leader.advance(course, &mut watch.all())?.is_some() {
                return ends(course.steps());
            }
        }
        if let Some(mut before) = before {
            let state = before.state(course)?;
            let graphs = [&mut before.graph, &mut simulation.graph];
            hand_over(&self.loaded.scene, graphs, fork, course.steps(), self.context)?;
            simulation.branch(course, &state)?;
        }
        if simulation.is_over(course) {
            return ends(course.steps());
        }
        self.context.line(format!(
            "leaves the run after step {}, t = {:.4} s",
            course.steps(),
            course.time()
        ));
        let all = vec![true; fork.log.head().units.len()];
        Ok(simulation.save(course, &all, &mut watch.all())?)
    }
}

/// The path from the root, if it can be found.
fn absolute(path: &Path) -> String {
    path.canonicalize().unwrap_or_else(|_| path.to_owned()).display().to_string()
}
