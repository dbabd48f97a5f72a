mod checks;

use super::evaluation::{Given, Iteration, ask};
use super::frozen::FrozenWatch;
use super::link::{Blank, Link, LinkState, check_size};
use super::{
    CouplingError, Exchange, Graph, InterfaceReport, Interval, IterationReport, Predictor, Purpose,
    SchemeKind, StepFailure, UnitId, WindowReport, WorstPoint,
};
use crate::acceleration::Acceleration;
use crate::convergence::{ConvergenceMeasure, Guard, Hopeless, Known, Residuals, norm};
use crate::participant::{Occasion, Participant, ParticipantError};
use interface::{Fingerprint, StateError};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// The scheme and its limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The scheme.
    pub kind: SchemeKind,
    /// Largest number of iterations of a window by one acceleration; those that measure and check the units do not
    /// count.
    pub iteration_limit: u32,
    /// Whether the run continues with a window that reached the iteration limit or stagnated; it is reported as not
    /// converged.
    pub accept_unconverged: bool,
    /// Weight of acceleration against pressure in the parallel schemes, Pa/(m/s²).
    pub acceleration_scale: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kind: SchemeKind::SerialImplicit,
            iteration_limit: 100,
            accept_unconverged: false,
            acceleration_scale: 1.0,
        }
    }
}

/// Takes communication steps with the units of a [`Graph`], by a [`SchemeKind`].
///
/// The unknowns x of a window are the pressures of all interfaces at the ends of its steps; for a parallel scheme also
/// the accelerations, multiplied by [`Settings::acceleration_scale`]. An iteration G takes every step of the window with
/// each unit; one [`Acceleration`] moves x towards x = G(x), so that interfaces that act on each other converge together. An iteration is one step of the dam per communication step,
/// including the confirming one.
///
/// **Call order**: [`initialise`](Self::initialise); then [`advance`](Self::advance), or
/// [`attempt`](Self::attempt) and, if its report is good, [`accept`](Self::accept); if not, another attempt at the
/// same time.
pub struct Scheme {
    settings: Settings,
    measure: ConvergenceMeasure,
    links: Vec<Link>,
    /// One for each unit.
    blanks: Vec<Blank>,
    /// In which the units are asked.
    order: Vec<UnitId>,
    /// Whether the answers of a unit are known beforehand, so that a first guess says nothing.
    open_loop: bool,
    memory: Memory,
    /// The units are inside a window that was not accepted.
    astray: bool,
    began: Instant,
    fingerprint: Fingerprint,
}

/// What a scheme learns in a run, besides what its links do.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Memory {
    acceleration: Acceleration,
    /// The acceleration without history.
    fresh: Acceleration,
    predictor: Predictor,
    /// One for each unit.
    frozen: Vec<FrozenWatch>,
    /// Number and length (s) of the steps that the acceleration has learnt from.
    shape: (usize, f64),
    /// Change of the residual by rounding, Pa.
    floor: Option<f64>,
    /// Largest norm of an accepted pressure, Pa.
    largest_pressure: f64,
}

/// State of a [`Scheme`] between two windows: all that its later requests and reports depend on, besides the units.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SchemeState {
    memory: Memory,
    links: Vec<LinkState>,
    /// Wall time since the start of the run.
    elapsed: Duration,
}

/// Result of an iteration.
struct Answer {
    /// G(x).
    unknowns: Vec<f64>,
    displacement: Vec<f64>,
}

/// Ratios of step lengths between which an acceleration keeps its history.
const SIMILAR: std::ops::Range<f64> = 0.6..1.7;

impl Scheme {
    /// A scheme for the units of `graph`.
    ///
    /// **Errors**: a unit lacks a coupled variable; the points of an interface differ; the mass of the water is both in
    /// a dam's mass matrix and exchanged, or neither; an implicit scheme with an iteration limit of 0.
    pub fn new(
        graph: &mut Graph,
        settings: Settings,
        acceleration: Acceleration,
        predictor: Predictor,
        measure: ConvergenceMeasure,
    ) -> Result<Self, CouplingError> {
        let interfaces = graph.interfaces().to_vec();
        let links = interfaces.iter().map(|interface| Link::new(graph, interface));
        let mut links = links.collect::<Result<Vec<_>, _>>()?;
        let open_loop = graph.units().any(Participant::is_open_loop);
        if open_loop {
            // Who does not answer does no work.
            links.iter_mut().for_each(|link| link.account = None);
        }
        let blanks = graph.units().map(|unit| Blank::of(unit.description()));
        let blanks = blanks.collect::<Result<Vec<_>, _>>()?;
        checks::added_mass(graph, settings.kind)?;
        if settings.kind.is_implicit() && settings.iteration_limit == 0 {
            return Err(CouplingError::NoIteration);
        }
        let forgetful = graph.units().find(|unit| !unit.description().capabilities.saved_state);
        if let Some(unit) = forgetful.filter(|_| settings.kind.is_implicit()) {
            return Err(CouplingError::NoState { participant: unit.description().name.clone() });
        }
        let memory = Memory {
            fresh: acceleration.clone(),
            acceleration,
            predictor,
            frozen: blanks.iter().map(|_| FrozenWatch::default()).collect(),
            shape: (0, 0.0),
            floor: None,
            largest_pressure: 0.0,
        };
        let units: Vec<_> = graph.units().map(Participant::description).collect();
        let fingerprint = Fingerprint::of("scheme", &(units, &interfaces, settings, &measure, &memory))
            .map_err(Box::new)?;
        Ok(Self {
            settings,
            measure,
            links,
            blanks,
            order: graph.order(),
            open_loop,
            memory,
            astray: false,
            began: Instant::now(),
            fingerprint,
        })
    }

    /// Hash of everything from which the scheme was made, the units included.
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// The state at the end of the last accepted window, which [`resume`](Self::resume) goes on from; `None` inside a
    /// window that was attempted and not accepted.
    pub fn state(&self) -> Option<SchemeState> {
        let links = self.links.iter().map(Link::state).collect();
        (!self.astray).then(|| SchemeState {
            memory: self.memory.clone(),
            links,
            elapsed: self.began.elapsed(),
        })
    }

    /// Goes on from `state`, of a scheme with the same [`fingerprint`](Self::fingerprint), in the place of
    /// initialisation. The units must be where they were; what they said when they were made was heard then.
    pub fn resume(&mut self, graph: &mut Graph, state: &SchemeState) {
        graph.units_mut().for_each(|unit| drop(unit.messages()));
        self.memory.clone_from(&state.memory);
        self.links.iter_mut().zip(&state.links).for_each(|(link, state)| link.resume(state));
        self.astray = false;
        let now = Instant::now();
        self.began = now.checked_sub(state.elapsed).unwrap_or(now);
    }

    /// Goes on from `state` of a scheme that may have other settings, with units that exchange the same variables. What was
    /// learnt is kept as far as it holds for this scheme: an acceleration that was made otherwise begins without history.
    ///
    /// **Errors**: the acceleration's parameters have no form in which they can be compared.
    pub fn branch(&mut self, graph: &mut Graph, state: &SchemeState) -> Result<(), StateError> {
        let mut fresh = self.memory.fresh.clone();
        fresh.set_floor(state.memory.floor.unwrap_or(0.0));
        let hash = |acceleration: &Acceleration| Fingerprint::of("acceleration", acceleration);
        let mut memory = state.memory.clone();
        let same_size = memory.predictor.resize(self.unknowns());
        if !same_size || hash(&fresh)? != hash(&memory.fresh)? {
            (memory.acceleration, memory.shape) = (fresh.clone(), (0, 0.0));
        }
        memory.fresh = fresh;
        memory.predictor.set_order(&self.memory.predictor);
        self.resume(graph, &SchemeState { memory, ..state.clone() });
        Ok(())
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Initialises all units at `time` (s), the fluids first, because their hydrostatic pressure loads the structures.
    ///
    /// **Errors**: a unit fails.
    pub fn initialise(
        &mut self,
        graph: &mut Graph,
        time: f64,
        ground_acceleration: [f64; 2],
    ) -> Result<WindowReport, StepFailure> {
        self.began = Instant::now();
        let start = Interval { step: 0, time, communication_step: 0.0, ground_acceleration };
        self.reported(graph, &[start], 1, Self::initialise_into)
    }

    fn initialise_into(&mut self, graph: &mut Graph, report: &mut WindowReport) -> Result<(), CouplingError> {
        let Interval { time, ground_acceleration, .. } = report.steps[0];
        let occasion = Occasion::initialisation(time);
        let (structures, fluids): (Vec<_>, Vec<_>) = graph.ids().partition(|&id| graph.is_structure(id));
        for id in fluids.into_iter().chain(structures) {
            let mut inputs = self.blanks[id.0].request(ground_acceleration);
            for link in self.links.iter().filter(|link| link.structure() == id) {
                link.load(&vec![0.0; link.hydrostatic.len()], &mut inputs);
            }
            ask(&mut graph[id], id, occasion, inputs, self.began, &mut report.exchanges)?;
            for link in self.links.iter_mut().filter(|link| link.fluid() == id) {
                let name = link.interface.fluid.variable("hydrostatic_pressure");
                let hydrostatic = graph[id].read(&name)?;
                check_size(graph[id].description(), &name, link.points()[1], hydrostatic.len())?;
                link.mapping.pressure_to_dam(&hydrostatic, &mut link.hydrostatic);
            }
        }
        report.exchanges.iter_mut().for_each(|e| e.accepted = true);
        report.converged = true;
        self.memory.predictor.accept(0.0, &vec![0.0; self.unknowns()]);
        let in_mass = self.settings.kind == SchemeKind::AddedMass;
        for link in &mut self.links {
            let of = |id| report.exchanges.iter().find(|e: &&Exchange| e.unit == id);
            let (Some(structure), Some(fluid)) = (of(link.structure()), of(link.fluid())) else { continue };
            let now = link.at_interface(structure, fluid, in_mass);
            if let (Some(account), Some(now)) = (&mut link.account, now) {
                account.begin(now, ground_acceleration);
            }
        }
        let lowest_pressure = |link: &Link| link.hydrostatic.iter().copied().fold(f64::INFINITY, f64::min);
        let still =
            |link| InterfaceReport { work: None, lowest_pressure: lowest_pressure(link), mapping_error: 0.0 };
        report.interfaces.push(self.links.iter().map(still).collect());
        Ok(())
    }

    /// Takes the steps of a window, repeated together until they converge, and continues from their end.
    ///
    /// **Errors**: as [`attempt`](Self::attempt).
    pub fn advance(&mut self, graph: &mut Graph, steps: &[Interval]) -> Result<WindowReport, StepFailure> {
        let mut report = self.attempt(graph, steps, 1)?;
        self.accept(&mut report);
        Ok(report)
    }

    /// Takes the steps of a window, repeated together until they converge. It starts at the end of the last accepted
    /// window, also after other attempts.
    ///
    /// Where a quasi-Newton acceleration brings no convergence, others take over ([`Acceleration::fallback`]), from the
    /// iterate with the smallest residual.
    ///
    /// In the first window that needs more than one iteration, one iteration checks that the units return to their
    /// saved states, and another measures the rounding floor.
    ///
    /// **Errors**: a unit fails, the iteration limit is reached, or further iterations are useless; with the
    /// exchanges so far.
    pub fn attempt(
        &mut self,
        graph: &mut Graph,
        steps: &[Interval],
        attempt: u32,
    ) -> Result<WindowReport, StepFailure> {
        // The Jacobian depends on the number of unknowns and on the step length.
        let shape = (steps.len(), steps.first().map_or(0.0, |interval| interval.communication_step));
        if self.memory.shape.0 != shape.0 || !SIMILAR.contains(&(shape.1 / self.memory.shape.1)) {
            (self.memory.acceleration, self.memory.shape) = (self.memory.fresh.clone(), shape);
        }
        self.reported(graph, steps, attempt, Self::iterate)
    }

    /// Accepts the window that was attempted last.
    pub fn accept(&mut self, report: &mut WindowReport) {
        self.astray = false;
        let last = report.iterations();
        report.exchanges.iter_mut().for_each(|e| e.accepted = e.occasion.iteration == last);
        for (number, watch) in self.memory.frozen.iter_mut().enumerate() {
            watch.accept(UnitId(number), report);
        }
        let in_mass = self.settings.kind == SchemeKind::AddedMass;
        for interval in report.steps.clone() {
            let of = |id| report.accepted(id, interval.step);
            let Some(answers) = (0..self.blanks.len()).map(|id| of(UnitId(id))).collect::<Option<Vec<_>>>()
            else {
                continue;
            };
            let pressure = self.pressure(&answers);
            self.memory.largest_pressure = self.memory.largest_pressure.max(norm(pressure.iter().copied()));
            let unknowns = self.unknowns_of(&answers);
            self.memory.predictor.accept(interval.communication_step, &unknowns);
            let mut interfaces = Vec::with_capacity(self.links.len());
            for link in &mut self.links {
                let [structure, fluid] = [link.structure(), link.fluid()].map(|id| answers[id.0]);
                let pressure = link.pressure(fluid);
                let total = link.hydrostatic.iter().zip(&pressure).map(|(still, moving)| still + moving);
                let lowest_pressure = total.fold(f64::INFINITY, f64::min);
                let mapping_error = link.mapping_error(structure, fluid);
                let now = link.at_interface(structure, fluid, in_mass);
                let work = link.account.as_mut().zip(now).map(|(account, now)| account.step(&interval, now));
                interfaces.push(InterfaceReport { work, lowest_pressure, mapping_error });
            }
            report.interfaces.push(interfaces);
        }
    }

    /// Fills a report by `call` and adds times and messages of the units.
    fn reported(
        &mut self,
        graph: &mut Graph,
        steps: &[Interval],
        attempt: u32,
        call: impl FnOnce(&mut Self, &mut Graph, &mut WindowReport) -> Result<(), CouplingError>,
    ) -> Result<WindowReport, StepFailure> {
        let mut report = WindowReport { steps: steps.to_vec(), attempt, ..WindowReport::default() };
        let before: Vec<Duration> = graph.units().map(Participant::busy).collect();
        let result = call(self, graph, &mut report);
        let spent = graph.units().zip(before).map(|(unit, before)| unit.busy().saturating_sub(before));
        report.solver_time = spent.collect();
        report.unit_time = if self.settings.kind.is_parallel() {
            report.solver_time.iter().copied().max().unwrap_or_default()
        } else {
            report.solver_time.iter().sum()
        };
        report.messages = graph.units_mut().flat_map(|unit| unit.messages()).collect();
        report.rounding_floor = self.memory.floor;
        match result {
            Ok(()) => Ok(report),
            Err(error) => {
                report.outcome = error.to_string();
                Err(StepFailure { report: Box::new(report), error })
            }
        }
    }

    fn iterate(&mut self, graph: &mut Graph, report: &mut WindowReport) -> Result<(), CouplingError> {
        let mut unknowns = self.guess(&report.steps);
        let mut previous: Option<Vec<f64>> = None;
        let mut guard = Guard::default();
        let mut first = None;
        // the iterate with the smallest residual
        let mut best: Option<(f64, Vec<f64>, Vec<f64>)> = None;
        // the scene's acceleration, without its past, where others took over
        let mut own: Option<Acceleration> = None;
        self.memory.acceleration.begin_step();
        if std::mem::replace(&mut self.astray, true) {
            self.restore(graph)?;
        } else {
            graph.units_mut().try_for_each(|unit| unit.save_state())?;
        }
        let mut iteration = 0;
        let mut left = self.settings.iteration_limit;
        loop {
            iteration += 1;
            // A probe measures the Jacobian and is no iterate of this window.
            let probe = self.memory.acceleration.measuring();
            let purpose = if probe { Purpose::Jacobian } else { Purpose::Solution };
            let Answer { unknowns: answered, displacement } =
                self.evaluate(graph, &unknowns, iteration, purpose, report)?;
            if !self.settings.kind.is_implicit() {
                if self.settings.kind != SchemeKind::AddedMass && !self.open_loop {
                    let residuals = self.residuals(report, &displacement, None, [&unknowns, &answered], None);
                    self.compared(report, residuals, [&unknowns, &answered]);
                }
                return self.finish(graph, report, true, "not repeated: the scheme is explicit");
            }
            let mut residual: Vec<f64> = answered.iter().zip(&unknowns).map(|(q, p)| q - p).collect();
            if !probe {
                left -= 1;
                let (before, both) = (previous.as_deref(), [&unknowns[..], &answered]);
                let residuals = self.residuals(report, &displacement, before, both, first);
                first.get_or_insert(residuals.pressure);
                self.compared(report, residuals, [&unknowns, &answered]);
                if self.measure.converged(&residuals) {
                    // What took over served this window only.
                    if report.fallbacks > 1 {
                        self.memory.acceleration = own.unwrap_or_else(|| self.memory.fresh.clone());
                    }
                    return self.finish(graph, report, true, "converged");
                }
                previous = Some(displacement);
                if best.as_ref().is_none_or(|(smallest, ..)| residuals.pressure < *smallest) {
                    best = Some((residuals.pressure, unknowns.clone(), residual.clone()));
                }
                let watched = match self.measure.unbounded(&answered) {
                    Some(why) => Err(why),
                    None => guard.observe(residuals.pressure, answered.len(), self.memory.floor),
                };
                if watched.is_err() || left == 0 {
                    let own = own.get_or_insert_with(|| {
                        let mut acceleration = self.memory.acceleration.clone();
                        acceleration.forget();
                        acceleration
                    });
                    let rounding = matches!(watched, Err(Hopeless::RoundingFloor { .. }));
                    let next = own.fallback(report.fallbacks as usize).filter(|_| !rounding);
                    let Some((acceleration, (_, from, of))) = next.zip(best.clone()) else {
                        if report.fallbacks > 0 {
                            self.memory.acceleration = own.clone();
                        }
                        let diverges =
                            matches!(watched, Err(Hopeless::Diverging { .. } | Hopeless::Unbounded { .. }));
                        return match watched {
                            _ if self.settings.accept_unconverged && !diverges => {
                                let why = match watched {
                                    Err(why) => why.to_string(),
                                    Ok(()) => "reached the iteration limit".to_owned(),
                                };
                                self.finish(graph, report, false, &format!("accepted unconverged: {why}"))
                            }
                            Err(why) => Err(hopeless(report, iteration, why)),
                            Ok(()) => Err(self.not_converged(report, residuals)),
                        };
                    };
                    report.fallbacks += 1;
                    self.memory.acceleration = acceleration;
                    self.memory.acceleration.begin_step();
                    (unknowns, residual) = (from, of);
                    (guard, left) = (Guard::default(), self.settings.iteration_limit);
                }
            }
            let hydrostatic = self.links.iter().flat_map(|link| &link.hydrostatic);
            let largest = unknowns.iter().chain(hydrostatic).fold(0.0, |a: f64, b| a.max(b.abs()));
            if self.memory.floor.is_none() && largest > 0.0 && norm(answered.iter().copied()) > 0.0 {
                iteration += 2;
                self.check_states(graph, &unknowns, iteration - 1, report)?;
                let change = checks::FLOOR_PROBE * f64::EPSILON * largest;
                self.measure_floor(graph, [&unknowns, &residual], change, iteration, report)?;
                self.memory.acceleration.set_floor(self.memory.floor.unwrap_or(0.0));
                self.memory.fresh.set_floor(self.memory.floor.unwrap_or(0.0));
            }
            self.memory.acceleration.accelerate(&mut unknowns, &residual);
            self.restore(graph)?;
        }
    }

    /// Accepts the last answer, unless a unit has frozen.
    fn finish(
        &self,
        graph: &Graph,
        report: &mut WindowReport,
        converged: bool,
        outcome: &str,
    ) -> Result<(), CouplingError> {
        for id in &self.order {
            if let Some(steps) = self.memory.frozen[id.0].frozen(*id, report) {
                let (step, time) = (report.step(), report.time());
                let participant = graph[*id].description().name.clone();
                return Err(CouplingError::Frozen { participant, step, time, steps });
            }
        }
        report.converged = converged;
        outcome.clone_into(&mut report.outcome);
        report.largest_pressure = self.memory.largest_pressure;
        if self.settings.kind != SchemeKind::AddedMass && report.steps.len() == 1 {
            let last = report.iterations();
            let of =
                |id| report.exchanges.iter().rfind(|e| e.unit == UnitId(id) && e.occasion.iteration == last);
            if let Some(answers) = (0..self.blanks.len()).map(of).collect::<Option<Vec<_>>>() {
                let pressure = self.pressure(&answers);
                report.largest_pressure = self.memory.largest_pressure.max(norm(pressure.iter().copied()));
                report.interpolation_error = self.interpolation_error(report, &pressure);
            }
        }
        Ok(())
    }

    /// Error of the pressure that is linear within the step, of a window of one step that ends with `unknowns`.
    fn interpolation_error(&self, report: &WindowReport, unknowns: &[f64]) -> Option<f64> {
        let [interval] = report.steps[..] else { return None };
        // The unknowns begin with the pressures, which alone are compared.
        let pressure = &unknowns[..self.pressures()];
        self.memory.predictor.interpolation_error(interval.communication_step, pressure)
    }

    fn restore(&self, graph: &mut Graph) -> Result<(), ParticipantError> {
        graph.units_mut().try_for_each(|unit| unit.restore_state())
    }

    /// Number of pressures of a step.
    fn pressures(&self) -> usize {
        self.links.iter().map(|link| link.points()[0]).sum()
    }

    /// Number of unknowns of a step.
    fn unknowns(&self) -> usize {
        let motion = self.links.iter().map(|link| link.points()[1]).sum();
        self.pressures() + if self.settings.kind.is_parallel() { motion } else { 0 }
    }

    /// The unknowns in the answers of all units.
    fn unknowns_of(&self, answers: &[&Exchange]) -> Vec<f64> {
        let mut unknowns = self.pressure(answers);
        if self.settings.kind.is_parallel() {
            let accelerations =
                self.links.iter().flat_map(|link| link.acceleration(answers[link.structure().0]));
            unknowns.extend(accelerations.map(|a| self.settings.acceleration_scale * a));
        }
        unknowns
    }

    /// The pressures that the fluids answered, at the structures' points.
    fn pressure(&self, answers: &[&Exchange]) -> Vec<f64> {
        self.links.iter().flat_map(|link| link.pressure(answers[link.fluid().0])).collect()
    }

    /// The first guess of a window's unknowns.
    fn guess(&self, steps: &[Interval]) -> Vec<f64> {
        let (size, start) = (self.unknowns(), steps.first().map_or(0.0, |interval| interval.time));
        let mut unknowns = vec![0.0; size * steps.len()];
        if self.settings.kind != SchemeKind::AddedMass {
            for (interval, values) in steps.iter().zip(unknowns.chunks_mut(size)) {
                let ahead =
                    if interval.time == start { interval.communication_step } else { interval.end() - start };
                self.memory.predictor.predict(ahead, values);
            }
        }
        unknowns
    }

    /// One iteration: G(x).
    fn evaluate(
        &self,
        graph: &mut Graph,
        unknowns: &[f64],
        iteration: u32,
        purpose: Purpose,
        report: &mut WindowReport,
    ) -> Result<Answer, CouplingError> {
        let probe = purpose != Purpose::Solution;
        let correction = self.memory.acceleration.correction();
        let (residuals, worst) = (None, None);
        report.iterates.push(IterationReport { iteration, purpose, correction, residuals, worst });
        let this = Iteration {
            links: &self.links,
            blanks: &self.blanks,
            order: &self.order,
            began: self.began,
            steps: &report.steps,
            attempt: report.attempt,
            iteration,
            probe,
        };
        let from = report.exchanges.len();
        let Given { pressure, acceleration } = self.given(unknowns);
        if self.settings.kind.is_parallel() {
            this.at_once(graph, &Given { pressure, acceleration }, &mut report.exchanges)?;
        } else {
            this.one_after_the_other(graph, pressure, &mut report.exchanges)?;
        }
        let (mut answered, mut displacement) = (Vec::with_capacity(unknowns.len()), Vec::new());
        for index in 0..report.steps.len() {
            let of = |id| report.exchanges[from..].iter().filter(move |e| e.unit == UnitId(id)).nth(index);
            let answers: Vec<&Exchange> = (0..self.blanks.len()).filter_map(of).collect();
            answered.extend(self.unknowns_of(&answers));
            for link in &self.links {
                displacement.extend_from_slice(link.displacement(answers[link.structure().0]));
            }
        }
        if (probe || !self.settings.kind.is_implicit())
            && let Some(why) = self.measure.unbounded(&answered)
        {
            return Err(hopeless(report, iteration, why));
        }
        Ok(Answer { unknowns: answered, displacement })
    }

    /// What the unknowns x give to the units.
    fn given(&self, unknowns: &[f64]) -> Given {
        let none = || vec![Vec::new(); self.links.len()];
        let (mut pressure, mut acceleration) = (none(), none());
        for step in unknowns.chunks(self.unknowns()) {
            let mut rest = step;
            for (link, pressure) in self.links.iter().zip(&mut pressure) {
                let (of_link, others) = rest.split_at(link.points()[0]);
                pressure.extend_from_slice(of_link);
                rest = others;
            }
            for (link, acceleration) in self.links.iter().zip(&mut acceleration) {
                // A serial scheme has no more unknowns.
                let (of_link, others) = rest.split_at(link.points()[1].min(rest.len()));
                acceleration.extend(of_link.iter().map(|a| a / self.settings.acceleration_scale));
                rest = others;
            }
        }
        Given { pressure, acceleration }
    }

    /// The residuals of an iteration, the larger of those of pressure and of acceleration where both are unknown.
    fn residuals(
        &self,
        report: &WindowReport,
        displacement: &[f64],
        previous: Option<&[f64]>,
        [given, answered]: [&[f64]; 2],
        first: Option<f64>,
    ) -> Residuals {
        let points = self.pressures();
        let part = |values: &[f64], of_pressure: bool| -> Vec<f64> {
            let steps = values.chunks(self.unknowns()).map(|step| step.split_at(points));
            steps.flat_map(|(p, a)| if of_pressure { p } else { a }).copied().collect()
        };
        let step_error = self.interpolation_error(report, answered);
        let known = Known { first, step_error, largest: self.memory.largest_pressure };
        let of = |pressure| {
            let (given, answered) = (part(given, pressure), part(answered, pressure));
            self.measure.residuals(displacement, previous, [&given, &answered], known)
        };
        let pressure = of(true);
        if self.settings.kind.is_parallel() { pressure.or_larger(&of(false)) } else { pressure }
    }

    /// Adds to the last iteration how far its answer is from its guess, and where it is farthest.
    fn compared(&self, report: &mut WindowReport, residuals: Residuals, [given, answered]: [&[f64]; 2]) {
        let farther = |best: Option<(f64, usize)>, place: usize| {
            let far = (answered[place] - given[place]).abs();
            if best.is_none_or(|(farthest, _)| far > farthest) { Some((far, place)) } else { best }
        };
        let (size, pressures) = (self.unknowns(), self.pressures());
        let places = (0..given.len()).filter(|place| place % size < pressures);
        let worst = places.fold(None, farther).map(|(_, place)| {
            let (mut interface, mut point) = (0, place % size);
            while point >= self.links[interface].points()[0] {
                point -= self.links[interface].points()[0];
                interface += 1;
            }
            let step = report.step() + (place / size) as u64;
            WorstPoint { step, interface, point, given: given[place], answered: answered[place] }
        });
        if let Some(iterate) = report.iterates.last_mut() {
            (iterate.residuals, iterate.worst) = (Some(residuals), worst);
        }
    }

    fn not_converged(&self, report: &WindowReport, residuals: Residuals) -> CouplingError {
        CouplingError::NotConverged {
            step: report.step(),
            time: report.time(),
            iterations: self.settings.iteration_limit,
            pressure: residuals.pressure,
            pressure_ratio: residuals.pressure_ratio,
            displacement: residuals.displacement,
            tolerance: self.measure.tolerance,
        }
    }
}

fn hopeless(report: &WindowReport, iteration: u32, why: Hopeless) -> CouplingError {
    CouplingError::Hopeless { step: report.step(), time: report.time(), iteration, why }
}
