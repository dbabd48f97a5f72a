//! The run: takes step after step and gives every report to every observer.

use crate::observer::{
    Checkpoint, Ending, Observer, ObserverError, Past, Start, Statistics, Status, WallTime,
};
use crate::participant::{Description, Occasion, Participant, ParticipantError};
use crate::run_state::{RunState, RunStateError};
use crate::scheme::{CouplingError, Exchange, Graph, Scheme, SchemeState, StepFailure, UnitId, WindowReport};
use crate::stepping::{Clock, Stepping};
use cofferdam_unit::{Fingerprint, StateError};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Coupled units and the scheme that steps them.
///
/// ```no_run
/// # use cofferdam_coupling::{scheme::{Graph, Scheme}, simulation::{Simulation, SimulationError}, stepping::Stepping};
/// # use std::sync::atomic::AtomicBool;
/// # fn run(graph: Graph, scheme: Scheme) -> Option<SimulationError> {
/// let mut simulation = Simulation::new(graph, scheme, Stepping::equal(0.01, 1000));
/// let (ending, failure) = simulation.run(&mut [], &AtomicBool::new(false));
/// println!("{} at t = {} s", ending.status, ending.time);
/// # failure
/// # }
/// ```
pub struct Simulation {
    /// The units.
    pub graph: Graph,
    /// The coupling scheme.
    pub scheme: Scheme,
    /// The communication steps.
    pub stepping: Stepping,
    /// Tests of units before the first step and during the run, of those that can save their state.
    pub unit_tests: Vec<(UnitId, Box<dyn UnitTest>)>,
    /// A variable that is read once after initialisation, by its unit and name.
    pub read_initially: Option<(UnitId, String)>,
    /// What was read; `None` before initialisation and where the unit does not have it.
    pub initial_values: Option<Vec<f64>>,
}

/// Tests a unit in the course of a run, such as whether it returns to its saved state.
///
/// **Call order**: after initialisation and after the windows of steps 1, 10, 100, …, when the unit has a past that it may not
/// save. The state at the end of the window is saved before; the unit is restored to it afterwards.
pub trait UnitTest: Send {
    /// Tests `unit`, which answered `exchange` last, with steps of `occasion`; `initially` if that was its initialisation.
    fn test(
        &self,
        unit: &mut dyn Participant,
        exchange: &Exchange,
        occasion: &Occasion,
        initially: bool,
    ) -> Result<(), ParticipantError>;
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// A step failed.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// An observer failed.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A state cannot be given or taken.
    #[error(transparent)]
    State(#[from] RunStateError),
}

/// Where a run stands between two windows: [`Simulation::waypoint`] gives it, [`Simulation::abandon`] returns to it.
pub struct Waypoint {
    scheme: SchemeState,
    course: Course,
}

/// Where a run stands, and what it has counted.
///
/// [`Simulation::run`] makes a run at once. One that is to be stopped and continued is made in parts: a course, then
/// [`begin`](Simulation::begin) or [`resume`](Simulation::resume), then [`advance`](Simulation::advance) until it tells how
/// the run ends, with [`state`](Simulation::state) in between.
#[derive(Clone)]
pub struct Course {
    clock: Clock,
    wall: WallTime,
    statistics: Statistics,
    began: Instant,
}

impl Simulation {
    /// A simulation of the units of `graph` by a `scheme` that was made for them.
    pub fn new(graph: Graph, scheme: Scheme, stepping: Stepping) -> Self {
        let (unit_tests, read_initially, initial_values) = (Vec::new(), None, None);
        Self { graph, scheme, stepping, unit_tests, read_initially, initial_values }
    }

    /// Runs until the end, the first failure, an observer's request to stop, or until `interrupted` becomes true.
    ///
    /// Observers receive the reports of initialisation and of every step, including a failed one, and at last the
    /// ending. A failure is returned beside the ending, whose status it is, also if it is one of ending.
    pub fn run(
        &mut self,
        observers: &mut [&mut dyn Observer],
        interrupted: &AtomicBool,
    ) -> (Ending, Option<SimulationError>) {
        let mut course = self.course();
        let begun = self.begin(&mut course, observers);
        self.conclude(&mut course, begun, observers, interrupted)
    }

    /// Goes on with a run that has `begun`, or that has [resumed](Self::resume), as [`run`](Self::run) does.
    pub fn conclude(
        &mut self,
        course: &mut Course,
        begun: Result<(), SimulationError>,
        observers: &mut [&mut dyn Observer],
        interrupted: &AtomicBool,
    ) -> (Ending, Option<SimulationError>) {
        let result = begun.and_then(|()| {
            loop {
                if interrupted.load(Ordering::Relaxed) {
                    return Ok(Status::Interrupted);
                }
                if let Some(status) = self.advance(course, observers)? {
                    return Ok(status);
                }
            }
        });
        let time = course.clock.time();
        let (wall, statistics) = (course.wall_time(), course.statistics.clone());
        let status = match &result {
            Ok(status) => status.clone(),
            Err(error) => Status::Failed(error.to_string()),
        };
        let mut ending = Ending { status, time, wall, statistics };
        let closed = tell_all(observers, |o| o.end(&ending));
        let failure = result.err().or(closed.err().map(Into::into));
        if let Some(error) = &failure {
            ending.status = Status::Failed(error.to_string());
        }
        (ending, failure)
    }

    /// The course of a run that has not begun.
    pub fn course(&self) -> Course {
        let units = || self.graph.units().map(|unit| unit.description().name.clone());
        let inside = units().map(|name| (name, Duration::ZERO)).collect();
        let calls = units().map(|name| (name, [0; 2])).collect();
        Course {
            clock: Clock::new(self.stepping),
            wall: WallTime { inside, ..WallTime::default() },
            statistics: Statistics { calls, ..Statistics::default() },
            began: Instant::now(),
        }
    }

    /// Initialises the units.
    ///
    /// **Errors**: a unit or an observer fails; the units do not fit the communication steps or the contract.
    pub fn begin(
        &mut self,
        course: &mut Course,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), SimulationError> {
        self.tell_start(observers)?;
        self.initialise(course, observers)
    }

    /// The same for observers who have been [told](Self::tell_start) that the run begins.
    ///
    /// **Errors**: as of [`begin`](Self::begin).
    pub fn initialise(
        &mut self,
        course: &mut Course,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), SimulationError> {
        match self.scheme.initialise(&mut self.graph, 0.0) {
            Ok(report) => {
                observe(observers, &report, course)?;
                inspect(observers, &mut self.graph, course)?;
                self.test_units(&report)?;
            }
            Err(failure) => return Err(failed(observers, failure, course)),
        }
        if let Some((unit, variable)) = &self.read_initially {
            self.initial_values = match self.graph[*unit].read(variable) {
                Ok(values) => Some(values),
                Err(ParticipantError::Missing { .. }) => None,
                Err(error) => return Err(CouplingError::from(error).into()),
            };
        }
        Ok(())
    }

    /// Tells observers that a run with these units begins.
    ///
    /// **Errors**: the units do not fit the communication steps; an observer fails.
    pub fn tell_start(&self, observers: &mut [&mut dyn Observer]) -> Result<(), SimulationError> {
        let start = Start {
            units: self.graph.units().map(|unit| unit.description().clone()).collect(),
            signals: self.scheme.signals(),
            stepping: self.stepping,
        };
        self.check_stepping(&start.units)?;
        Ok(tell_all(observers, |o| o.begin(&start))?)
    }

    /// Attempts the next window; returns how the run ends, if it ends with it or there is none.
    ///
    /// **Errors**: the window fails, or an observer.
    pub fn advance(
        &mut self,
        course: &mut Course,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Option<Status>, SimulationError> {
        let window = course.clock.window();
        if window.is_empty() {
            return Ok(Some(Status::Completed));
        }
        let began = Instant::now();
        let result = self.scheme.attempt(&mut self.graph, &window, course.clock.attempt());
        course.wall.coupling += began.elapsed();
        match result {
            Ok(mut report) => {
                course.statistics.fallbacks += u64::from(report.fallbacks > 0);
                let taken = course.clock.takes(&report);
                if !taken {
                    "started again in shorter steps: the coupling error is too large"
                        .clone_into(&mut report.outcome);
                } else {
                    self.scheme.accept(&mut report);
                    course.clock.accept(&report);
                }
                course.statistics.rejected += u64::from(!taken);
                observe(observers, &report, course)?;
                if taken {
                    inspect(observers, &mut self.graph, course)?;
                    // Not at the end, where units are read once more: a test leaves them to be put back with their next step.
                    if self.is_to_test(&report)
                        && !self.is_over(course)
                        && observers.iter().all(|observer| observer.ends().is_none())
                    {
                        self.test_units(&report)?;
                    }
                    if let Some(wanted) = observers.iter().find_map(|observer| observer.wants_checkpoint()) {
                        self.save(course, &wanted, observers)?;
                    }
                }
            }
            Err(failure)
                if failure.error.is_of_coupling()
                    && course.clock.shorten(failure.report.end() - failure.report.time()) =>
            {
                course.statistics.rejected += 1;
                observe(observers, &failure.report, course)?;
            }
            Err(failure) => return Err(failed(observers, failure, course)),
        }
        Ok(observers.iter().find_map(|observer| observer.ends()))
    }

    /// Whether no window is left.
    pub fn is_over(&self, course: &Course) -> bool {
        course.clock.window().is_empty()
    }

    /// Hash of all that a run is made from; only runs with the same hash exchange states.
    pub fn fingerprint(&self) -> Result<Fingerprint, StateError> {
        let signals: Vec<_> =
            self.scheme.signals().iter().map(|s| (&s.input, s.interval, &s.samples)).collect();
        let scheme = self.scheme.fingerprint();
        // As before where there are only first ones.
        let components: Vec<_> = self.scheme.signals().iter().map(|signal| signal.component).collect();
        match components.iter().all(|component| *component == 0) {
            true => Fingerprint::of("run", &(scheme, self.stepping, signals)),
            false => Fingerprint::of("run", &(scheme, self.stepping, signals, components)),
        }
    }

    /// The state of the run at the end of the last accepted window. The units give theirs at the same time:
    /// [`Graph::serialise`].
    ///
    /// **Errors**: [`RunStateError::InsideWindow`] after a window that was not accepted.
    pub fn state(&self, course: &Course) -> Result<RunState, RunStateError> {
        let time = course.clock.time();
        Ok(RunState {
            fingerprint: self.fingerprint()?,
            scheme: self.scheme.state().ok_or(RunStateError::InsideWindow { time })?,
            clock: course.clock.clone(),
            statistics: course.statistics.clone(),
            wall: course.wall_time(),
            initial_values: self.initial_values.clone(),
        })
    }

    /// Where the run stands, to [return](Self::abandon) to it if the next window fails; `None` inside a window that failed. It takes
    /// no states of the units, which keep their own during a window.
    pub fn waypoint(&self, course: &Course) -> Option<Waypoint> {
        Some(Waypoint { scheme: self.scheme.state()?, course: course.clone() })
    }

    /// Returns to the `before` of a window that failed. Whatever follows is as if the window had never been attempted, bit for bit.
    ///
    /// **Errors**: a unit does not return to its state, or does not write it.
    pub fn abandon(&mut self, course: &mut Course, before: Waypoint) -> Result<(), SimulationError> {
        self.scheme.abandon(&mut self.graph, &before.scheme)?;
        *course = before.course;
        Ok(())
    }

    /// Tells observers what came before, in place of [`begin`](Self::begin); then [`resume`](Self::resume) continues.
    ///
    /// **Errors**: the past cannot be read; an observer fails.
    pub fn retell<E: From<SimulationError>>(
        &self,
        past: impl IntoIterator<Item = Result<Past, E>>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), E> {
        self.tell_start(observers)?;
        self.tell_past(past, observers)
    }

    /// The same for observers who have been [told](Self::tell_start) that the run begins.
    ///
    /// **Errors**: as of [`retell`](Self::retell).
    pub fn tell_past<E: From<SimulationError>>(
        &self,
        past: impl IntoIterator<Item = Result<Past, E>>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), E> {
        for past in past {
            let told = match past? {
                Past::Window(report) => tell_all(observers, |o| o.past(&report)),
                Past::Checkpoint(checkpoint) => tell_all(observers, |o| o.checkpoint(&checkpoint)),
            };
            told.map_err(SimulationError::from)?;
        }
        Ok(())
    }

    /// Goes on from `state` with units that [`Graph::deserialise`] has put where they were.
    ///
    /// **Errors**: the state is of another run.
    pub fn resume(&mut self, course: &mut Course, state: &RunState) -> Result<(), RunStateError> {
        let expected = self.fingerprint()?;
        if state.fingerprint != expected {
            return Err(StateError::Fingerprint { found: state.fingerprint, expected }.into());
        }
        self.scheme.resume(&mut self.graph, &state.scheme);
        self.initial_values.clone_from(&state.initial_values);
        course.clock.clone_from(&state.clock);
        course.statistics.clone_from(&state.statistics);
        course.wall.clone_from(&state.wall);
        Ok(())
    }

    /// Goes on from the state of a run with other settings, or with other units, which exchange the same variables: what was learnt
    /// is kept as far as it holds here.
    ///
    /// **Errors**: the communication steps of this run have no beginning at that time.
    pub fn branch(&mut self, course: &mut Course, state: &RunState) -> Result<(), RunStateError> {
        let time = state.clock.time();
        let stepping = self.stepping;
        let clock = state
            .clock
            .with(stepping)
            .ok_or(RunStateError::OffGrid { time, communication_step: stepping.communication_step })?;
        self.scheme.branch(&mut self.graph, &state.scheme)?;
        self.initial_values.clone_from(&state.initial_values);
        course.clock = clock;
        course.statistics.clone_from(&state.statistics);
        // The state's has the time since this course began.
        (course.wall, course.began) = (state.wall.clone(), Instant::now());
        Ok(())
    }

    /// Gives the observers a checkpoint, with the states of the units that are `wanted`.
    ///
    /// **Errors**: inside a window that was not accepted; a unit or an observer fails.
    pub fn save(
        &mut self,
        course: &mut Course,
        wanted: &[bool],
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), SimulationError> {
        let began = Instant::now();
        let run = self.state(course)?.to_bytes().map_err(RunStateError::from)?;
        let units = self.graph.states(wanted).map_err(CouplingError::from)?;
        let (step, time) = (course.clock.taken(), course.clock.time());
        let checkpoint = Checkpoint { step, time, run, units };
        let told = tell_all(observers, |o| o.checkpoint(&checkpoint));
        course.wall.checkpoints += began.elapsed();
        Ok(told?)
    }

    /// Whether units are tested at the end of a window.
    fn is_to_test(&self, report: &WindowReport) -> bool {
        !self.unit_tests.is_empty() && report.steps.iter().any(|interval| is_power_of_ten(interval.step))
    }

    /// Tests units at the end of an accepted window, each with what it was given there.
    fn test_units(&mut self, report: &WindowReport) -> Result<(), CouplingError> {
        let last = report.steps.last().map_or(0, |interval| interval.step);
        for (id, test) in &self.unit_tests {
            let exchange = report.accepted(*id, last);
            if let Some(exchange) =
                exchange.filter(|_| self.graph[*id].description().capabilities.saved_state)
            {
                let length = match exchange.occasion.communication_step {
                    0.0 => self.stepping.communication_step,
                    length => length,
                };
                // A unit may refuse a step beyond the end of the run, which it was told.
                let rest = self.stepping.end() - report.end();
                let occasion = Occasion {
                    step: last + 1,
                    iteration: 1,
                    attempt: 1,
                    time: report.end(),
                    communication_step: if rest < length * (1.0 - 1e-9) { rest } else { length },
                };
                test.test(&mut self.graph[*id], exchange, &occasion, last == 0)?;
            }
        }
        Ok(())
    }

    /// Refuses steps of varying length for a unit that needs a fixed one.
    fn check_stepping(&self, units: &[Description]) -> Result<(), CouplingError> {
        let fixed = units.iter().find(|unit| !unit.capabilities.variable_communication_step);
        match fixed {
            Some(unit) if self.stepping.varies() => {
                Err(CouplingError::FixedStep { participant: unit.name.clone() })
            }
            _ => Ok(()),
        }
    }
}

impl Course {
    /// Time reached, s.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Number of steps taken.
    pub fn steps(&self) -> u64 {
        self.clock.taken()
    }

    /// What was counted.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The wall times so far, those of the run that it continues included.
    fn wall_time(&self) -> WallTime {
        WallTime { total: self.wall.total + self.began.elapsed(), ..self.wall.clone() }
    }
}

/// Gives the partial report of a failed window to the observers; returns the error that ends the run.
fn failed(observers: &mut [&mut dyn Observer], failure: StepFailure, course: &mut Course) -> SimulationError {
    let StepFailure { report, error } = failure;
    // The failure of the coupling is reported; one of an observer would hide it.
    let _ = observe(observers, &report, course);
    error.into()
}

/// Gives a report to the observers and adds it to the tally.
fn observe(
    observers: &mut [&mut dyn Observer],
    report: &WindowReport,
    course: &mut Course,
) -> Result<(), SimulationError> {
    let Course { wall, statistics, .. } = course;
    if report.step() > 0 {
        for ((_, sum), time) in wall.inside.iter_mut().zip(&report.solver_time) {
            *sum += *time;
        }
        wall.units += report.unit_time;
    } else {
        wall.initialisation += report.solver_time.iter().sum::<Duration>();
    }
    for (number, (_, calls)) in statistics.calls.iter_mut().enumerate() {
        let [all, repeated] = report.calls(UnitId(number));
        (calls[0], calls[1]) = (calls[0] + all, calls[1] + repeated);
    }
    if report.step() > 0 {
        let steps = report.steps.len() as u64;
        statistics.unconverged += if report.is_accepted() && !report.converged { steps } else { 0 };
    }
    let errors = report.interfaces.iter().flatten().map(|interface| interface.mapping_error);
    statistics.mapping_error = errors.fold(statistics.mapping_error, f64::max);
    if report.is_accepted() {
        statistics.largest = statistics.largest.max(report.largest);
    }
    statistics.rounding_floor = report.rounding_floor.or(statistics.rounding_floor);
    let began = Instant::now();
    let told = tell_all(observers, |o| o.window(report));
    wall.observers += began.elapsed();
    Ok(told?)
}

/// Lets the observers read the units.
fn inspect(
    observers: &mut [&mut dyn Observer],
    graph: &mut Graph,
    course: &mut Course,
) -> Result<(), SimulationError> {
    let began = Instant::now();
    let told = tell_all(observers, |o| o.inspect(graph));
    course.wall.observers += began.elapsed();
    Ok(told?)
}

/// Calls every observer, even after one has failed; returns the first failure.
fn tell_all(
    observers: &mut [&mut dyn Observer],
    mut tell: impl FnMut(&mut dyn Observer) -> Result<(), ObserverError>,
) -> Result<(), ObserverError> {
    observers.iter_mut().map(|o| tell(*o)).fold(Ok(()), Result::and)
}

fn is_power_of_ten(number: u64) -> bool {
    (0..20).any(|exponent| 10u64.checked_pow(exponent) == Some(number))
}

#[cfg(test)]
mod tests {
    use super::is_power_of_ten;

    #[test]
    fn powers_of_ten_are_found() {
        assert!((0..=1000).filter(|number| is_power_of_ten(*number)).eq([1, 10, 100, 1000]));
        assert!(is_power_of_ten(10u64.pow(19)) && !is_power_of_ten(u64::MAX));
    }
}
