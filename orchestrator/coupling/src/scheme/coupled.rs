mod checks;
mod iteration;
mod unknowns;

use super::evaluation::call;
use super::frozen::FrozenWatch;
use super::link::{Link, LinkState, RequestTemplate};
use super::{
    Account, CouplingError, Exchange, Graph, InterfaceReport, Interval, Predictor, SchemeKind, StepFailure,
    UnitId, WindowReport,
};
use crate::acceleration::Acceleration;
use crate::convergence::{ConvergenceMeasure, Measure, norm};
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
    /// included in the first and exchanged, or neither; an implicit scheme with an iteration limit of 0; a measure of a change
    /// where nothing is [monitored](super::Interface::monitored).
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
        let monitors = interfaces.iter().any(|interface| interface.monitored.is_some());
        if measure.measures.contains(&Measure::Change) && !monitors {
            return Err(CouplingError::NotMonitored);
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

    /// Replaces an external signal by one with the same input and component, from the next window on.
    pub fn replace_signal(&mut self, signal: Signal) {
        self.signals
            .iter_mut()
            .filter(|old| old.input == signal.input && old.component == signal.component)
            .for_each(|old| old.clone_from(&signal));
    }

    /// Hash of everything from which the scheme was made, the units included.
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// The state at the end of the last accepted window, which [`resume`](Self::resume) continues from; `None` inside a
    /// window that was attempted and not accepted.
    pub fn state(&self) -> Option<SchemeState> {
        let links = self.links.iter().map(Link::state).collect();
        (!self.astray).then(|| SchemeState {
            memory: self.memory.clone(),
            links,
            elapsed: self.began.elapsed(),
        })
    }

    /// Goes on from `state`, of a scheme with the same [`fingerprint`](Self::fingerprint), in place of
    /// initialisation. The units must be where they were; what they said when they were made was heard then.
    pub fn resume(&mut self, graph: &mut Graph, state: &SchemeState) {
        graph.units_mut().for_each(|unit| drop(unit.messages()));
        self.memory.clone_from(&state.memory);
        self.links.iter_mut().zip(&state.links).for_each(|(link, state)| link.resume(state));
        self.astray = false;
        let now = Instant::now();
        self.began = now.checked_sub(state.elapsed).unwrap_or(now);
    }

    /// Gives up a window that failed: the units are where they were before it, and so is what was learnt, from the `state` that was
    /// taken there. What follows owes nothing to the failed attempts. All units must write their states.
    ///
    /// **Errors**: a unit does not return to its state.
    pub fn abandon(&mut self, graph: &mut Graph, state: &SchemeState) -> Result<(), CouplingError> {
        if self.astray {
            self.restore(graph)?;
            // A unit that reads a state forgets its attempts too, which are no part of it.
            let states = graph.serialise()?;
            graph.deserialise(&states)?;
        }
        self.resume(graph, state);
        Ok(())
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
        let start = Interval::new(0, time, 0.0);
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

    fn restore(&self, graph: &mut Graph) -> Result<(), ParticipantError> {
        graph.units_mut().try_for_each(|unit| unit.restore_state())
    }
}
