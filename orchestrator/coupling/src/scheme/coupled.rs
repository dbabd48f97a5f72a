mod checks;

use super::evaluation::{Given, Iteration, call};
use super::frozen::FrozenWatch;
use super::link::{Link, LinkState, RequestTemplate};
use super::{
    Account, CouplingError, Direction, Exchange, Graph, InterfaceReport, Interval, IterationReport,
    Predictor, Purpose, SchemeKind, StepFailure, UnitId, WindowReport, WorstPoint,
};
use crate::acceleration::Acceleration;
use crate::convergence::{ConvergenceMeasure, Guard, IterationFailure, IterationInfo, Residuals, norm};
use crate::participant::{Occasion, Participant, ParticipantError};
use crate::signal::Signal;
use cofferdam_unit::{Fingerprint, StateError};
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
}

impl Default for Settings {
    fn default() -> Self {
        Self { kind: SchemeKind::SerialImplicit, iteration_limit: 100, accept_unconverged: false }
    }
}

/// Takes communication steps with the units of a [`Graph`], by a [`SchemeKind`].
///
/// The unknowns x of a window are the backward fields of all interfaces at the ends of its steps; for a parallel scheme also
/// the forward fields, multiplied by [`Field::weight`](super::Field::weight). An iteration G takes every step of the window with
/// each unit; one [`Acceleration`] moves x towards x = G(x), so that interfaces that act on each other converge together.
/// An iteration is one step of each unit per communication step, the confirming one included.
///
/// **Call order**: [`initialise`](Self::initialise); then [`advance`](Self::advance), or
/// [`attempt`](Self::attempt) and, if its report is good, [`accept`](Self::accept); if not, another attempt at the
/// same time.
pub struct Scheme {
    settings: Settings,
    measure: ConvergenceMeasure,
    links: Vec<Link>,
    /// One for each unit.
    templates: Vec<RequestTemplate>,
    signals: Vec<Signal>,
    /// In which the units are called.
    order: Vec<UnitId>,
    /// Whether the outputs of a unit are known in advance, so that a first guess says nothing.
    open_loop: bool,
    /// Unit of the residual, such as Pa.
    unit: String,
    /// Whether every unknown of a step is relaxed; otherwise, which are.
    relaxed: Option<Vec<bool>>,
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
    /// Change of the residual by rounding.
    floor: Option<f64>,
    /// Largest norm of accepted backward fields.
    largest: f64,
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
    monitored: Vec<f64>,
}

/// Ratios of step lengths between which an acceleration keeps its history.
const SIMILAR: std::ops::Range<f64> = 0.6..1.7;

impl Scheme {
    /// A scheme for the units of `graph`, which receive `signals`.
    ///
    /// **Errors**: a unit lacks a coupled variable; the points of an interface differ; the response of a second unit is both
    /// included in the first and exchanged, or neither; an implicit scheme with an iteration limit of 0.
    pub fn new(
        graph: &mut Graph,
        settings: Settings,
        acceleration: Acceleration,
        predictor: Predictor,
        measure: ConvergenceMeasure,
        signals: Vec<Signal>,
    ) -> Result<Self, CouplingError> {
        let interfaces = graph.interfaces().to_vec();
        let links = interfaces.iter().map(|interface| Link::new(graph, interface));
        let links = links.collect::<Result<Vec<_>, _>>()?;
        let open_loop = graph.units().any(Participant::is_open_loop);
        let templates =
            graph.units().map(|unit| RequestTemplate::new(unit.description(), &signals)).collect();
        checks::included(graph, settings.kind)?;
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
            frozen: graph.ids().map(|_| FrozenWatch::default()).collect(),
            shape: (0, 0.0),
            floor: None,
            largest: 0.0,
        };
        let units: Vec<_> = graph.units().map(Participant::description).collect();
        let fingerprint = Fingerprint::of("scheme", &(units, &interfaces, settings, &measure, &memory))
            .map_err(Box::new)?;
        let unit = links.first().map_or_else(String::new, |link| link.unit(graph));
        let mut scheme = Self {
            settings,
            measure,
            links,
            templates,
            signals,
            order: graph.order(),
            open_loop,
            unit,
            relaxed: None,
            memory,
            astray: false,
            began: Instant::now(),
            fingerprint,
        };
        let relaxed = scheme.relaxed();
        scheme.relaxed = relaxed.contains(&false).then_some(relaxed);
        Ok(scheme)
    }

    /// The same with accounts of the work at the interfaces, in the order of the graph's. Where a unit is
    /// [open loop](Participant::is_open_loop), no work is accounted for, because it does not respond.
    pub fn with_accounts(mut self, accounts: Vec<Option<Box<dyn Account>>>) -> Self {
        if !self.open_loop {
            self.links.iter_mut().zip(accounts).for_each(|(link, account)| link.account = account);
        }
        self
    }

    /// The external signals.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// Replaces an external signal by one with the same input, from the next window on.
    pub fn replace_signal(&mut self, signal: Signal) {
        self.signals
            .iter_mut()
            .filter(|old| old.input == signal.input)
            .for_each(|old| old.clone_from(&signal));
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

    /// Initialises all units at `time` (s), the second ones first: the first units receive the constant parts of their fields.
    ///
    /// **Errors**: a unit fails.
    pub fn initialise(&mut self, graph: &mut Graph, time: f64) -> Result<WindowReport, StepFailure> {
        self.began = Instant::now();
        let start = Interval { step: 0, time, communication_step: 0.0 };
        self.reported(graph, &[start], 1, Self::initialise_into)
    }

    fn initialise_into(&mut self, graph: &mut Graph, report: &mut WindowReport) -> Result<(), CouplingError> {
        let time = report.steps[0].time;
        let occasion = Occasion::initialisation(time);
        let (firsts, seconds): (Vec<_>, Vec<_>) = graph.ids().partition(|&id| graph.is_first(id));
        for id in seconds.into_iter().chain(firsts) {
            let mut inputs = self.templates[id.0].request(&self.signals, time);
            for link in self.links.iter().filter(|link| link.first() == id) {
                link.give_first(&vec![0.0; link.received()[0]], &mut inputs);
            }
            call(&mut graph[id], id, occasion, inputs, self.began, &mut report.exchanges)?;
            for link in self.links.iter_mut().filter(|link| link.second() == id) {
                link.read_constant(&mut graph[id])?;
            }
        }
        report.exchanges.iter_mut().for_each(|e| e.accepted = true);
        report.converged = true;
        self.memory.predictor.accept(0.0, &vec![0.0; self.unknowns()]);
        let one_way = self.settings.kind == SchemeKind::OneWay;
        for link in &mut self.links {
            let of = |id| report.exchanges.iter().find(|e: &&Exchange| e.unit == id);
            if let (Some(first), Some(second)) = (of(link.first()), of(link.second())) {
                link.begin_account([first, second], one_way, &self.signals);
            }
        }
        let lowest = |link: &Link| link.constant.iter().copied().fold(f64::INFINITY, f64::min);
        let still = |link| InterfaceReport { work: None, lowest: lowest(link), mapping_error: 0.0 };
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
        let one_way = self.settings.kind == SchemeKind::OneWay;
        for interval in report.steps.clone() {
            let of = |id| report.accepted(id, interval.step);
            let Some(answers) =
                (0..self.templates.len()).map(|id| of(UnitId(id))).collect::<Option<Vec<_>>>()
            else {
                continue;
            };
            let backward = self.backward(&answers);
            self.memory.largest = self.memory.largest.max(norm(backward.iter().copied()));
            let unknowns = self.unknowns_of(&answers);
            self.memory.predictor.accept(interval.communication_step, &unknowns);
            let mut interfaces = Vec::with_capacity(self.links.len());
            for link in &mut self.links {
                let [first, second] = [link.first(), link.second()].map(|id| answers[id.0]);
                let values = link.backward(second);
                let total = link.constant.iter().zip(&values).map(|(still, moving)| still + moving);
                let lowest = total.fold(f64::INFINITY, f64::min);
                let mapping_error = link.mapping_error(first, second);
                let work = link.work(&interval, [first, second], one_way, &self.signals);
                interfaces.push(InterfaceReport { work, lowest, mapping_error });
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
        // the chosen acceleration, without its past, where others took over
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
            let Answer { unknowns: answered, monitored } =
                self.evaluate(graph, &unknowns, iteration, purpose, report)?;
            if !self.settings.kind.is_implicit() {
                if self.settings.kind != SchemeKind::OneWay && !self.open_loop {
                    let residuals = self.residuals(report, &monitored, None, [&unknowns, &answered], None);
                    self.compared(report, residuals, [&unknowns, &answered]);
                }
                return self.finish(graph, report, true, "not repeated: the scheme is explicit");
            }
            let mut residual: Vec<f64> = answered.iter().zip(&unknowns).map(|(q, p)| q - p).collect();
            if !probe {
                left -= 1;
                let (before, both) = (previous.as_deref(), [&unknowns[..], &answered]);
                let residuals = self.residuals(report, &monitored, before, both, first);
                first.get_or_insert(residuals.norm);
                self.compared(report, residuals, [&unknowns, &answered]);
                if self.measure.converged(&residuals) {
                    // What took over served this window only.
                    if report.fallbacks > 1 {
                        self.memory.acceleration = own.unwrap_or_else(|| self.memory.fresh.clone());
                    }
                    return self.finish(graph, report, true, "converged");
                }
                previous = Some(monitored);
                if best.as_ref().is_none_or(|(smallest, ..)| residuals.norm < *smallest) {
                    best = Some((residuals.norm, unknowns.clone(), residual.clone()));
                }
                let watched = match self.measure.unbounded(&answered) {
                    Some(why) => Err(why),
                    None => guard.observe(residuals.norm, answered.len(), self.memory.floor),
                };
                if watched.is_err() || left == 0 {
                    let own = own.get_or_insert_with(|| {
                        let mut acceleration = self.memory.acceleration.clone();
                        acceleration.forget();
                        acceleration
                    });
                    let rounding = matches!(watched, Err(IterationFailure::RoundingFloor { .. }));
                    let next = own.fallback(report.fallbacks as usize).filter(|_| !rounding);
                    let Some((acceleration, (_, from, of))) = next.zip(best.clone()) else {
                        if report.fallbacks > 0 {
                            self.memory.acceleration = own.clone();
                        }
                        let diverges = matches!(
                            watched,
                            Err(IterationFailure::Diverging { .. } | IterationFailure::Unbounded { .. })
                        );
                        return match watched {
                            _ if self.settings.accept_unconverged && !diverges => {
                                let why = match watched {
                                    Err(why) => why.in_unit(&self.unit),
                                    Ok(()) => "reached the iteration limit".to_owned(),
                                };
                                self.finish(graph, report, false, &format!("accepted unconverged: {why}"))
                            }
                            Err(why) => Err(self.futile(report, iteration, why)),
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
            let constant = self.links.iter().flat_map(|link| &link.constant);
            let largest = unknowns.iter().chain(constant).fold(0.0, |a: f64, b| a.max(b.abs()));
            if self.memory.floor.is_none() && largest > 0.0 && norm(answered.iter().copied()) > 0.0 {
                iteration += 2;
                self.check_states(graph, &unknowns, iteration - 1, report)?;
                let change = checks::FLOOR_PROBE * f64::EPSILON * largest;
                self.measure_floor(graph, [&unknowns, &residual], change, iteration, report)?;
                self.memory.acceleration.set_floor(self.memory.floor.unwrap_or(0.0));
                self.memory.fresh.set_floor(self.memory.floor.unwrap_or(0.0));
            }
            self.accelerate(&mut unknowns, &residual);
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
        report.largest = self.memory.largest;
        if self.settings.kind != SchemeKind::OneWay && report.steps.len() == 1 {
            let last = report.iterations();
            let of =
                |id| report.exchanges.iter().rfind(|e| e.unit == UnitId(id) && e.occasion.iteration == last);
            if let Some(answers) = (0..self.templates.len()).map(of).collect::<Option<Vec<_>>>() {
                let backward = self.backward(&answers);
                report.largest = self.memory.largest.max(norm(backward.iter().copied()));
                report.interpolation_error = self.interpolation_error(report, &backward);
            }
        }
        Ok(())
    }

    /// Error of values that are linear within the step, of a window of one step that ends with `unknowns`.
    fn interpolation_error(&self, report: &WindowReport, unknowns: &[f64]) -> Option<f64> {
        let [interval] = report.steps[..] else { return None };
        // The unknowns begin with the backward fields, which alone are compared.
        let backward = &unknowns[..self.backward_values()];
        self.memory.predictor.interpolation_error(interval.communication_step, backward)
    }

    fn restore(&self, graph: &mut Graph) -> Result<(), ParticipantError> {
        graph.units_mut().try_for_each(|unit| unit.restore_state())
    }

    /// Number of values of a step that go backward.
    fn backward_values(&self) -> usize {
        self.links.iter().map(|link| link.received()[0]).sum()
    }

    /// Number of unknowns of a step.
    fn unknowns(&self) -> usize {
        let forward = self.links.iter().map(|link| link.received()[1]).sum();
        self.backward_values() + if self.settings.kind.is_parallel() { forward } else { 0 }
    }

    /// Which unknowns of a step are relaxed.
    fn relaxed(&self) -> Vec<bool> {
        let of = |direction| self.links.iter().flat_map(move |link| link.relaxed(direction));
        let forward = of(Direction::Forward).take(self.unknowns() - self.backward_values());
        of(Direction::Backward).chain(forward).collect()
    }

    /// Moves the relaxed unknowns by the acceleration, and the others to their answer.
    fn accelerate(&mut self, unknowns: &mut [f64], residual: &[f64]) {
        let Some(relaxed) = &self.relaxed else {
            return self.memory.acceleration.accelerate(unknowns, residual);
        };
        let picked = |values: &[f64]| -> Vec<f64> {
            let chosen = values.iter().zip(relaxed.iter().cycle()).filter(|(_, relaxed)| **relaxed);
            chosen.map(|(value, _)| *value).collect()
        };
        let (mut moved, of_moved) = (picked(unknowns), picked(residual));
        self.memory.acceleration.accelerate(&mut moved, &of_moved);
        let mut moved = moved.into_iter();
        for ((x, r), relaxed) in unknowns.iter_mut().zip(residual).zip(relaxed.iter().cycle()) {
            *x = if *relaxed { moved.next().unwrap_or(*x) } else { *x + r };
        }
    }

    /// The unknowns in the answers of all units.
    fn unknowns_of(&self, answers: &[&Exchange]) -> Vec<f64> {
        let mut unknowns = self.backward(answers);
        if self.settings.kind.is_parallel() {
            for link in &self.links {
                let forward = link.forward(answers[link.first().0]);
                unknowns.extend(forward.iter().zip(link.weights()).map(|(a, weight)| weight * a));
            }
        }
        unknowns
    }

    /// The backward fields that the second units answered, at the first units' points.
    fn backward(&self, answers: &[&Exchange]) -> Vec<f64> {
        self.links.iter().flat_map(|link| link.backward(answers[link.second().0])).collect()
    }

    /// The first guess of a window's unknowns.
    fn guess(&self, steps: &[Interval]) -> Vec<f64> {
        let (size, start) = (self.unknowns(), steps.first().map_or(0.0, |interval| interval.time));
        let mut unknowns = vec![0.0; size * steps.len()];
        if self.settings.kind != SchemeKind::OneWay {
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
            templates: &self.templates,
            signals: &self.signals,
            order: &self.order,
            began: self.began,
            steps: &report.steps,
            attempt: report.attempt,
            iteration,
            probe,
        };
        let from = report.exchanges.len();
        let given = self.given(unknowns);
        if self.settings.kind.is_parallel() {
            this.at_once(graph, &given, &mut report.exchanges)?;
        } else {
            this.one_after_the_other(graph, given.backward, &mut report.exchanges)?;
        }
        let (mut answered, mut monitored) = (Vec::with_capacity(unknowns.len()), Vec::new());
        for index in 0..report.steps.len() {
            let of = |id| report.exchanges[from..].iter().filter(move |e| e.unit == UnitId(id)).nth(index);
            let answers: Vec<&Exchange> = (0..self.templates.len()).filter_map(of).collect();
            answered.extend(self.unknowns_of(&answers));
            for link in &self.links {
                monitored.extend_from_slice(link.monitored(answers[link.first().0]));
            }
        }
        if (probe || !self.settings.kind.is_implicit())
            && let Some(why) = self.measure.unbounded(&answered)
        {
            return Err(self.futile(report, iteration, why));
        }
        Ok(Answer { unknowns: answered, monitored })
    }

    /// What the unknowns x give to the units.
    fn given(&self, unknowns: &[f64]) -> Given {
        let none = || vec![Vec::new(); self.links.len()];
        let (mut backward, mut forward) = (none(), none());
        for step in unknowns.chunks(self.unknowns()) {
            let mut rest = step;
            for (link, backward) in self.links.iter().zip(&mut backward) {
                let (of_link, others) = rest.split_at(link.received()[0]);
                backward.extend_from_slice(of_link);
                rest = others;
            }
            for (link, forward) in self.links.iter().zip(&mut forward) {
                // A serial scheme has no more unknowns.
                let (of_link, others) = rest.split_at(link.received()[1].min(rest.len()));
                forward.extend(of_link.iter().zip(link.weights()).map(|(a, weight)| a / weight));
                rest = others;
            }
        }
        Given { backward, forward }
    }

    /// The residuals of an iteration, the larger of those of backward and of forward fields where both are unknown.
    fn residuals(
        &self,
        report: &WindowReport,
        monitored: &[f64],
        previous: Option<&[f64]>,
        [given, answered]: [&[f64]; 2],
        first: Option<f64>,
    ) -> Residuals {
        let size = self.backward_values();
        let part = |values: &[f64], backward: bool| -> Vec<f64> {
            let steps = values.chunks(self.unknowns()).map(|step| step.split_at(size));
            steps.flat_map(|(p, a)| if backward { p } else { a }).copied().collect()
        };
        let step_error = self.interpolation_error(report, answered);
        let known = IterationInfo { first, step_error, largest: self.memory.largest };
        let of = |backward| {
            let (given, answered) = (part(given, backward), part(answered, backward));
            self.measure.residuals(monitored, previous, [&given, &answered], known)
        };
        let backward = of(true);
        if self.settings.kind.is_parallel() { backward.or_larger(&of(false)) } else { backward }
    }

    /// Adds to the last iteration how far its answer is from its guess, and where it is farthest.
    fn compared(&self, report: &mut WindowReport, residuals: Residuals, [given, answered]: [&[f64]; 2]) {
        let farther = |best: Option<(f64, usize)>, place: usize| {
            let far = (answered[place] - given[place]).abs();
            if best.is_none_or(|(farthest, _)| far > farthest) { Some((far, place)) } else { best }
        };
        let (size, compared) = (self.unknowns(), self.backward_values());
        let places = (0..given.len()).filter(|place| place % size < compared);
        let worst = places.fold(None, farther).map(|(_, place)| {
            let (mut interface, mut point) = (0, place % size);
            while point >= self.links[interface].received()[0] {
                point -= self.links[interface].received()[0];
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
            residual: residuals.norm,
            unit: self.unit.clone(),
            relative_ratio: residuals.relative_ratio,
            change: residuals.change,
            tolerance: self.measure.tolerance,
        }
    }

    fn futile(&self, report: &WindowReport, iteration: u32, why: IterationFailure) -> CouplingError {
        CouplingError::Futile {
            step: report.step(),
            time: report.time(),
            iteration,
            why,
            unit: self.unit.clone(),
        }
    }
}
